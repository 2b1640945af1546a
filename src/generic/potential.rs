//! The energy H(x), bounded below, smallest at rest, with its gradient.
//!
//! ```text
//! H(x) = |K x|^2 / 2 + |f(x)|^2 / 2,   f(x) = W2 (r(W1 x + b1) - r(b1)),   r(a) = a / sqrt(1 + a^2)
//! grad H = K^T K x + W1^T [ r'(W1 x + b1) * W2^T f(x) ],                   r'(a) = (1 + a^2)^(-3/2)
//! ```
//! H >= 0, H(0) = 0 and grad H(0) = 0 for every choice of weights, so rest is an equilibrium.

use super::{LATENTS, Latent};
use crate::math::sqrt;
use crate::nn::{Matrix, Vector};

/// Hidden units and outputs of f that the step has room for.
pub const MAX_HIDDEN: usize = 64;

/// Weights of the energy, read in place.
#[derive(Clone, Copy, Debug)]
pub struct Potential<'m> {
    /// K, `[LATENTS, LATENTS]`.
    pub linear: Matrix<'m>,
    /// W1, `[hidden, LATENTS]`.
    pub inward: Matrix<'m>,
    /// b1, `[hidden]`.
    pub bias: Vector<'m>,
    /// W2, `[outputs, hidden]`.
    pub outward: Matrix<'m>,
}

impl Potential<'_> {
    /// H(x).
    #[must_use]
    pub fn value(&self, x: &Latent) -> f64 {
        let (kx, f, _) = self.forward(x);
        half_square(&kx) + half_square(&f)
    }

    /// grad H(x).
    #[must_use]
    pub fn gradient(&self, x: &Latent) -> Latent {
        let (kx, f, slope) = self.forward(x);
        let mut gradient = Latent::zeros();
        self.linear.accumulate_transposed_f64(&kx, gradient.as_mut_slice());
        let mut back = [0.0; MAX_HIDDEN];
        self.outward.accumulate_transposed_f64(&f, &mut back);
        for (b, slope) in back.iter_mut().zip(slope) {
            *b *= slope;
        }
        self.inward.accumulate_transposed_f64(&back, gradient.as_mut_slice());
        gradient
    }

    /// K x, f(x) and r'(W1 x + b1).
    fn forward(&self, x: &Latent) -> ([f64; LATENTS], [f64; MAX_HIDDEN], [f64; MAX_HIDDEN]) {
        let mut kx = [0.0; LATENTS];
        self.linear.accumulate_f64(x.as_slice(), &mut kx);
        let mut hidden = [0.0; MAX_HIDDEN];
        self.inward.accumulate_f64(x.as_slice(), &mut hidden);
        let mut slope = [0.0; MAX_HIDDEN];
        for ((a, slope), &b1) in hidden.iter_mut().zip(&mut slope).zip(self.bias) {
            let b1 = f64::from(b1);
            let sum = *a + b1;
            let q = 1.0 / (1.0 + sum * sum);
            let root = sqrt(q);
            *slope = q * root;
            *a = sum * root - b1 / sqrt(1.0 + b1 * b1);
        }
        let mut f = [0.0; MAX_HIDDEN];
        self.outward.accumulate_f64(&hidden, &mut f);
        (kx, f, slope)
    }
}

/// |v|^2 / 2.
fn half_square(v: &[f64]) -> f64 {
    0.5 * v.iter().map(|v| v * v).sum::<f64>()
}
