//! Report of a run with a camera on a bus or a camera's recording: there is no truth unless one was named.

use super::{RunLabels, checks_of, fields_json, liquid_line, surface_json, unknown_line};
use crate::field_error::GroupError;
use crate::score::Score;
use meniscus_data::validity::Validity;
use meniscus_report::checks::{Check, table};
use meniscus_service::camera_facts::{camera_json, camera_line};
use meniscus_service::live::Log;
use meniscus_service::run::statistics::{
    clock_json, losses_json, modes_json, motion_json, motion_line, stages_json, stages_line,
};
use meniscus_usb::camera::{CameraHealth, Connected, Note};
use serde_json::{Value, json};
use std::fmt::Write;

/// Measured figures of a run with a camera.
#[derive(Debug)]
pub struct CameraReport<'l> {
    /// Turns and counters of the worker.
    pub log: &'l Log,
    /// The camera; a recording and a webcam have none.
    pub camera: Option<Connected>,
    /// The webcam in one line.
    pub webcam: Option<String>,
    /// Its counters.
    pub health: CameraHealth,
    /// Its events.
    pub notes: Vec<Note>,
    /// Real-time priority of its thread, or the reason of the refusal; `None` if it was not wanted.
    pub realtime: Option<Result<(), String>>,
    /// Errors against the truth, where one is known.
    pub score: Option<Score>,
    /// Field groups that the model knows.
    pub validity: Validity,
}

impl CameraReport<'_> {
    /// Returns the checks of a run without a truth.
    #[must_use]
    pub fn checks(&self) -> Vec<Check> {
        checks_of(self.log)
    }

    /// Returns one JSON object.
    #[must_use]
    pub fn json(&self, labels: &RunLabels<'_>) -> Value {
        let log = self.log;
        let notes: Vec<String> = self.notes.iter().map(Note::to_string).collect();
        json!({
            "command": "meniscus run",
            "version": env!("CARGO_PKG_VERSION"),
            "model": labels.model,
            "known": self.validity.names(),
            "unknown": self.validity.sentence,
            "source": labels.source,
            "camera": self.camera.as_ref().map(camera_json),
            "webcam": self.webcam,
            "camera_health": self.health,
            "camera_notes": notes,
            "realtime": self.realtime.as_ref().map(Result::is_ok),
            "frames": log.totals.turns,
            "deadlines": log.frames.json(),
            "stages_us_median": stages_json(log),
            "modes": modes_json(log),
            "health": log.health,
            "truth": self.score.as_ref().map(scored),
            "motion": motion_json(log),
            "clock": clock_json(log),
            "recognised": log.recognised,
            "losses": losses_json(log),
            "checks": self.checks(),
        })
    }

    /// Returns the report for a person: the checks, and below them, where a terminal shows it last, what they come to.
    #[must_use]
    pub fn text(&self) -> String {
        let (log, health, mut text) = (self.log, &self.log.health, table(&self.checks()));
        // Writing into a string cannot fail.
        if let Some(camera) = &self.camera {
            let _ = writeln!(text, "{}", camera_line(camera));
        }
        if let Some(webcam) = &self.webcam {
            let _ = writeln!(text, "{webcam}");
        }
        let _ = writeln!(
            text,
            "{} turns: {} filling, {} tracking, {} coasting, {} halted; the liquid was not seen in {}",
            log.totals.turns,
            health.filling,
            health.tracking,
            health.coasting,
            health.halted,
            health.not_seen
        );
        let _ = writeln!(text, "{}", log.frames);
        text += &motion_line(log);
        let (depth, outline) = (log.losses.0.frames(), log.losses.1.frames());
        let colour = self.camera.as_ref().is_some_and(|camera| camera.colour.is_some());
        let beside = if colour { "colour" } else { "infrared" };
        let _ = match &self.webcam {
            Some(_) => writeln!(text, "frames lost: {outline}"),
            None => writeln!(text, "frames lost: {depth} depth, {outline} {beside}"),
        };
        if let Some(Err(reason)) = &self.realtime {
            let _ = writeln!(
                text,
                "the camera's thread has no real-time priority ({reason}): see meniscus doctor"
            );
        }
        for note in &self.notes {
            let _ = writeln!(text, "camera: {note}");
        }
        text += &stages_line(log);
        let _ = match &self.score {
            None => writeln!(text, "no truth is known, so the estimate has no error figures"),
            Some(score) => {
                let slosh = 100.0 * score.estimate.slosh_rel();
                let one = |one: &GroupError| format!(", {} {:.1} %", one.name, 100.0 * one.error);
                let groups = score.known_field().filter(|one| matches!(one.name, "q" | "v"));
                let groups: String = groups.map(|group| one(&group)).collect();
                writeln!(text, "errors against the truth: surface {slosh:.1} % (slosh-relative){groups}")
            }
        };
        text + &unknown_line(&self.validity) + &liquid_line(log)
    }
}

/// Returns the errors against the truth as JSON.
fn scored(score: &Score) -> Value {
    json!({
        "frames_scored": score.frames,
        "surface_error": surface_json(score),
        "field_error": fields_json(score),
    })
}
