//! Liquid behind the contact line that neither image tells from the front: how much of it there may be.
//!
//! A band thinner than a pixel and a half is noticed by no step in tone and by no row of depth. Whether
//! there may be one follows from the profile itself: it is that of the first mode,
//!
//! `z(x, y) = c + (A x + B y) g(r / R) / r`, `g(s) = J1(k s) / J1(k)`, `k = 1.8412` (upright circular glass; Ibrahim,
//! Liquid Sloshing Dynamics, 2005), whose contact line is fitted ([`FirstMode`]). The surface at `(x, y)` shows above it by
//!
//! `h = (z(x, y) - H) (D - y0) / (D + y) - (z(x, -y0) - H)`, `y0 = sqrt(R^2 - x^2)`, camera at distance `D` and height `H`.
//!
//! The height is lowered by [`USUAL`] of what may be hidden, and [`DOUBT`] of it is a standard deviation.

use super::config::Config;
use super::edge_points::{Sample, Samples};
use super::first_mode::FirstMode;
use super::settings::Liquid;
use crate::math::sqrtf;

/// Points along the line of sight through the glass.
const CHORD: usize = 8;
/// Share of what may be hidden that usually is, and its standard deviation.
const USUAL: f32 = 0.25;
const DOUBT: f32 = 0.5;
/// Moves to faint bands are taken back if the first mode then lies nearer to the points than this share.
const BETTER: f32 = 0.75;
/// Times that the mode is fitted anew without the moves that were taken back.
const ROUNDS: usize = 2;

/// Lowers the samples by a share of what may be hidden beyond what each was lowered already.
pub(super) fn allow(config: &Config, samples: &mut Samples) {
    let Some(mode) = first_mode(config, samples, 0.0) else { return };
    for sample in samples.iter_mut() {
        let hidden_m =
            (shown_m(config, mode, sample.x_m) - sample.lowered_m).max(0.0).min(config.camera.pitch_m());
        sample.z_m -= USUAL * hidden_m;
        sample.own_m2 += (DOUBT * hidden_m) * (DOUBT * hidden_m);
    }
}

/// Takes back moves down to faint bands that roughen the contact line.
///
/// A liquid that shines through darkens towards its own end, and looks there as if another surface showed behind the
/// contact line, here and there as its noise has it. A contact line that was moved down rightly lies on that of a
/// first mode; one that was moved down for such a tail does so far better before the move.
pub(super) fn take_back(config: &Config, samples: &mut Samples) {
    let moved = samples.iter().fold(0.0, |sum, sample| sum + sample.faint_m);
    if moved <= 0.0 {
        return;
    }
    let scatter = |raised: f32| {
        let mode = first_mode(config, samples, raised)?;
        let off = samples
            .iter()
            .map(|sample| (sample.z_m + raised * sample.faint_m - mode.contact_m(sample.x_m)).abs());
        Some(off.fold(0.0, |sum, off| sum + off))
    };
    let (Some(lowered), Some(raised)) = (scatter(0.0), scatter(1.0)) else { return };
    if raised < BETTER * lowered {
        samples.iter_mut().for_each(raise);
    } else if config.settings.liquid == Liquid::Bright {
        take_back_alone(config, samples);
    }
}

/// Takes back single moves after which a point lies farther from the first mode than before: among columns with a band,
/// others have a tail.
fn take_back_alone(config: &Config, samples: &mut Samples) {
    for _ in 0..ROUNDS {
        let Some(mode) = first_mode(config, samples, 0.0) else { return };
        let off = |sample: &Sample, z_m: f32| (z_m - mode.contact_m(sample.x_m)).abs();
        for sample in samples.iter_mut() {
            if off(sample, sample.z_m + sample.faint_m) < BETTER * off(sample, sample.z_m) {
                raise(sample);
            }
        }
    }
}

/// Takes the move of a sample back.
fn raise(sample: &mut Sample) {
    sample.z_m += sample.faint_m;
    sample.lowered_m -= sample.faint_m;
    sample.own_m2 -= sample.faint_m2;
    (sample.faint_m, sample.faint_m2) = (0.0, 0.0);
}

/// Most of the surface that shows above the contact line at `x`, metres.
fn shown_m(config: &Config, mode: FirstMode, x_m: f32) -> f32 {
    let settings = &config.settings;
    let (distance, height) = (settings.camera_distance_m, settings.camera_height_m);
    let FirstMode { mean_m: c, along: a, towards: b, radius_m: radius } = mode;
    let x = x_m.max(-radius).min(radius);
    let y0 = mode.front_m(x);
    let contact_m = mode.contact_m(x);
    let shown = (1..=CHORD).map(|part| {
        let y = y0 * (2.0 * part as f32 / CHORD as f32 - 1.0);
        let r = sqrtf(x * x + y * y).max(1e-6);
        // g(s) / s is what a plane of the same contact line is multiplied by.
        let z = c + (a * x + b * y) * bulge(r / radius);
        (z - height) * (distance - y0) / (distance + y) - (contact_m - height)
    });
    shown.fold(0.0, f32::max)
}

/// `J1(k s) / (s J1(k))` by its power series, `k = 1.8412`.
fn bulge(s: f32) -> f32 {
    let q = s * s;
    (1.0 - q * (0.423_75 - q * (0.059_85 - q * 0.004_23))) / 0.631_87
}

/// The first mode nearest to the samples, the share `raised` of the moves to faint bands taken back.
fn first_mode(config: &Config, samples: &[Sample], raised: f32) -> Option<FirstMode> {
    let points = samples.iter().map(|sample| (sample.x_m, sample.z_m + raised * sample.faint_m));
    FirstMode::fit(config, points)
}
