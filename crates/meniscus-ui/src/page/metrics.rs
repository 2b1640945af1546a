//! Figures of the newest turn in Prometheus' text format: `GET /metrics` of the page.
//!
//! The numbers are those of a frame; a scrape counts as a viewer for as long as it waits for one. Names, units and `_total` follow
//! Prometheus' conventions (<https://prometheus.io/docs/practices/naming/>, format 0.0.4). A number that is not known has no line.

use super::board::Board;
use super::frame::NUMBERS;
use std::fmt::Write;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Kind of the answer, as HTTP spells it.
pub(super) const KIND: &str = "text/plain; version=0.0.4; charset=utf-8";

/// Time that a scrape waits for a turn.
const PATIENCE: Duration = Duration::from_millis(500);

/// Bytes of a frame before its numbers.
const HEAD: usize = 16;

/// Modes by their number in a frame.
const MODES: [&str; 4] = ["filling", "tracking", "coasting", "halted"];

/// A metric.
struct Metric {
    /// Number of the frame that it shows.
    number: &'static str,
    /// Name, without `meniscus_`.
    name: &'static str,
    /// Whether it only rises.
    counts: bool,
    /// Factor to its unit.
    scale: f64,
    /// Help.
    help: &'static str,
}

const fn count(number: &'static str, name: &'static str, help: &'static str) -> Metric {
    Metric { number, name, counts: true, scale: 1.0, help }
}

const fn gauge(number: &'static str, name: &'static str, scale: f64, help: &'static str) -> Metric {
    Metric { number, name, counts: false, scale, help }
}

/// All metrics, in the order of the answer.
const METRICS: [Metric; 21] = [
    count("turns", "turns_total", "Turns of the estimator."),
    count("tracking", "turns_tracking_total", "Turns with the surface tracked."),
    count("coasting", "turns_coasting_total", "Turns that were predicted without a surface."),
    count("halted", "turns_halted_total", "Turns in which nothing is known."),
    count("frames_taken", "frames_taken_total", "Frames that the camera took."),
    count("frames_late", "frames_late_total", "Frames that were handled after their deadline."),
    count("frames_lost", "frames_lost_total", "Frames that were lost on the way."),
    count("frames_never_handled", "frames_never_handled_total", "Frames that came and were never handled."),
    count("deadline_missed", "deadline_missed_total", "Frames that were late, lost or never handled."),
    count("frames_missing", "frames_missing_total", "Turns without a frame."),
    count("not_seen", "surface_not_seen_total", "Frames in which the surface was not found."),
    count("field_shed", "field_shed_total", "Turns whose full field was left out to keep the deadline."),
    gauge("turn_us", "turn_seconds", 1e-6, "Time of the last turn."),
    gauge("latency_us", "latency_seconds", 1e-6, "Time from the last frame's arrival to its estimate."),
    gauge("unseen_s", "unseen_seconds", 1.0, "Time since a frame came."),
    gauge("points_seen", "surface_points", 1.0, "Points of the surface that the last frame showed, of 21."),
    gauge("slosh_j", "slosh_joules", 1.0, "Energy of the slosh."),
    gauge(
        "energy_residual",
        "energy_residual",
        1.0,
        "Relative error of the energy balance of the last step.",
    ),
    gauge("crest_m", "crest_meters", 1.0, "Height of the next crest."),
    gauge("crest_half_m", "crest_interval_meters", 1.0, "Half-width of its 90 % interval."),
    gauge("viewers", "page_viewers", 1.0, "Viewers of the page."),
];

/// The answer to a scrape of `board`; none where no turn came in time.
pub(super) fn metrics(board: &Board) -> Option<String> {
    board.viewers.fetch_add(1, Ordering::Relaxed);
    // A frame that was put up before somebody looked may be old.
    let frame = board.newer(board.number(), Instant::now(), PATIENCE);
    let others = board.viewers.fetch_sub(1, Ordering::Relaxed).saturating_sub(1);
    let ((_, frame), _) = frame?;
    text(&frame, others)
}

/// The numbers of `frame` as text, beside `viewers` who look at the page.
fn text(frame: &[u8], viewers: usize) -> Option<String> {
    let mode = MODES.get(usize::from(*frame.get(1)?))?;
    let (numbers, _) = frame.get(HEAD..)?.as_chunks::<8>();
    let number = |name: &str| {
        let place = NUMBERS.iter().position(|(known, _)| *known == name)?;
        Some(f64::from_le_bytes(*numbers.get(place)?))
    };
    let mut out = String::with_capacity(4096);
    for Metric { number: from, name, counts, scale, help } in &METRICS {
        let value = if *from == "viewers" { viewers as f64 } else { number(from)? * scale };
        if value.is_nan() {
            continue;
        }
        let kind = if *counts { "counter" } else { "gauge" };
        // A `String` takes every line.
        let _written = writeln!(
            out,
            "# HELP meniscus_{name} {help}\n# TYPE meniscus_{name} {kind}\nmeniscus_{name} {value}"
        );
    }
    let _written = writeln!(
        out,
        "# HELP meniscus_mode Mode of the estimator: 1 for the present one.\n# TYPE meniscus_mode gauge"
    );
    for known in MODES {
        let _written = writeln!(out, "meniscus_mode{{mode=\"{known}\"}} {}", u8::from(known == *mode));
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame whose numbers are their places.
    fn frame(mode: u8) -> Vec<u8> {
        let mut bytes = vec![1, mode, 0, 0];
        bytes.resize(HEAD, 0);
        (0..NUMBERS.len()).for_each(|place| bytes.extend_from_slice(&(place as f64).to_le_bytes()));
        bytes
    }

    #[test]
    fn every_metric_shows_the_number_that_it_names() {
        let text = text(&frame(1), 3).expect("a whole frame");
        for metric in &METRICS {
            let place = NUMBERS.iter().position(|(name, _)| *name == metric.number);
            let place = place.unwrap_or_else(|| panic!("a frame has no {}", metric.number));
            let value = if metric.number == "viewers" { 3.0 } else { place as f64 * metric.scale };
            assert!(
                text.contains(&format!("\nmeniscus_{} {value}\n", metric.name)),
                "{}: {text}",
                metric.name
            );
            assert_eq!(metric.counts, metric.name.ends_with("_total"), "{}", metric.name);
        }
        assert!(
            text.contains("meniscus_mode{mode=\"tracking\"} 1\n") && text.contains("{mode=\"halted\"} 0\n")
        );
    }

    #[test]
    fn what_is_not_known_has_no_line_and_half_a_frame_no_answer() {
        let mut unknown = frame(0);
        let place = NUMBERS.iter().position(|(name, _)| *name == "crest_m").expect("a crest");
        unknown[HEAD + 8 * place..][..8].copy_from_slice(&f64::NAN.to_le_bytes());
        let text_of = text(&unknown, 0).expect("a whole frame");
        assert!(!text_of.contains("crest_meters") && text_of.contains("crest_interval_meters"));
        assert_eq!(text(&unknown[..100], 0), None);
        assert_eq!(text(&frame(9), 0), None);
    }
}
