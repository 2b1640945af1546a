//! The correction of the prediction by the encoder's latent.
//!
//! ```text
//! x+ = x- + G (y - x-)
//! ```
//! with the constant gain G that the covariances of prediction and measurement gave in training
//! (the steady Kalman gain of the pair; Kalman 1960). The laws speak of the predicting step; what
//! the correction does to the energy is booked apart as `corrected`.

use crate::generic::Latent;
use crate::nn::Matrix;

/// x- + G (y - x-).
pub(super) fn correct(gain: &Matrix<'_>, predicted: &Latent, measured: &Latent) -> Latent {
    let innovation = measured - predicted;
    let mut corrected = *predicted;
    gain.accumulate_f64(innovation.as_slice(), corrected.as_mut_slice());
    corrected
}
