//! Report of a run before a recording: the estimate against the truth and the baselines.

use super::{RunLabels, checks_of, fields_json, liquid_line, surface_json, target, unknown_line};
use crate::baseline::linear_with_motion;
use crate::field_error::GroupError;
use crate::forecasts::{KeptMemories, RunForecasts};
use crate::score::{Score, score};
use meniscus::blob::{FieldGroup, Model};
use meniscus_data::recording::Recording;
use meniscus_data::validity::Validity;
use meniscus_report::checks::{Check, table};
use meniscus_service::live::Log;
use meniscus_service::run::statistics::{
    TurnTimes, clock_json, losses_json, modes_json, motion_json, motion_line, stages_json, stages_line,
};
use meniscus_virtual::camera::START;
use serde_json::{Value, json};
use std::fmt::Write;

/// Measured figures of a run with a known truth.
#[derive(Debug)]
pub struct TruthReport<'l> {
    log: &'l Log,
    liquid: String,
    validity: Validity,
    /// Errors against the truth of the recording.
    pub score: Score,
    /// Errors of the forecasts.
    pub forecasts: RunForecasts,
    /// The checks, in the order of the table.
    pub checks: Vec<Check>,
}

impl<'l> TruthReport<'l> {
    /// Scores the log and the forecasts from `memories` against the recording that the camera showed; `None` for a log without
    /// turns.
    #[must_use]
    pub fn new(
        model: &Model<'_>,
        recording: &Recording,
        log: &'l Log,
        memories: &KeptMemories,
    ) -> Option<Self> {
        if log.turns.is_empty() {
            return None;
        }
        let linear = linear_with_motion(recording);
        let score = score(model, recording, &linear, &log.turns, START);
        let forecasts = memories.forecasts(model, recording, START);
        let mut checks = scored(&score, &forecasts);
        checks.extend(checks_of(log));
        let validity = Validity::of(&model.header);
        Some(Self { log, liquid: recording.provenance.liquid.clone(), validity, score, forecasts, checks })
    }

    /// Returns the number of turns of the run.
    #[must_use]
    pub fn turns(&self) -> u64 {
        self.log.totals.turns
    }

    /// Returns one JSON object.
    #[must_use]
    pub fn json(&self, labels: &RunLabels<'_>) -> Value {
        let (log, score, times) = (self.log, &self.score, TurnTimes::of(self.log));
        json!({
            "command": "meniscus run",
            "version": env!("CARGO_PKG_VERSION"),
            "liquid": self.liquid,
            "model": labels.model,
            "known": self.validity.names(),
            "unknown": self.validity.sentence,
            "source": labels.source,
            "seed": labels.seed,
            "frames": log.totals.turns,
            "frames_scored": score.frames,
            "deadline_misses": log.frames.missed(),
            "deadlines": log.frames.json(),
            "turn_us": { "median": times.median, "p99": times.p99, "max": times.max },
            "stages_us_median": stages_json(log),
            "surface_error": surface_json(score),
            "baselines_slosh_rel": {
                "flat": score.flat.slosh_rel(),
                "persistence_one_frame": score.persistence.slosh_rel(),
                "linear_with_motion": score.linear.slosh_rel(),
            },
            "field_error": fields_json(score),
            "energy_drift": log.totals.energy_drift,
            "entropy_falls": log.totals.entropy_falls,
            "modes": modes_json(log),
            "health": log.health,
            "motion": motion_json(log),
            "clock": clock_json(log),
            "recognised": log.recognised,
            "losses": losses_json(log),
            "checks": self.checks,
        })
    }

    /// Returns the report for a person: the checks, and below them, where a terminal shows it last, what they come to.
    #[must_use]
    pub fn text(&self) -> String {
        let (log, score, health) = (self.log, &self.score, &self.log.health);
        let turns = log.totals.turns;
        let percent = |share: f64| 100.0 * share;
        let mut text = table(&self.checks);
        // Writing into a string cannot fail.
        let _ = writeln!(
            text,
            "{} for {:.1} s: {turns} turns, {} of them scored",
            self.liquid,
            turns as f64 / 60.0,
            score.frames
        );
        let _ = writeln!(text, "{}", log.frames);
        let _ = writeln!(
            text,
            "modes: {} filling, {} tracking, {} coasting, {} halted",
            health.filling, health.tracking, health.coasting, health.halted
        );
        let _ = writeln!(
            text,
            "slosh-relative error of the surface: {:.1} % (flat surface 100 %, last frame {:.1} %, linear model with the \
             true motion {:.1} %)",
            percent(score.estimate.slosh_rel()),
            percent(score.persistence.slosh_rel()),
            percent(score.linear.slosh_rel())
        );
        let RunForecasts { planned, unplanned } = &self.forecasts;
        let _ = writeln!(
            text,
            "the same 250 ms ahead: {:.1} % with the motion planned, {:.1} % without (surface of now {:.1} %)",
            percent(planned.forecast.slosh_rel()),
            percent(unplanned.forecast.slosh_rel()),
            percent(planned.persistence.slosh_rel())
        );
        text + &unknown_line(&self.validity) + &motion_line(log) + &stages_line(log) + &liquid_line(log)
    }
}

/// Returns the checks against the truth.
fn scored(score: &Score, forecasts: &RunForecasts) -> Vec<Check> {
    let surface = &score.estimate;
    let (mean, max) = target::SURFACE;
    let mut checks = vec![
        Check::at_most("surface_slosh_rel", surface.slosh_rel(), "1", target::SLOSH_REL),
        Check::informational("baseline_flat_slosh_rel", score.flat.slosh_rel(), "1"),
        Check::informational("baseline_persistence_slosh_rel", score.persistence.slosh_rel(), "1"),
        Check::informational("baseline_linear_slosh_rel", score.linear.slosh_rel(), "1"),
        Check::at_most("surface_error_mean", surface.mean(), "1", mean),
        Check::at_most("surface_error_max", surface.max, "1", max),
        Check::informational("interval_coverage", score.held.share(), "1"),
    ];
    checks.extend(
        score.held_coasting.map(|held| Check::informational("interval_coverage_coasting", held.share(), "1")),
    );
    let RunForecasts { planned, unplanned } = forecasts;
    checks.extend([
        Check::at_most("forecast_250ms_slosh_rel", planned.forecast.slosh_rel(), "1", target::FORECAST),
        Check::informational("forecast_250ms_unplanned_slosh_rel", unplanned.forecast.slosh_rel(), "1"),
        Check::informational("baseline_persistence_250ms_slosh_rel", planned.persistence.slosh_rel(), "1"),
        Check::informational("forecast_250ms_coverage", planned.covered.share(), "1"),
    ]);
    for GroupError { group, name, error, .. } in score.known_field() {
        let check = format!("field_error_{name}");
        checks.push(match group {
            // It follows the acceleration of the glass, which the camera has measured one frame later.
            FieldGroup::NormalStress => Check::informational(check, error, "1"),
            _ => Check::at_most(check, error, "1", target::FIELD[group as usize]),
        });
        if group == FieldGroup::NormalStress {
            let target = target::FIELD[group as usize];
            checks.push(Check::at_most("field_error_sigma_frame_late", score.late_sigma, "1", target));
        }
    }
    checks
}
