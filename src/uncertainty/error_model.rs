//! Error model of a blob: covariances of the step, the encoder and the decoder.
//!
//! ```text
//! <step error^2> = w Q,   <encoder error^2> = w R,   <decoder error^2> = w d,      w = floor + H(x)
//! ```
//! Each is stated for a unit of w: the larger the slosh, the larger the errors. A is the closed step linearised about
//! rest, J the slope of a height or of a number of a field group in the latents.
//! [`Interval`](super::intervals::Interval) follows from these and from the covariance of the filter.

use crate::latent::generic::LATENTS;
use crate::latent::nn::Vector;
use crate::surface::POINTS;
use crate::uncertainty::error_factors::ErrorFactors;
use nalgebra::SMatrix;

/// Matrix on latent space.
type Square = SMatrix<f64, LATENTS, LATENTS>;

/// Groups with a covariance of their own: q, v, sigma, tau.
pub const SPREAD_GROUPS: usize = 4;

/// Positions of these groups among those of the decoder.
pub(crate) const SPREAD_OF: [usize; SPREAD_GROUPS] = [0, 1, 3, 4];

/// Errors of a model as its blob states them, read in place.
#[derive(Clone, Debug)]
pub struct ErrorModel<'m> {
    /// A.
    pub transition: Square,
    /// Q.
    pub process: Square,
    /// R^(-1/2): in these coordinates the encoder's errors are independent and of variance one.
    pub reading: Square,
    /// J of the surface, a column a point `[LATENTS, POINTS]`, m.
    pub surface: SMatrix<f64, LATENTS, POINTS>,
    /// J^T J of one number of q, v, sigma and tau, SI units.
    pub groups: [Square; SPREAD_GROUPS],
    /// Mean square of what a unit of the port adds at once to one number of q, v, sigma and tau, SI units squared.
    pub pushed: [f64; SPREAD_GROUPS],
    /// d of the 21 heights, m2.
    pub surface_misfit: Vector<'m>,
    /// d of q, v, sigma, tau, SI units squared.
    pub group_misfit: Vector<'m>,
    /// Floor of w, k and g.
    pub factors: ErrorFactors,
}

/// Errors of the filter's state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covariance {
    /// P of the latents.
    pub(crate) latents: Square,
    /// Variance of the input of this instant.
    pub(crate) input: f64,
    /// Factor on Q that the filter has found of late.
    pub(crate) process_noise_scale: f64,
}

/// Returns P before the first reading, when nothing is known: a slosh of H = 1, spread over all latents.
#[must_use]
pub(crate) fn unknown() -> Square {
    Square::identity() * (2.0 / LATENTS as f64)
}

impl ErrorModel<'_> {
    /// Returns w of a slosh of energy `latent_energy`, in units of H.
    pub(crate) fn weight(&self, latent_energy: f64) -> f64 {
        f64::from(self.factors.weight_floor) + latent_energy
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    const FACTORS: ErrorFactors = ErrorFactors {
        weight_floor: 0.1,
        surface: [2.0, 4.0, 3.0],
        field: [1.0; 5],
        rest_noise_std_m: 0.0,
        planned: [3.0, 5.0],
        crest: 6.0,
        disagreement: 1.4,
    };

    /// J of one for the first latent at every point, nothing else.
    pub(crate) fn error_model() -> ErrorModel<'static> {
        ErrorModel {
            transition: Square::identity() * 0.9,
            process: Square::identity() * 0.01,
            reading: Square::identity(),
            surface: SMatrix::from_fn(|i, _| if i == 0 { 0.01 } else { 0.0 }),
            groups: [Square::zeros(); SPREAD_GROUPS],
            pushed: [0.0, 9.0, 0.0, 0.0],
            surface_misfit: &[1e-8; POINTS],
            group_misfit: &[4.0; SPREAD_GROUPS],
            factors: FACTORS,
        }
    }

    /// H is |x|^2 / 2 in latents of unit stiffness: its mean is one, and no direction is preferred.
    #[test]
    fn nothing_known_is_a_slosh_of_one_in_any_direction() {
        let p = unknown();
        assert!((0.5 * p.trace() - 1.0).abs() < 1e-12, "{}", p.trace());
        assert!((p - Square::identity() * p.trace() / LATENTS as f64).norm() < 1e-12);
    }

    #[test]
    fn the_weight_is_the_floor_at_rest_and_grows_with_the_slosh() {
        let errors = error_model();
        assert!((errors.weight(0.0) - 0.1).abs() < 1e-8);
        assert!((errors.weight(2.0) - 2.1).abs() < 1e-8);
    }
}
