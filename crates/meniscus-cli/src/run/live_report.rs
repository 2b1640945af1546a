//! The summary of a run with a camera on a bus: there is no truth, so nothing is held against one.

use super::Arguments;
use super::report::{
    energy_drift, entropy_falls, late, motion, motion_line, stage_medians, stages, target, turn_us,
};
use crate::doctor::{describe, one_line};
use meniscus::runtime::DEADLINE_US;
use meniscus_data::recording::GROUP_NAMES;
use meniscus_report::checks::{Check, table};
use meniscus_score::score::Score;
use meniscus_service::live::Log;
use meniscus_usb::camera::{CameraHealth, Connected, Note};
use serde_json::{Value, json};
use std::fmt::Write;

/// Everything measured of a run.
pub(super) struct LiveReport<'l> {
    /// What the worker did.
    pub(super) log: &'l Log,
    /// The camera; a recording has none.
    pub(super) camera: Option<Connected>,
    /// Its counters.
    pub(super) health: CameraHealth,
    /// What happened to it.
    pub(super) notes: Vec<Note>,
    /// Whether its thread ran in real time, or why not; `None` if that was not wanted.
    pub(super) realtime: Option<Result<(), String>>,
    /// The estimate against the truth, where one is known.
    pub(super) score: Option<Score>,
}

impl LiveReport<'_> {
    /// The checks of a run without a truth.
    pub(super) fn checks(&self) -> anyhow::Result<Vec<Check>> {
        let (log, turn_us) = (self.log, turn_us(self.log)?);
        let allocations: u64 = log.turns.iter().map(|logged| logged.allocations).sum();
        Ok(vec![
            Check::at_most("energy_drift_step", energy_drift(log), "H", target::ENERGY_DRIFT),
            Check::exactly("entropy_falls", entropy_falls(log) as f64, "1", 0.0),
            Check::exactly("deadline_misses", late(log).count() as f64, "1", 0.0),
            Check::at_most("turn_us_median", turn_us.value_at_quantile(0.5) as f64, "us", target::TURN_US),
            Check::at_most("turn_us_p99", turn_us.value_at_quantile(0.99) as f64, "us", DEADLINE_US as f64),
            Check::exactly("allocations", allocations as f64, "1", 0.0),
        ])
    }

    /// One JSON object.
    pub(super) fn json(&self, arguments: &Arguments) -> anyhow::Result<Value> {
        let (log, health) = (self.log, &self.log.health);
        let notes: Vec<String> = self.notes.iter().map(Note::to_string).collect();
        Ok(json!({
            "command": "meniscus run",
            "version": env!("CARGO_PKG_VERSION"),
            "model": arguments.model,
            "source": arguments.source,
            "camera": self.camera.as_ref().map(describe),
            "camera_health": self.health,
            "camera_notes": notes,
            "realtime": self.realtime.as_ref().map(Result::is_ok),
            "frames": log.turns.len(),
            "stages_us_median": stages(log),
            "modes": { "filling": health.filling, "tracking": health.tracking,
                       "coasting": health.coasting, "halted": health.halted },
            "health": health,
            "truth": self.score.as_ref().map(scored),
            "motion": motion(log),
            "recognised": log.recognised,
            "losses": { "depth": log.losses.0, "infrared": log.losses.1, "solitary": log.solitary,
                        "payloads_dropped": log.payloads_dropped },
            "checks": self.checks()?,
        }))
    }

    /// For a person.
    pub(super) fn text(&self) -> anyhow::Result<String> {
        let (log, health, mut text) = (self.log, &self.log.health, String::new());
        let stages: Vec<String> =
            stage_medians(log).iter().map(|(name, us)| format!("{name} {us}")).collect();
        // Writing into a string cannot fail.
        if let Some(camera) = &self.camera {
            let _ = writeln!(text, "{}", one_line(camera));
        }
        let _ = writeln!(
            text,
            "{} turns: {} filling, {} tracking, {} coasting, {} halted; the liquid was not seen in {}",
            log.turns.len(),
            health.filling,
            health.tracking,
            health.coasting,
            health.halted,
            health.not_seen
        );
        text += &motion_line(log);
        let (depth, outline) = (log.losses.0.frames(), log.losses.1.frames());
        let colour = self.camera.as_ref().is_some_and(|camera| camera.colour.is_some());
        let beside = if colour { "colour" } else { "infrared" };
        let _ = writeln!(text, "frames lost: {depth} depth, {outline} {beside}");
        if let Some(Err(reason)) = &self.realtime {
            let _ = writeln!(
                text,
                "the camera's thread has no real-time priority ({reason}): see meniscus doctor"
            );
        }
        for note in &self.notes {
            let _ = writeln!(text, "camera: {note}");
        }
        let _ = writeln!(text, "stages, median us: {}", stages.join(", "));
        let _ = match &self.score {
            None => writeln!(text, "no truth is known, so the estimate is held against none"),
            Some(score) => {
                let [q, v, ..] = score.field.map(|error| 100.0 * error);
                let slosh = 100.0 * score.estimate.slosh_rel();
                writeln!(text, "against the truth: surface {slosh:.1} % of the slosh, q {q:.1} %, v {v:.1} %")
            }
        };
        if let Some(standing) = &log.recognised {
            let _ = writeln!(text, "liquid: {}", standing.line());
        }
        Ok(text + &table(&self.checks()?))
    }
}

/// The errors against the truth.
fn scored(score: &Score) -> Value {
    let fields = GROUP_NAMES.iter().zip(score.field);
    let fields: Value = fields.map(|(name, error)| ((*name).to_owned(), json!(error))).collect();
    json!({
        "frames_scored": score.frames,
        "surface_error": { "mean": score.estimate.mean(), "max": score.estimate.max,
                           "slosh_rel": score.estimate.slosh_rel() },
        "field_error": fields,
    })
}
