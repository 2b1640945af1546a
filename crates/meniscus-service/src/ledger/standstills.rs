//! Standstills of the host: the last few intervals in which the worker had no processor or was kept busy by a sink.

use meniscus::units::FRAME_INTERVAL_S;

/// Standstills that are remembered; more of them between two frames that came are joined.
const KEPT: usize = 8;

/// Time before and after a standstill in which a missing frame is still put down to it: a payload that was on its way when
/// the host stopped, and one that found nothing queued for it right after.
const SLACK_S: f64 = 2.0 * FRAME_INTERVAL_S;

/// An interval in seconds on the host's clock.
#[derive(Clone, Copy, Debug, Default)]
struct Interval {
    begin_s: f64,
    end_s: f64,
}

/// The last standstills, oldest first.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Standstills {
    kept: [Interval; KEPT],
    number: usize,
}

impl Standstills {
    /// Adds a standstill that is later than all others.
    pub(super) fn add(&mut self, begin_s: f64, end_s: f64) {
        let new = Interval { begin_s: begin_s - SLACK_S, end_s: end_s + SLACK_S };
        let newest = self.number.checked_sub(1).and_then(|newest| self.kept.get_mut(newest));
        if let Some(newest) = newest.filter(|newest| newest.end_s >= new.begin_s) {
            newest.end_s = new.end_s;
            return;
        }
        if self.number == KEPT {
            self.kept.rotate_left(1);
            self.number -= 1;
        }
        self.kept[self.number] = new;
        self.number += 1;
    }

    /// Returns how many of the `missing` frames after the one that was due at `last_due_s` were due in a standstill.
    pub(super) fn due_within(&self, last_due_s: f64, missing: u64) -> u64 {
        let place = |at_s: f64| (at_s - last_due_s) / FRAME_INTERVAL_S;
        let inside = |standstill: &Interval| {
            let first = place(standstill.begin_s).ceil().max(1.0);
            let last = place(standstill.end_s).floor().min(missing as f64);
            (last - first + 1.0).max(0.0) as u64
        };
        self.kept.iter().take(self.number).map(inside).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_due_in_a_standstill_are_found_whatever_their_number() {
        let mut standstills = Standstills::default();
        assert_eq!(standstills.due_within(10.0, 600), 0);
        standstills.add(11.001, 14.001);
        // 180 frames in 3 s, and two in the slack on either side.
        assert_eq!(standstills.due_within(10.0, 600), 184);
        assert_eq!(standstills.due_within(10.0, 30), 0, "the next frame came before it");
        assert_eq!(standstills.due_within(15.0, 600), 0, "it was over");
        assert_eq!(standstills.due_within(10.0, 90), 32);
    }

    #[test]
    fn standstills_that_touch_are_one_and_the_oldest_are_forgotten() {
        let mut standstills = Standstills::default();
        standstills.add(1.0, 1.1);
        standstills.add(1.12, 1.2);
        assert_eq!(standstills.number, 1);
        (2..20).for_each(|second| standstills.add(f64::from(second), f64::from(second) + 0.1));
        assert_eq!(standstills.number, KEPT);
        assert_eq!(standstills.due_within(1.0, 60), 0, "the first is forgotten");
        assert!(standstills.due_within(19.0, 30) > 5);
    }
}
