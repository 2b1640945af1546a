//! One model on one recording: errors, crests, laws, forecasts.

use crate::correct::Sightings;
use meniscus::blob::Model;
use meniscus::runtime::{Crest, InputSource, Mode};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::recording::Recording;
use meniscus_score::baseline::linear_with_motion;
use meniscus_score::crests;
use meniscus_score::forecasts::ForecastError;
use meniscus_score::score::{Held, Score, score};
use meniscus_score::unknown_groups::{UnknownShown, in_outputs};
use meniscus_service::timed_turn::TimedTurn;
use meniscus_virtual::camera::START;
use meniscus_virtual::observe_recording::turns_with;

/// Frames within which the estimated crest is looked for.
const NEAR: usize = 6;

/// Forecasts: 0.25 s and 0.5 s, frames.
const AHEAD: [usize; 2] = [15, 30];

/// One crest: the highest point of the profile passes a maximum in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// True time, s.
    pub time_s: f64,
    /// True height over the fill, m.
    pub height_m: f64,
    /// Estimated height less the true one, m.
    pub height_error_m: f64,
    /// Estimated time less the true one, s.
    pub time_error_s: f64,
}

/// Figures of a model on a recording.
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
    /// Errors of the forecasts of the next crest, and their coverage.
    pub crests_ahead: CrestsAhead,
    /// Slosh-relative error of the forecasts of `AHEAD`, and of the present surface in their place.
    pub forecast: [[f64; 2]; 2],
    /// Share of the heights of the forecasts that lay within their interval.
    pub forecast_held: [Held; 2],
    /// The same three with the motion of the glass planned that far ahead.
    pub planned: Planned,
    /// Field groups that the outputs show and the model does not know.
    pub unknown_shown: Vec<UnknownShown>,
}

/// Forecasts of a glass whose motion is planned.
#[derive(Clone, Debug, Default)]
pub struct Planned {
    /// Errors of the next crest.
    pub crests: CrestsAhead,
    /// Slosh-relative error of the forecasts of `AHEAD`.
    pub forecast: [f64; 2],
    /// Share of their heights that lay within their interval.
    pub held: [Held; 2],
}

/// Runs `model` over `seen` and holds it against the truth of `recording`.
#[must_use]
pub fn trial(model: &Model<'_>, recording: &Recording, seen: &Sightings) -> Trial {
    let (mut ahead, mut planned) = (AHEAD.map(ForecastError::new), AHEAD.map(ForecastError::new));
    let motion = recording.delayed_acceleration_m_s2();
    let fill_m = recording.glass.fill_m;
    let highest_m = recording.highest_m();
    let (mut crests_ahead, mut crests_planned) = (CrestsAhead::default(), CrestsAhead::default());
    let turns = turns_with(
        model,
        seen,
        |_| InputSource::Tracked,
        |frame, memory, estimate| {
            if estimate.mode != Mode::Tracking {
                return;
            }
            let plan = motion.get(frame + 1..).unwrap_or_default();
            for (all, plan) in [(&mut ahead, &[][..]), (&mut planned, plan)] {
                all.iter_mut().for_each(|ahead| ahead.add(model, memory, recording, frame, plan));
            }
            if frame.is_multiple_of(crests::EVERY) {
                let next = |plan| Crest::next(model, memory, crests::WITHIN, plan);
                crests_ahead.take(&highest_m, fill_m, frame, next(&[]));
                crests_planned.take(&highest_m, fill_m, frame, next(plan));
            }
        },
    );
    let linear = linear_with_motion(recording);
    let audits = || turns.iter().map(|logged| &logged.turn.estimate.audit);
    Trial {
        score: score(model, recording, &linear, &turns, START),
        crests_ahead,
        peaks: peaks(recording, &turns),
        entropy_falls: audits().filter(|audit| audit.heat < 0.0).count(),
        energy_drift: audits().map(|audit| audit.energy_residual.abs()).fold(0.0, f64::max),
        forecast: ahead.map(|ahead| [ahead.forecast.slosh_rel(), ahead.persistence.slosh_rel()]),
        forecast_held: ahead.map(|ahead| ahead.covered),
        planned: Planned {
            crests: crests_planned,
            forecast: planned.map(|ahead| ahead.forecast.slosh_rel()),
            held: planned.map(|ahead| ahead.covered),
        },
        unknown_shown: in_outputs(model, recording, &turns),
    }
}

/// Next crest, forecast and true.
#[derive(Clone, Debug, Default)]
pub struct CrestsAhead {
    /// Forecast less true height, m.
    pub height_m: Vec<f64>,
    /// Forecast less true time, s.
    pub time_s: Vec<f64>,
    /// Whether the true height lay within the interval.
    pub held: Held,
    /// Crests that came and were not forecast.
    pub missed: usize,
}

impl CrestsAhead {
    /// Compares what is `said` at `frame` with the next crest of `highest_m`, if one comes in time. A forecast crest that is too low
    /// to count is another one.
    fn take(&mut self, highest_m: &[f32], fill_m: f64, frame: usize, said: Option<Crest>) {
        let Some(n) = crests::next(highest_m, fill_m, frame) else { return };
        let Some(said) = said.filter(|said| crests::counts(said.height_m, fill_m)) else {
            self.missed += 1;
            return;
        };
        self.height_m.push(f64::from(said.height_m) - f64::from(highest_m[n]));
        self.time_s.push((said.frames as f64 - (n - frame) as f64) * FRAME_INTERVAL_S);
        self.held.add(&[highest_m[n]], &[said.height_m], &[said.half_width_m]);
    }
}

/// Highest point of a profile over the fill, m.
fn crest(profile: &[f32], fill_m: f64) -> f64 {
    profile.iter().map(|&z| f64::from(z) - fill_m).fold(f64::NEG_INFINITY, f64::max)
}

fn peaks(recording: &Recording, turns: &[TimedTurn]) -> Vec<Peak> {
    let fill_m = recording.glass.fill_m;
    let truth: Vec<f64> = (0..recording.frames()).map(|n| crest(recording.profile(n), fill_m)).collect();
    let said: Vec<f64> = turns.iter().map(|l| crest(&l.turn.estimate.surface_m, fill_m)).collect();
    let known = |n: usize| matches!(turns[n].turn.estimate.mode, Mode::Tracking | Mode::Coasting);
    let last = truth.len().min(said.len());
    let highest = |n: usize| n.saturating_sub(NEAR)..(n + NEAR + 1).min(last);
    (0..last)
        .filter(|&n| truth[n] > crests::CREST_M && known(n) && highest(n).all(|m| truth[m] <= truth[n]))
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
