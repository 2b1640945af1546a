//! One model on one recording: errors, crests, laws, forecasts.

use crate::generic::Latent;
use crate::host::live::Logged;
use crate::model::Model;
use crate::offline::baseline::linear_with_motion;
use crate::offline::camera::START;
use crate::offline::prelude::*;
use crate::offline::recording::Recording;
use crate::offline::score::{Score, SurfaceError, score};
use crate::offline::train::correct::Sightings;
use crate::offline::watching::turns;
use crate::runtime::{Mode, surface_ahead};
use crate::surface::POINTS;
use crate::units::FRAME_INTERVAL_S;

/// A crest counts from this height over the fill, m.
const CREST_M: f64 = 0.003;

/// Frames within which the estimated crest is looked for.
const NEAR: usize = 6;

/// Forecasts: 0.25 s and 0.5 s, frames.
const AHEAD: [usize; 2] = [15, 30];

/// One crest: the highest point of the profile passes a maximum in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// When it truly stood, s.
    pub time_s: f64,
    /// How high it truly stood over the fill, m.
    pub height_m: f64,
    /// Estimated height less the true one, m.
    pub height_error_m: f64,
    /// Estimated time less the true one, s.
    pub time_error_s: f64,
}

/// How a model did on a recording.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Errors of surface and field.
    pub score: Score,
    /// Crests.
    pub peaks: Vec<Peak>,
    /// Turns whose heat fell.
    pub entropy_falls: usize,
    /// Largest residue of the energy in a step, in units of H.
    pub energy_drift: f64,
    /// Slosh-relative error of the forecasts of [`AHEAD`], and of the present surface in their place.
    pub forecast: [[f64; 2]; 2],
}

/// Runs `model` over `seen` and holds it against the truth of `recording`.
#[must_use]
pub fn trial(model: &Model<'_>, recording: &Recording, seen: &Sightings) -> Trial {
    let turns = turns(model, seen);
    let linear = linear_with_motion(recording);
    let audits = || turns.iter().map(|logged| &logged.turn.estimate.audit);
    Trial {
        score: score(model, recording, &linear, &turns, START),
        peaks: peaks(recording, &turns),
        entropy_falls: audits().filter(|audit| audit.heat < 0.0).count(),
        energy_drift: audits().map(|audit| audit.energy_residual.abs()).fold(0.0, f64::max),
        forecast: AHEAD.map(|frames| forecast(model, recording, &turns, frames)),
    }
}

/// Highest point of a profile over the fill, m.
fn crest(profile: &[f32], fill_m: f64) -> f64 {
    profile.iter().map(|&z| f64::from(z) - fill_m).fold(f64::NEG_INFINITY, f64::max)
}

fn peaks(recording: &Recording, turns: &[Logged]) -> Vec<Peak> {
    let fill_m = recording.glass.fill_m;
    let truth: Vec<f64> = (0..recording.frames()).map(|n| crest(recording.profile(n), fill_m)).collect();
    let said: Vec<f64> = turns.iter().map(|l| crest(&l.turn.estimate.surface_m, fill_m)).collect();
    let known = |n: usize| matches!(turns[n].turn.estimate.mode, Mode::Tracking | Mode::Coasting);
    let last = truth.len().min(said.len());
    let highest = |n: usize| n.saturating_sub(NEAR)..(n + NEAR + 1).min(last);
    (0..last)
        .filter(|&n| truth[n] > CREST_M && known(n) && highest(n).all(|m| truth[m] <= truth[n]))
        .filter_map(|n| {
            let near = highest(n).max_by(|&a, &b| said[a].total_cmp(&said[b]))?;
            Some(Peak {
                time_s: n as f64 * FRAME_INTERVAL_S,
                height_m: truth[n],
                height_error_m: said[near] - truth[n],
                time_error_s: (near as f64 - n as f64) * FRAME_INTERVAL_S,
            })
        })
        .collect()
}

/// Slosh-relative error of the surface `frames` ahead, and of the present surface in its place.
fn forecast(model: &Model<'_>, recording: &Recording, turns: &[Logged], frames: usize) -> [f64; 2] {
    let (mut ahead, mut still) = (SurfaceError::default(), SurfaceError::default());
    let fill_m = recording.glass.fill_m;
    for (n, logged) in turns.iter().enumerate().take(recording.frames().saturating_sub(frames)) {
        let estimate = &logged.turn.estimate;
        if estimate.mode != Mode::Tracking {
            continue;
        }
        let truth: &[f32] = recording.profile(n + frames);
        let said: [f32; POINTS] = surface_ahead(model, &Latent::from(estimate.latent), frames);
        ahead.add(truth, &said, fill_m);
        still.add(truth, recording.profile(n), fill_m);
    }
    [ahead.slosh_rel(), still.slosh_rel()]
}
