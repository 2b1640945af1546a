//! Facts against what must come of them. After every scenario health must be clean unless the scenario
//! declares the fault.

use super::scenarios::{Must, Scenario};
use serde_json::Value;

/// The rungs of the ladder of recovery.
const RUNGS: [&str; 5] = ["requeue", "renegotiate", "restart", "reset", "re-plug"];

/// Time from a re-attachment to the first tracked frame, seconds.
pub(crate) const REATTACH_S: f64 = 1.5;

/// Deviations from the required outcome; empty where there are none.
pub(crate) type Wrong = Vec<String>;

/// A value by its path, `a.b.c`.
pub(crate) fn at<'f>(facts: &'f Value, path: &str) -> &'f Value {
    path.split('.').fold(facts, |value, key| &value[key])
}

/// A number by its path; not a number where there is none.
pub(crate) fn number(facts: &Value, path: &str) -> f64 {
    at(facts, path).as_f64().unwrap_or(f64::NAN)
}

/// Collects what is wrong.
struct Judge<'f> {
    facts: &'f Value,
    wrong: Wrong,
}

impl Judge<'_> {
    fn is(&mut self, path: &str, wanted: impl Into<Value>) {
        let (found, wanted) = (at(self.facts, path), wanted.into());
        if *found != wanted {
            self.wrong.push(format!("{path} is {found} instead of {wanted}"));
        }
    }

    fn within(&mut self, path: &str, low: f64, high: f64) {
        let found = number(self.facts, path);
        if !(low..=high).contains(&found) {
            self.wrong.push(format!("{path} is {found}, outside of {low} to {high}"));
        }
    }

    /// At least one of the paths counts something.
    fn counted(&mut self, paths: &str) {
        if !paths.split('|').any(|path| number(self.facts, path) >= 1.0) {
            self.wrong.push(format!("{paths} counts nothing"));
        }
    }

    fn says(&mut self, words: &[&str]) {
        let said = self.facts["said"].as_str().unwrap_or_default();
        for word in words {
            if !said.contains(word) {
                self.wrong.push(format!("`{word}` is missing in: {said}"));
            }
        }
    }

    /// Every counter of an object is 0.
    fn clean(&mut self, path: &str) {
        let counters = at(self.facts, path);
        match counters.as_object() {
            None => self.wrong.push(format!("{path} is missing")),
            Some(counters) => {
                let counted = counters.iter().filter(|(_, count)| count.as_u64() != Some(0));
                self.wrong.extend(counted.map(|(name, count)| format!("{path}.{name} is {count}")));
            }
        }
    }

    /// The kernel has the camera with all of its interfaces, at this speed.
    fn enumerated(&mut self, speed: &str) {
        self.is("enumerated.speed_mbit", speed);
        self.is("enumerated.interfaces", 5);
        self.is("enumerated.product", "0b07");
        self.within("enumerated_s", 0.0, 1.0);
    }

    /// `meniscus doctor` met its checks and read the calibration of the simulated camera.
    fn examined(&mut self) {
        for check in ["camera_found", "camera_permitted", "link_usb3", "calibration_read", "depth_unit_um"] {
            self.is(&format!("checks.{check}.ok"), true);
        }
        self.is("exit", 0);
        self.is("checks.frame_rate_hz.ok", true);
        self.is("checks.realtime_granted.ok", true);
        self.is("camera.depth_unit_um", 100);
        self.within("camera.intrinsics.fx", 384.20, 384.22);
        self.within("camera.intrinsics.ppy", 236.34, 236.36);
        self.within("camera.baseline_mm", 50.05, 50.07);
    }

    /// The service manager was notified in time, and often enough.
    fn served(&mut self, seconds: f64) {
        self.is("exit", 0);
        self.within("notified.ready_s", 0.0, seconds);
        self.within("notified.tracking_s", 0.0, seconds);
        self.within("notified.longest_silence_s", 0.0, 2.0);
        self.within("notified.signs_of_life", 2.0, 100.0);
    }

    /// A run that ended well, tracking, with no turn late, stale or allocating.
    fn ran(&mut self) {
        self.is("exit", 0);
        self.is("turns.last_mode", "tracking");
        self.is("turns.stale_as_fresh", 0);
        // Not `deadline_misses`: it counts the frames that a trouble costs, and the emulated machine stands still with its host.
        for check in ["energy_drift_step", "entropy_falls", "turns_late", "allocations"] {
            self.is(&format!("checks.{check}.ok"), true);
        }
    }

    /// Nothing happened to the camera or to its frames.
    fn healthy(&mut self) {
        self.ran();
        for counter in ["errors", "stalls", "overflows", "timed_out", "cancelled", "no_device", "repeated"] {
            self.is(&format!("camera_health.{counter}"), 0);
        }
        for counter in ["damaged", "starved", "buffers_lost", "pushed_errors", "interrupt_errors"] {
            self.is(&format!("camera_health.{counter}"), 0);
        }
        self.is("camera_health.rungs", vec![0; RUNGS.len()]);
        self.is("turns.gaps", 0);
        self.is("turns.unread", 0);
        self.clean("losses.depth");
        self.clean("losses.infrared");
        self.is("losses.payloads_dropped", 0);
    }

    /// A tag was seen in a `share` of the images at least, once in each, and its motion was used once it had agreed with the camera's.
    fn tagged(&mut self, share: f64) {
        let [images, frames] = ["motion.tag.images", "turns.frames"].map(|path| number(self.facts, path));
        self.within("motion.tag.images", frames - 2.0, f64::INFINITY);
        self.within("motion.tag.seen", share * images, images);
        self.within("motion.commanded", 0.5 * frames, frames);
        for fault in ["contradicted", "tag.doubled", "tag.jumps", "tag.other_number", "tag.unfit"] {
            self.is(&format!("motion.{fault}"), 0);
        }
    }

    fn recovered(&mut self, rung: usize) {
        self.ran();
        let rungs = at(self.facts, "camera_health.rungs").as_array().cloned().unwrap_or_default();
        let highest = rungs.iter().rposition(|taken| taken.as_u64() != Some(0));
        if highest != Some(rung) {
            let name = |rung: usize| RUNGS.get(rung).copied().unwrap_or("none");
            let highest = highest.map_or("none", name);
            self.wrong.push(format!("the highest rung is {highest} instead of {}", name(rung)));
        }
        let notes = self.facts["camera_notes"].as_array().cloned().unwrap_or_default();
        if notes.last().and_then(Value::as_str) != Some("the camera is back") {
            self.wrong.push(format!("the camera is not back: {notes:?}"));
        }
    }

    fn reattached(&mut self) {
        let times = at(self.facts, "turns.reattach_to_track_s").as_array().cloned().unwrap_or_default();
        for time in times {
            if !time.as_f64().is_some_and(|time| time <= REATTACH_S) {
                self.wrong.push(format!("from re-attachment to track: {time} s, {REATTACH_S} s are allowed"));
            }
        }
    }
}

