//! First frames of a run, judged again as the clock map learns.
//!
//! The map knows the earliest arrival from the frames that came. Where the first ones waited, because the program was still
//! starting or the machine was busy, each is in time by all that is known then. The first frame that waits less shows that
//! they were late.

use super::DEADLINE_S;

/// Number of frames that are judged again: those of two seconds, in which a drift of 100 ppm moves a due time by 0.2 ms.
const KEPT: usize = 120;

/// Frame of a camera that runs by its own clock, for the map between that clock and the host's.
#[derive(Clone, Copy, Debug)]
pub(super) struct Judged {
    /// End of its turn less its camera time, s.
    pub(super) ended_s: f64,
    /// Its due time less its camera time, s.
    pub(super) due_s: f64,
}

/// The first frames. The memory is fixed.
#[derive(Clone, Copy, Debug)]
pub(super) struct FirstFrames {
    /// End of each frame's turn less its camera time, s.
    ended_s: [f64; KEPT],
    number: usize,
    /// Those that are booked as late.
    late: u64,
    closed: bool,
}

impl Default for FirstFrames {
    fn default() -> Self {
        Self { ended_s: [0.0; KEPT], number: 0, late: 0, closed: false }
    }
}

impl FirstFrames {
    /// Judges no frame again from here on.
    pub(super) fn close(&mut self) {
        self.closed = true;
    }

    /// Takes a frame, which is booked by its own due time. Returns how many of the frames before it turn out to have been
    /// late.
    pub(super) fn take(&mut self, frame: Judged) -> u64 {
        if self.closed {
            return 0;
        }
        let late = |ended_s: f64| ended_s - frame.due_s > DEADLINE_S;
        let before = self.ended_s.iter().take(self.number).filter(|ended_s| late(**ended_s)).count() as u64;
        let found = before.saturating_sub(self.late);
        self.late += found + u64::from(late(frame.ended_s));
        if let Some(place) = self.ended_s.get_mut(self.number) {
            *place = frame.ended_s;
            self.number += 1;
        }
        self.closed = self.number == KEPT;
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_that_waits_less_shows_that_the_earlier_ones_were_late() {
        let mut first = FirstFrames::default();
        // Arrivals behind the camera's clock, s; a turn takes 1 ms; the map's due time is the least of them so far.
        let waited: [f64; 9] = [0.054, 0.053, 0.042, 0.036, 0.010, 0.012, 0.009, 0.009, 0.040];
        let found = [0, 0, 0, 2, 2, 0, 0, 0, 0];
        let mut due_s = f64::INFINITY;
        for (waited, found) in waited.into_iter().zip(found) {
            due_s = waited.min(due_s);
            assert_eq!(
                first.take(Judged { ended_s: 1e3 + waited + 0.001, due_s: 1e3 + due_s }),
                found,
                "{waited}"
            );
        }
        first.close();
        assert_eq!(first.take(Judged { ended_s: 0.0, due_s: -1.0 }), 0);
    }

    #[test]
    fn only_the_first_frames_are_judged_again() {
        let mut first = FirstFrames::default();
        (0..KEPT).for_each(|_| assert_eq!(first.take(Judged { ended_s: 0.1, due_s: 0.1 }), 0));
        assert_eq!(first.take(Judged { ended_s: 0.0, due_s: 0.0 }), 0);
    }
}
