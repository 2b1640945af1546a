//! Reports of a run: measured figures beside their targets, as text and as JSON.

mod camera;
#[cfg(feature = "pictures")]
mod truth;

pub use camera::CameraReport;
#[cfg(feature = "pictures")]
pub use truth::TruthReport;

use crate::score::Score;
use meniscus::runtime::DEADLINE_US;
use meniscus_data::validity::Validity;
use meniscus_report::checks::Check;
use meniscus_service::live::Log;
use meniscus_service::run::statistics::TurnTimes;
use serde_json::{Value, json};

/// Targets that trivial estimates miss. `tests/command.rs` compares those of the surface and of its forecast, relative to the slosh, with a flat
/// surface, the last frame and the linear model, and all but that of e with the model of another liquid. A field at rest scores 1.
mod target {
    /// |z - estimate| / |z - z_rest|.
    #[cfg(feature = "pictures")]
    pub(super) const SLOSH_REL: f64 = 0.045;
    /// Mean and maximum of |z - estimate| / z.
    #[cfg(feature = "pictures")]
    pub(super) const SURFACE: (f64, f64) = (0.001, 0.016);
    /// The first, 250 ms ahead with the motion planned.
    #[cfg(feature = "pictures")]
    pub(super) const FORECAST: f64 = 0.08;
    /// Relative L2 of the fluctuation of q, v, e, sigma (one frame late), tau.
    #[cfg(feature = "pictures")]
    pub(super) const FIELD: [f64; 5] = [0.07, 0.15, 0.25, 0.20, 0.20];
    /// dE - work of a step, in units of the energy scale.
    pub(super) const ENERGY_DRIFT: f64 = 1e-6;
    /// Median of a turn on two server cores, microseconds.
    pub(super) const TURN_US: f64 = 3000.0;
}

/// Names under which a run is reported.
#[derive(Clone, Copy, Debug)]
pub struct RunLabels<'l> {
    /// The model, as the user named it.
    pub model: &'l str,
    /// The source, as the user named it.
    pub source: &'l str,
    /// Seed of the simulated camera's noise and faults.
    pub seed: u64,
}

/// Returns the checks of a run that need no truth: conservation laws, deadlines, times, allocations. They are over all turns.
fn checks_of(log: &Log) -> Vec<Check> {
    let (times, totals, frames) = (TurnTimes::of(log), &log.totals, &log.frames);
    vec![
        Check::at_most("energy_drift_step", totals.energy_drift, "H", target::ENERGY_DRIFT),
        Check::exactly("entropy_falls", totals.entropy_falls as f64, "1", 0.0),
        Check::exactly("deadline_misses", frames.missed() as f64, "1", 0.0),
        Check::informational("frames_taken", frames.taken() as f64, "1"),
        Check::informational("frames_late", frames.late as f64, "1"),
        Check::informational("frames_lost", frames.lost as f64, "1"),
        Check::informational("frames_never_handled", frames.never_handled as f64, "1"),
        Check::exactly("turns_late", totals.turns_late as f64, "1", 0.0),
        Check::at_most("turn_us_median", times.median as f64, "us", target::TURN_US),
        Check::at_most("turn_us_p99", times.p99 as f64, "us", DEADLINE_US as f64),
        Check::exactly("allocations", log.allocations() as f64, "1", 0.0),
    ]
}

/// Returns the errors of the known groups of the field as JSON.
fn fields_json(score: &Score) -> Value {
    score.known_field().map(|one| (one.name.to_owned(), json!(one.error))).collect()
}

/// Returns the sentence about the groups that are not known as a line; empty where all are.
fn unknown_line(validity: &Validity) -> String {
    validity.sentence.as_ref().map_or(String::new(), |sentence| format!("{sentence}\n"))
}

/// Returns the errors of the surface as JSON.
fn surface_json(score: &Score) -> Value {
    json!({ "mean": score.estimate.mean(), "max": score.estimate.max, "slosh_rel": score.estimate.slosh_rel() })
}

/// Returns the identified liquid as a line; empty where none was compared.
fn liquid_line(log: &Log) -> String {
    log.recognised.as_ref().map_or(String::new(), |standing| format!("liquid: {}\n", standing.line()))
}