/// Judges one scenario; `film` is what the same frames came to in process.
pub(crate) fn judge(scenario: &Scenario, facts: &Value, film: &Value) -> Wrong {
    let mut judge = Judge { facts, wrong: Vec::new() };
    if let Some(error) = facts["error"].as_str() {
        return vec![error.to_owned()];
    }
    judge.is("kernel_complaints", Vec::<Value>::new());
    match scenario.must {
        Must::Enumerate(speed) => judge.enumerated(speed),
        Must::Doctor => judge.examined(),
        Must::Record => {
            judge.is("exit", 0);
            // Half of the images without any compression.
            judge.within("recorded_bytes", 1e6, 60e6);
        }
        Must::Stream(seconds) => {
            judge.healthy();
            judge.within("turns.fps", 59.9, 60.1);
            judge.within("turns.frames", 60.0 * (seconds - 0.5), 60.0 * seconds + 1.0);
            judge.within("turns.interval_p99_us", 16_000.0, 17_500.0);
        }
        Must::Track(_) => {
            judge.healthy();
            let ratio = field_error_ratio(facts, film);
            if ratio.is_none_or(|ratio| scenario.misses(ratio)) {
                judge.wrong.push(format!("the field's error is {ratio:?} of that in process"));
            }
        }
        Must::Tag(share) => {
            judge.healthy();
            judge.tagged(share);
        }
        Must::NoTag => {
            judge.healthy();
            let images = number(facts, "motion.tag.images");
            judge.within("motion.tag.images", number(facts, "turns.frames") - 2.0, f64::INFINITY);
            judge.within("motion.tag.missing", images, images);
            judge.is("motion.commanded", 0);
        }
        Must::Ride(keys) => {
            judge.ran();
            judge.is("camera_health.rungs", vec![0; RUNGS.len()]);
            keys.iter().for_each(|key| judge.counted(key));
            judge.reattached();
        }
        Must::Recover(rung) => {
            judge.recovered(rung);
            judge.reattached();
        }
        Must::Service(seconds) => judge.served(seconds),
        Must::Flash => {
            judge.healthy();
            // The run outlasts both flashes.
            judge.is("streamed_on", true);
            judge.is("flashed", vec![0, 0]);
            judge.is("slots", vec!["A", "B"]);
            judge.is("started_from_the_other_slot", true);
            judge.is("fell_back", true);
        }
        Must::Busy => judge.healthy(),
        Must::Fail(words) => {
            judge.is("exit", 1);
            judge.says(words);
        }
        Must::Refuse(words) => {
            judge.is("exit", 1);
            judge.says(words);
            judge.says(&["What to do: "]);
        }
    }
    judge.wrong
}

