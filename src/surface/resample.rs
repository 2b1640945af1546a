//! From the columns of the image to the 21 fixed points of a profile, with their variance.
//!
//! At each point a straight line is fitted to the samples within a reach `h`, weighted by
//! `w = 1 - (d / h)^2` (Epanechnikov): it smooths over neighbouring columns, and unlike a mean it is not
//! biased where the samples lie to one side of the point or the surface is tilted. Samples farther from
//! the line than three robust standard deviations are left out and the line is fitted again.
//!
//! # Variance
//!
//! `var = s^2 sum a_k^2 + (u s_w)^2 + mean(v_k) + b^2`, where the height is `sum a_k z_k`:
//!
//! * `s`: scatter of a column's edge, from the residuals of the fit, drawn towards [`EDGE_PX`] where they are
//!   few;
//! * `u s_w`: standard error `s_w` of the wall's measured distance, which all columns share, times the ray's rise `u`;
//! * `v_k`: what moving a sample down from liquid behind it adds;
//! * `b`: what is left of the biases (blur on a curved edge, sub-pixel error), [`BIAS_PX`] and [`BIAS_M`],
//!   calibrated on rendered scenes.

use super::config::Config;
use super::edge_points::Sample;
use super::profile::{POINTS, profile_abscissa};
use crate::math::{median, sqrtf};

/// Half width of the fit, metres (four columns at the middle of the default glass) and pixels: the larger.
const REACH_M: f32 = 2.6e-3;
const REACH_PX: f32 = 2.4;
/// Fewest samples of a fit.
const LEAST_SAMPLES: usize = 3;
/// Usual scatter of a column's edge, pixels, and how many samples it counts for.
const EDGE_PX: f32 = 0.10;
const EDGE_COUNT: f32 = 4.0;
/// Remaining bias.
const BIAS_PX: f32 = 0.10;
const BIAS_M: f32 = 5e-5;
/// An outlier is farther from the line than this many robust standard deviations, and than this many pixels.
const OUTLIER: f32 = 3.0;
const OUTLIER_PX: f32 = 0.4;
/// From a median of absolute deviations to the standard deviation of normal noise.
const NORMAL: f32 = 1.4826;

/// The points of a profile.
pub(super) struct Points {
    pub(super) height_m: [f32; POINTS],
    pub(super) variance_m2: [f32; POINTS],
    pub(super) valid: [bool; POINTS],
}

/// A fitted line.
#[derive(Clone, Copy)]
struct Line {
    height_m: f32,
    /// Rise over the reach.
    slope_m: f32,
    /// `sum a_k^2`.
    gain: f32,
    /// Weighted sum of squared residuals, and of weights.
    squares_m2: f32,
    weight: f32,
    /// Weighted means of the rays' rise and of the samples' own variance.
    rise: f32,
    own_m2: f32,
}

/// Heights, variances and validity of the profile points; `scatter_m` is the standard error of the wall's
/// distance.
pub(super) fn resample(config: &Config, samples: &[Sample], scatter_m: f32) -> Points {
    let pixel_m = config.camera.pitch_m();
    let reach_m = REACH_M.max(REACH_PX * pixel_m);
    let mut points = Points { height_m: [0.0; POINTS], variance_m2: [0.0; POINTS], valid: [false; POINTS] };
    let places = points.height_m.iter_mut().zip(&mut points.variance_m2).zip(&mut points.valid);
    for (index, ((height, variance), valid)) in places.enumerate() {
        let x_m = profile_abscissa(index) as f32 * config.settings.radius_m;
        if let Some(line) = robust(samples, x_m, reach_m, pixel_m) {
            let usual = EDGE_PX * pixel_m;
            let edge = (EDGE_COUNT * usual * usual + line.squares_m2) / (EDGE_COUNT + line.weight);
            let wall = line.rise * scatter_m;
            let bias = BIAS_PX * pixel_m;
            *variance = edge * line.gain + wall * wall + line.own_m2 + bias * bias + BIAS_M * BIAS_M;
            (*height, *valid) = (line.height_m, true);
        }
    }
    points
}

/// Fits, leaves outliers out, fits again.
fn robust(samples: &[Sample], x_m: f32, reach_m: f32, pixel_m: f32) -> Option<Line> {
    let first = fit(samples, x_m, reach_m, &|_| true)?;
    let off = |sample: &Sample| {
        let d = (sample.x_m - x_m) / reach_m;
        (sample.z_m - first.height_m - first.slope_m * d).abs()
    };
    let near = samples.iter().filter(|sample| (sample.x_m - x_m).abs() < reach_m);
    let usual = median(near.map(off))?;
    let limit = (OUTLIER * NORMAL * usual).max(OUTLIER_PX * pixel_m);
    fit(samples, x_m, reach_m, &|sample| off(sample) <= limit)
}

/// Weighted least squares `z = c + s d`, `d = (x - x_point) / h`, in closed form:
///
/// `c = (S_dd S_z - S_d S_dz) / (S S_dd - S_d^2)`, where `S_.` are weighted sums; so `a_k = w_k (S_dd - S_d d_k)`
/// over the same determinant, and `sum a_k^2` follows from the sums over `w^2`.
fn fit(samples: &[Sample], x_m: f32, reach_m: f32, kept: &impl Fn(&Sample) -> bool) -> Option<Line> {
    let inside = || {
        samples.iter().filter(|sample| kept(sample)).filter_map(|sample| {
            let d = (sample.x_m - x_m) / reach_m;
            let w = 1.0 - d * d;
            (w > 0.0).then_some((sample, d, w))
        })
    };
    let (mut s, mut s_d, mut s_dd, mut s_z, mut s_dz) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let (mut rise, mut own_m2) = (0.0, 0.0);
    let (mut count, mut left, mut right) = (0_usize, false, false);
    for (sample, d, w) in inside() {
        s += w;
        s_d += w * d;
        s_dd += w * d * d;
        s_z += w * sample.z_m;
        s_dz += w * d * sample.z_m;
        rise += w * sample.rise;
        own_m2 += w * sample.own_m2;
        count += 1;
        // A point is valid only with samples on both sides of it.
        left |= d <= 0.0;
        right |= d >= 0.0;
    }
    let determinant = s * s_dd - s_d * s_d;
    let sound = count >= LEAST_SAMPLES && left && right && determinant > 1e-4 * s * s;
    sound.then(|| {
        let height_m = (s_dd * s_z - s_d * s_dz) / determinant;
        let slope_m = (s * s_dz - s_d * s_z) / determinant;
        let mut line = Line {
            height_m,
            slope_m,
            gain: 0.0,
            squares_m2: 0.0,
            weight: s,
            rise: rise / s,
            own_m2: own_m2 / s,
        };
        for (sample, d, w) in inside() {
            let a = w * (s_dd - s_d * d) / determinant;
            let residual = sample.z_m - height_m - slope_m * d;
            line.gain += a * a;
            line.squares_m2 += w * residual * residual;
        }
        line
    })
}

/// Standard error of the median of `count` numbers with the median absolute deviation `deviation`, of
/// which `group` neighbours tell the same.
pub(super) fn median_error(deviation: f32, count: usize, group: f32) -> f32 {
    // sqrt(pi / 2) sigma / sqrt(n), for normal noise.
    1.2533 * NORMAL * deviation / sqrtf((count as f32 / group).max(1.0))
}
