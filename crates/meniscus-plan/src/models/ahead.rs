//! Variance of the ends of the wall in all frames ahead, without the covariance of each of them.
//!
//! ```text
//! P(k+1) = A P(k) A^T + w(k) Q
//! e P(n) e^T = e_n P(0) e_n^T + sum_(k < n) w(k) q_(n-1-k)       e_m = e A^m,  q_m = e_m Q e_m^T
//! ```
//! e_m and q_m are those of the model. A frame then takes a quadratic form and a sum in place of two products of matrices.

use meniscus::latent::generic::{LATENTS, Latent};
use nalgebra::SMatrix;

/// Matrix on latent space.
type Square = SMatrix<f64, LATENTS, LATENTS>;

/// Frames that are covered: those of the longest plan, 12 s and half a second of tail.
pub(super) const FRAMES: usize = 750;

/// e_m of one end, and q_m, frame by frame.
#[derive(Debug)]
pub(super) struct EndAhead {
    slopes: Vec<Latent>,
    noise_m2: Vec<f64>,
}

impl EndAhead {
    /// Returns those of an end with the slope `slope` under A and Q.
    pub(super) fn new(slope: &Latent, transition: &Square, process: &Square) -> Self {
        let back = transition.transpose();
        let slopes: Vec<Latent> =
            std::iter::successors(Some(*slope), |slope| Some(back * slope)).take(FRAMES + 1).collect();
        let noise_m2 = slopes.iter().map(|slope| slope.dot(&(process * slope))).collect();
        Self { slopes, noise_m2 }
    }

    /// Returns the variance behind as many frames as there are `weights`, which are w of each frame before, from `covariance` on, m2.
    pub(super) fn variance_m2(&self, covariance: &Square, weights: &[f64]) -> f64 {
        let slope = &self.slopes[weights.len()];
        let noise = weights.iter().rev().zip(&self.noise_m2).map(|(weight, noise)| weight * noise);
        slope.dot(&(covariance * slope)) + noise.sum::<f64>()
    }
}