impl Scenario {
    /// Whether a ratio of errors is farther from 1 than allowed.
    fn misses(&self, ratio: f64) -> bool {
        // A ratio that is no number misses too.
        matches!(self.must, Must::Track(allowed) if (1.0 - ratio).abs() > allowed || ratio.is_nan())
    }
}

/// Error of the field through USB over that in process, of the group where the two differ most.
pub(crate) fn field_error_ratio(facts: &Value, film: &Value) -> Option<f64> {
    let groups = film["field_error"].as_object()?;
    let ratio = |group: &String| {
        let (usb, process) =
            (at(facts, "truth.field_error")[group].as_f64()?, film["field_error"][group].as_f64()?);
        Some(usb / process)
    };
    let ratios: Option<Vec<f64>> = groups.keys().map(ratio).collect();
    ratios?.into_iter().max_by(|a, b| (a - 1.0).abs().total_cmp(&(b - 1.0).abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_group_that_differs_most_gives_the_ratio() {
        let film = json!({ "field_error": { "q": 0.05, "v": 0.1 } });
        let facts = json!({ "truth": { "field_error": { "q": 0.051, "v": 0.09 } } });
        let ratio = field_error_ratio(&facts, &film).expect("both groups");
        assert!((ratio - 0.9).abs() < 1e-12, "{ratio}");
        assert_eq!(field_error_ratio(&json!({}), &film), None, "no truth");
    }

    #[test]
    fn a_scenario_without_facts_fails_in_every_chapter() {
        for scenario in super::super::scenarios::GATE {
            let wrong = judge(scenario, &json!({ "kernel_complaints": [] }), &json!({}));
            assert!(!wrong.is_empty(), "{} passes on nothing", scenario.plan);
        }
    }

    #[test]
    fn a_stale_frame_a_lost_frame_and_a_kernels_complaint_each_fail() {
        let plan = super::super::scenarios::GATE.iter().find(|s| matches!(s.must, Must::Stream(_)));
        let stream = plan.expect("there is one");
        let ok = json!({ "ok": true });
        let counters = json!({ "errors": 0, "stalls": 0, "overflows": 0, "timed_out": 0, "cancelled": 0,
            "no_device": 0, "repeated": 0, "damaged": 0, "starved": 0, "buffers_lost": 0, "pushed_errors": 0,
            "interrupt_errors": 0, "rungs": [0, 0, 0, 0, 0] });
        let good = json!({ "exit": 0, "kernel_complaints": [], "camera_health": counters,
            "losses": { "depth": { "short_frame": 0 }, "infrared": { "short_frame": 0 }, "payloads_dropped": 0 },
            "checks": { "energy_drift_step": ok, "entropy_falls": ok, "turns_late": ok, "allocations": ok },
            "turns": { "last_mode": "tracking", "stale_as_fresh": 0, "gaps": 0, "unread": 0, "fps": 60.0,
                       "frames": 3590, "interval_p99_us": 16_700 } });
        assert_eq!(judge(stream, &good, &json!({})), Vec::<String>::new());
        for (key, value) in [("stale_as_fresh", 1), ("gaps", 1), ("unread", 1)] {
            let mut bad = good.clone();
            bad["turns"][key] = value.into();
            assert_eq!(judge(stream, &bad, &json!({})).len(), 1, "{key}");
        }
        let mut bad = good.clone();
        bad["kernel_complaints"] = json!(["BUG: scheduling while atomic"]);
        assert_eq!(judge(stream, &bad, &json!({})).len(), 1);
        let mut bad = good;
        bad["losses"]["depth"]["short_frame"] = 1.into();
        assert_eq!(judge(stream, &bad, &json!({})).len(), 1);
    }
}
