//! From the columns of the image to the 21 fixed points of a profile.
//!
//! At each point a straight line is fitted to the samples within [`REACH_M`], weighted by
//! `w = 1 - (d / reach)^2` (Epanechnikov): it smooths over neighbouring columns, and unlike a mean
//! it is not biased where the samples lie to one side of the point or the surface is tilted.

use super::depth::Sample;
use super::profile::{POINTS, profile_abscissa};

/// Half width of the fit, metres: four columns at the middle of the glass.
const REACH_M: f32 = 2.6e-3;
/// A point is valid only with samples on both sides of it, the farther side reaching this near, metres.
const BESIDE_M: f32 = 2.6e-3;
/// Fewest samples of a fit.
const LEAST_SAMPLES: usize = 3;

/// Heights and validity of the profile points of a glass of radius `radius_m`.
pub(super) fn resample(samples: &[Sample], radius_m: f32) -> ([f32; POINTS], [bool; POINTS]) {
    let mut height_m = [0.0; POINTS];
    let mut valid = [false; POINTS];
    for ((index, height), valid) in height_m.iter_mut().enumerate().zip(valid.iter_mut()) {
        let x_m = profile_abscissa(index) as f32 * radius_m;
        if let Some(z_m) = fit(samples, x_m) {
            (*height, *valid) = (z_m, true);
        }
    }
    (height_m, valid)
}

/// Weighted least squares `z = c + s d`, `d = x - x_point`, in closed form:
///
/// `c = (S_dd S_z - S_d S_dz) / (S S_dd - S_d^2)`, where `S_.` are weighted sums.
fn fit(samples: &[Sample], x_m: f32) -> Option<f32> {
    let (mut s, mut s_d, mut s_dd, mut s_z, mut s_dz) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let (mut count, mut left, mut right) = (0_usize, false, false);
    for sample in samples {
        let d = (sample.x_m - x_m) / REACH_M;
        let w = 1.0 - d * d;
        if w > 0.0 {
            s += w;
            s_d += w * d;
            s_dd += w * d * d;
            s_z += w * sample.z_m;
            s_dz += w * d * sample.z_m;
            count += 1;
            left |= d <= 0.0 && -d * REACH_M < BESIDE_M;
            right |= d >= 0.0 && d * REACH_M < BESIDE_M;
        }
    }
    let determinant = s * s_dd - s_d * s_d;
    let sound = count >= LEAST_SAMPLES && left && right && determinant > 1e-4 * s * s;
    sound.then(|| (s_dd * s_z - s_d * s_dz) / determinant)
}
