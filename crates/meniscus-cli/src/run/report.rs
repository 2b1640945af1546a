//! The summary of a run: what was measured, beside the baselines, as text and as JSON.

use super::Arguments;
use anyhow::bail;
use hdrhistogram::Histogram;
use meniscus::blob::Model;
use meniscus::runtime::{DEADLINE_US, Mode, Stages};
use meniscus_data::recording::{GROUP_NAMES, Recording};
use meniscus_report::checks::{Check, table};
use meniscus_score::baseline::linear_with_motion;
use meniscus_score::score::{Score, score};
use meniscus_service::live::{Log, Logged};
use meniscus_virtual::camera::START;
use serde_json::{Value, json};
use std::fmt::Write;

/// Targets of the first model, as the README states them.
pub(super) mod target {
    /// |z - estimate| / |z - z_rest|.
    pub(super) const SLOSH_REL: f64 = 0.25;
    /// Mean and maximum of |z - estimate| / z.
    pub(super) const SURFACE: (f64, f64) = (0.006, 0.04);
    /// Relative L2 of q displacement and of v.
    pub(super) const FIELD: f64 = 0.20;
    /// dE - work of a step, in units of the energy scale.
    pub(crate) const ENERGY_DRIFT: f64 = 1e-6;
    /// Median of a turn on two server cores, microseconds.
    pub(crate) const TURN_US: f64 = 3000.0;
}

/// Everything measured of a run.
pub(super) struct Report<'l> {
    log: &'l Log,
    liquid: String,
    /// Against the truth of the recording.
    pub(super) score: Score,
    turn_us: Histogram<u64>,
    /// The checks, in the order of the table.
    pub(super) checks: Vec<Check>,
}

impl<'l> Report<'l> {
    /// Scores the log.
    pub(super) fn new(model: &Model<'_>, recording: &Recording, log: &'l Log) -> anyhow::Result<Self> {
        if log.turns.is_empty() {
            bail!("the run ended before the first turn: there is nothing to report");
        }
        let linear = linear_with_motion(recording);
        let score = score(model, recording, &linear, &log.turns, START);
        let turn_us = turn_us(log)?;
        let checks = checks(log, &score, &turn_us);
        Ok(Self { log, liquid: recording.provenance.liquid.clone(), score, turn_us, checks })
    }

    /// One JSON object.
    pub(super) fn json(&self, arguments: &Arguments) -> Value {
        let log = self.log;
        let deadline_misses = late(log).count();
        json!({
            "command": "meniscus run",
            "version": env!("CARGO_PKG_VERSION"),
            "liquid": self.liquid,
            "model": arguments.model,
            "source": arguments.source,
            "seed": arguments.seed,
            "frames": log.turns.len(),
            "frames_scored": self.score.frames,
            "deadline_misses": deadline_misses,
            "turn_us": {
                "median": self.turn_us.value_at_quantile(0.5),
                "p99": self.turn_us.value_at_quantile(0.99),
                "max": self.turn_us.max(),
            },
            "stages_us_median": stages(log),
            "surface_error": {
                "mean": self.score.estimate.mean(),
                "max": self.score.estimate.max,
                "slosh_rel": self.score.estimate.slosh_rel(),
            },
            "baselines_slosh_rel": {
                "flat": self.score.flat.slosh_rel(),
                "persistence_one_frame": self.score.persistence.slosh_rel(),
                "linear_with_motion": self.score.linear.slosh_rel(),
            },
            "field_error": self.fields(),
            "energy_drift": energy_drift(log),
            "entropy_falls": entropy_falls(log),
            "modes": {
                "filling": log.health.filling,
                "tracking": log.health.tracking,
                "coasting": log.health.coasting,
                "halted": log.health.halted,
            },
            "health": log.health,
            "motion": motion(log),
            "recognised": log.recognised,
            "losses": { "depth": log.losses.0, "infrared": log.losses.1, "solitary": log.solitary,
                        "payloads_dropped": log.payloads_dropped },
            "checks": self.checks,
        })
    }

    /// Field errors by group.
    fn fields(&self) -> Value {
        GROUP_NAMES
            .iter()
            .zip(self.score.field)
            .map(|(name, error)| ((*name).to_owned(), json!(error)))
            .collect()
    }

    /// For a person.
    pub(super) fn text(&self) -> String {
        let (log, score) = (self.log, &self.score);
        let mut text = String::new();
        let frames = log.turns.len();
        let seconds = frames as f64 / 60.0;
        let health = &log.health;
        let percent = |share: f64| 100.0 * share;
        // Writing into a string cannot fail.
        let _ = writeln!(
            text,
            "{} for {seconds:.1} s: {frames} turns, {} of them scored",
            self.liquid, score.frames
        );
        let _ = writeln!(
            text,
            "modes: {} filling, {} tracking, {} coasting, {} halted",
            health.filling, health.tracking, health.coasting, health.halted
        );
        let _ = writeln!(
            text,
            "surface, of the slosh: {:.1} % (flat 100 %, last frame {:.1} %, linear with the true motion {:.1} %)",
            percent(score.estimate.slosh_rel()),
            percent(score.persistence.slosh_rel()),
            percent(score.linear.slosh_rel())
        );
        let stages: Vec<String> =
            stage_medians(log).iter().map(|(name, us)| format!("{name} {us}")).collect();
        text += &motion_line(log);
        let _ = writeln!(text, "stages, median us: {}", stages.join(", "));
        if let Some(standing) = &log.recognised {
            let _ = writeln!(text, "liquid: {}", standing.line());
        }
        text + &table(&self.checks)
    }
}

