//! The camera's own book of a run, which the program's accounts are held against.

use meniscus_hil::device::{DEPTH, INFRARED};
use meniscus_hil::vhci::Witness;
use serde_json::{Value, json};
use std::time::SystemTime;

/// Frame interval, microseconds.
const INTERVAL_US: f64 = 1e6 / 60.0;

/// Figures of the book.
///
/// | key | meaning |
/// |---|---|
/// | `exposed` | frames that the camera took in the run's span, whether it sent them or not |
/// | `away` | frames of 60 Hz that it did not take in that span, because it was away from the bus or had not started |
/// | `read` | frames of which both payloads found a read of the program waiting |
///
/// The span begins with the first exposure and has the length that the program states.
pub(super) fn of(exposures_us: &[u64], over_s: f64, witness: &Witness, ended_at: SystemTime) -> Value {
    let Some(first_us) = exposures_us.first() else { return Value::Null };
    // The last frame of the span begins an interval before its end.
    let end_us = *first_us as f64 + 1e6 * over_s - 0.5 * INTERVAL_US;
    let within: Vec<f64> =
        exposures_us.iter().map(|at_us| *at_us as f64).filter(|at_us| *at_us < end_us).collect();
    let steps = within.windows(2).map(|pair| ((pair[1] - pair[0]) / INTERVAL_US).round());
    let away: f64 = steps.map(|steps| (steps - 1.0).max(0.0)).sum();
    let read = |endpoint: u8| {
        let payloads = witness.sent.iter().filter(|payload| payload.endpoint == endpoint);
        payloads.filter(|payload| payload.read && payload.at <= ended_at).count()
    };
    json!({ "exposed": within.len(), "away": away as u64, "read": read(DEPTH).min(read(INFRARED)) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_hil::vhci::Sent;
    use std::time::Duration;

    #[test]
    fn frames_of_a_camera_that_was_away_are_none_that_it_took() {
        // Ten frames, a second without any, ten more; the span ends before the last two.
        let at_us = |frame: u64| 30_000 + (frame * 1_000_000 + 30) / 60;
        let frames: Vec<u64> = (0..10).chain(70..80).collect();
        let exposures: Vec<u64> = frames.iter().map(|frame| at_us(*frame)).collect();
        let sent = |endpoint: u8, missed: u64| {
            let moment = move |frame: u64| SystemTime::UNIX_EPOCH + Duration::from_micros(at_us(frame));
            frames.clone().into_iter().map(move |frame| Sent {
                at: moment(frame),
                endpoint,
                counter: 0,
                read: frame != missed,
            })
        };
        let witness =
            Witness { sent: sent(DEPTH, 5).chain(sent(INFRARED, 99)).collect(), ..Witness::default() };
        let ended_at = SystemTime::UNIX_EPOCH + Duration::from_micros(at_us(78));
        let book = of(&exposures, 78.0 / 60.0, &witness, ended_at);
        assert_eq!(book, json!({ "exposed": 18, "away": 60, "read": 18 }));
        assert_eq!(of(&[], 1.0, &Witness::default(), ended_at), Value::Null);
    }
}
