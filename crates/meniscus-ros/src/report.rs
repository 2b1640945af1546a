//! `/diagnostics`: estimate, camera, spilling and the node itself, once a second.

use crate::counters::Counts;
use crate::message::{DiagnosticArray, DiagnosticStatus, Header, KeyValue, Level, Stamp};
use meniscus::runtime::Mode;
use meniscus_service::ledger::FrameCounts;
use meniscus_service::timed_turn::TimedTurn;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Time without a turn after which the estimate is stale.
const STALE: Duration = Duration::from_secs(1);

/// Content of the diagnostics besides the turns.
pub(crate) struct Standing<'s> {
    /// The camera, as a person reads it.
    pub(crate) camera: &'s str,
    /// State of the camera; empty where it is well.
    pub(crate) note: &'s str,
    pub(crate) counts: Counts,
    /// Reason of the last datagram that could not be sent.
    pub(crate) unsent: String,
    pub(crate) readers: [(&'static str, usize); 5],
    pub(crate) spill_limit: f64,
}

/// Turns since the last message.
#[derive(Debug, Default)]
pub(crate) struct Report {
    latest: Option<TimedTurn>,
    /// Largest probability of spilling since the last message.
    spill: f64,
    /// Accounts and counts of the last message.
    frames: FrameCounts,
    counts: Counts,
}

impl Report {
    /// Takes a turn.
    pub(crate) fn turn(&mut self, logged: Option<TimedTurn>, probability: f64) {
        self.latest = logged.or(self.latest);
        self.spill = self.spill.max(probability);
    }

    /// Returns the message, and begins anew.
    pub(crate) fn message(&mut self, standing: &Standing<'_>) -> DiagnosticArray {
        let now_ns = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |now| now.as_nanos() as u64);
        let header = Header { stamp: Stamp::of_unix_ns(now_ns), frame_id: String::new() };
        let status = [self.estimate(), self.camera(standing), self.spilling(standing), self.node(standing)];
        self.frames = self.latest.map_or(self.frames, |logged| logged.frames);
        (self.spill, self.counts) = (0.0, standing.counts);
        let hardware_id = standing.camera;
        let status = status
            .into_iter()
            .map(|status| DiagnosticStatus { hardware_id: hardware_id.to_owned(), ..status });
        DiagnosticArray { header, status: status.collect() }
    }

    fn estimate(&self) -> DiagnosticStatus {
        let Some(logged) = self.latest else {
            return status("estimate", Level::Stale, "no turn yet", vec![]);
        };
        let mode = logged.turn.estimate.mode;
        let (level, message) = match mode {
            _ if logged.ended.elapsed() > STALE => (Level::Stale, "no turn for over a second"),
            Mode::Tracking => (Level::Ok, "tracking"),
            Mode::Filling => (Level::Warn, "the window of 16 frames is not full yet"),
            Mode::Coasting => (Level::Warn, "no usable frame: a prediction"),
            Mode::Halted => (Level::Error, "no usable frame for a second: no estimate"),
        };
        let latency = logged.host.map_or(f64::NAN, |host| 1e-3 * host.latency_us as f64);
        let values = vec![
            figure("turn, us", logged.turn_us),
            figure("from mid-exposure to the end of the turn, ms", format!("{latency:.2}")),
        ];
        status("estimate", level, message, values)
    }

    fn camera(&self, standing: &Standing<'_>) -> DiagnosticStatus {
        let frames = self.latest.map_or(self.frames, |logged| logged.frames);
        let missed = frames.missed().saturating_sub(self.frames.missed());
        let (level, message) = match (standing.note, missed) {
            ("", 0) => (Level::Ok, "every frame in time".to_owned()),
            ("", missed) => (Level::Warn, format!("{missed} frames not in time since the last message")),
            (note, _) => (Level::Error, note.to_owned()),
        };
        let values = vec![
            figure("in time", frames.in_time),
            figure("late", frames.late),
            figure("lost", frames.lost),
            figure("never handled", frames.never_handled),
        ];
        status("camera", level, &message, values)
    }

    fn spilling(&self, standing: &Standing<'_>) -> DiagnosticStatus {
        let above = self.spill > standing.spill_limit;
        let (level, message) =
            if above { (Level::Warn, "spilling is likely") } else { (Level::Ok, "no spilling ahead") };
        let values = vec![
            figure("largest probability since the last message", format!("{:.4}", self.spill)),
            figure("spill_limit", standing.spill_limit),
        ];
        status("spilling", level, message, values)
    }

    fn node(&self, standing: &Standing<'_>) -> DiagnosticStatus {
        let (is, was) = (standing.counts, self.counts);
        let left_out = (is.queue_full + is.refused + is.unsent)
            .saturating_sub(was.queue_full + was.refused + was.unsent);
        let (level, message) = match left_out {
            0 => (Level::Ok, "all published".to_owned()),
            _ => {
                (Level::Warn, "turns, messages or datagrams were left out since the last message".to_owned())
            }
        };
        let mut values = vec![
            figure("turns published", is.turns),
            figure("turns left out by a full queue", is.queue_full),
            figure("turns overtaken by a frame", is.overtaken),
            figure("messages refused by the middleware", is.refused),
            figure("plans answered", is.plans),
            figure("datagrams that could not be sent", is.unsent),
            figure("reason of the last one", &standing.unsent),
        ];
        values.extend(standing.readers.map(|(topic, count)| figure(&format!("readers of {topic}"), count)));
        status("ROS 2", level, &message, values)
    }
}

fn figure(key: &str, value: impl ToString) -> KeyValue {
    KeyValue { key: key.to_owned(), value: value.to_string() }
}

fn status(part: &str, level: Level, message: &str, values: Vec<KeyValue>) -> DiagnosticStatus {
    let (name, message) = (format!("meniscus: {part}"), message.to_owned());
    DiagnosticStatus { level, name, message, hardware_id: String::new(), values }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_wrong_stands_in_the_level_and_comes_once() {
        let standing = |refused, note| Standing {
            camera: "D435",
            note,
            counts: Counts { refused, ..Counts::default() },
            unsent: String::new(),
            readers: [("tracers", 0); 5],
            spill_limit: 0.05,
        };
        let mut report = Report::default();
        let levels = |message: &DiagnosticArray| -> Vec<Level> {
            message.status.iter().map(|status| status.level).collect()
        };
        report.turn(None, 0.2);
        let first = report.message(&standing(3, "unplugged"));
        assert_eq!(levels(&first), [Level::Stale, Level::Error, Level::Warn, Level::Warn]);
        assert!(first.status.iter().all(|status| status.hardware_id == "D435"));
        let second = report.message(&standing(3, ""));
        assert_eq!(
            levels(&second),
            [Level::Stale, Level::Ok, Level::Ok, Level::Ok],
            "nothing new was refused"
        );
    }
}