/// The times of the turns, up to a minute. The range is given: a histogram that grows by itself takes what is
/// beyond its first range for the largest value in it, and tells 2 us of a turn of 5 ms.
pub(super) fn turn_us(log: &Log) -> anyhow::Result<Histogram<u64>> {
    let mut turn_us = Histogram::new_with_bounds(1, 60_000_000, 3)?;
    log.turns.iter().for_each(|logged| turn_us.saturating_record(logged.turn_us));
    Ok(turn_us)
}

/// The checks of a run.
fn checks(log: &Log, score: &Score, turn_us: &Histogram<u64>) -> Vec<Check> {
    let (surface, [q, v, e, sigma, tau]) = (&score.estimate, score.field);
    let (mean, max) = target::SURFACE;
    let allocations: u64 = log.turns.iter().map(|logged| logged.allocations).sum();
    vec![
        Check::at_most("surface_slosh_rel", surface.slosh_rel(), "1", target::SLOSH_REL),
        Check::informational("baseline_flat_slosh_rel", score.flat.slosh_rel(), "1"),
        Check::informational("baseline_persistence_slosh_rel", score.persistence.slosh_rel(), "1"),
        Check::informational("baseline_linear_slosh_rel", score.linear.slosh_rel(), "1"),
        Check::at_most("surface_error_mean", surface.mean(), "1", mean),
        Check::at_most("surface_error_max", surface.max, "1", max),
        Check::informational("interval_coverage", score.held.share(), "1"),
        Check::at_most("field_error_q", q, "1", target::FIELD),
        Check::at_most("field_error_v", v, "1", target::FIELD),
        Check::informational("field_error_e", e, "1"),
        Check::informational("field_error_sigma", sigma, "1"),
        Check::informational("field_error_sigma_frame_late", score.late_sigma, "1"),
        Check::informational("field_error_tau", tau, "1"),
        Check::at_most("energy_drift_step", energy_drift(log), "H", target::ENERGY_DRIFT),
        Check::exactly("entropy_falls", entropy_falls(log) as f64, "1", 0.0),
        Check::exactly("deadline_misses", late(log).count() as f64, "1", 0.0),
        Check::at_most("turn_us_median", turn_us.value_at_quantile(0.5) as f64, "us", target::TURN_US),
        Check::at_most("turn_us_p99", turn_us.value_at_quantile(0.99) as f64, "us", DEADLINE_US as f64),
        Check::exactly("allocations", allocations as f64, "1", 0.0),
    ]
}

/// Turns that ended more than a frame interval after their last payload had come.
pub(super) fn late(log: &Log) -> impl Iterator<Item = &Logged> {
    log.turns.iter().filter(|logged| logged.latency_us > DEADLINE_US)
}

/// Largest |dE - work| of a predicting step, in units of the energy scale.
pub(super) fn energy_drift(log: &Log) -> f64 {
    let residuals = log.turns.iter().map(|logged| logged.turn.estimate.audit.energy_residual.abs());
    residuals.fold(0.0, f64::max)
}

/// Who told how the glass moves, for scripts; null where nobody was asked.
pub(super) fn motion(log: &Log) -> Value {
    log.told.map_or(Value::Null, |(told, untold)| json!({ "told": told, "untold": untold }))
}

/// The same for people: a line, or nothing.
pub(super) fn motion_line(log: &Log) -> String {
    log.told.map_or(String::new(), |(told, untold)| {
        format!("motion: told to {told} turns, by the edges of the glass in {untold}\n")
    })
}

/// Turns after which there was less heat than before.
pub(super) fn entropy_falls(log: &Log) -> usize {
    let heat = |logged: &Logged| logged.turn.estimate.heat_j;
    log.turns.windows(2).filter(|pair| heat(&pair[1]) < heat(&pair[0])).count()
}

/// Median time of each stage over the turns that tracked, microseconds.
pub(super) fn stage_medians(log: &Log) -> [(&'static str, u64); 5] {
    let tracking = || log.turns.iter().map(|l| &l.turn.estimate).filter(|e| e.mode == Mode::Tracking);
    let median = |stage: fn(&Stages) -> u64| {
        let mut times: Vec<u64> = tracking().map(|estimate| stage(&estimate.stages)).collect();
        times.sort_unstable();
        times.get(times.len() / 2).copied().unwrap_or(0)
    };
    [
        ("surface", median(|stages| stages.surface_us)),
        ("predict", median(|stages| stages.predict_us)),
        ("encode", median(|stages| stages.encode_us)),
        ("correct", median(|stages| stages.correct_us)),
        ("field", median(|stages| stages.field_us)),
    ]
}

/// The same as JSON.
pub(super) fn stages(log: &Log) -> Value {
    stage_medians(log).into_iter().map(|(name, us)| (name.to_owned(), json!(us))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::blob::Model;
    use meniscus_virtual::observe_recording;

    #[test]
    fn a_long_turn_is_told_as_long() {
        let bytes = meniscus_platform::files::AlignedBytes::copy(meniscus_shipped::MODEL);
        let model = Model::load(&bytes).expect("the shipped model");
        let mut log = Log { turns: observe_recording::turns(&model, &[None, None, None]), ..Log::default() };
        for (logged, us) in log.turns.iter_mut().zip([400, 5_000, 90_000]) {
            logged.turn_us = us;
        }
        let told = turn_us(&log).expect("a range");
        let near = |told: u64, us: u64| told.abs_diff(us) * 1000 <= us;
        assert!(near(told.value_at_quantile(0.5), 5_000), "{}", told.value_at_quantile(0.5));
        assert!(near(told.max(), 90_000), "{}", told.max());
    }
}
