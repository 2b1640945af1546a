//! Frames of both streams at one instant: whether any come.
//!
//! Streams that both bring frames can still be useless: after a bad start one may be a frame or more away from the other for good.
//! The time stamps as sent tell, whatever the clock did.

use std::time::Duration;

/// Frames of a stream that are remembered: one stream may come behind some of the other.
const REMEMBERED: usize = 4;

/// Two frames are of one instant when their time stamps differ by no more, microseconds: half of a frame interval.
const APART_US: u32 = 8_333;

/// Watch over the partners of frames.
#[derive(Clone, Copy, Debug)]
pub(super) struct Partners {
    recent: [[Option<u32>; REMEMBERED]; 2],
    /// When two frames of one instant last came, or the watch began.
    pub(super) last: Duration,
    /// Whether any came since it began.
    pub(super) met: bool,
}

impl Partners {
    /// A watch that begins now.
    pub(super) fn started(now: Duration) -> Self {
        Self { recent: [[None; REMEMBERED]; 2], last: now, met: false }
    }

    /// Notes a whole frame of the stream at `place` with the time stamp `pts`.
    pub(super) fn saw(&mut self, place: usize, pts: u32, now: Duration) {
        let near = |other: &u32| pts.wrapping_sub(*other).min(other.wrapping_sub(pts)) <= APART_US;
        let [own, other] = if place == 0 { [0, 1] } else { [1, 0] };
        if self.recent[other].iter().flatten().any(near) {
            (self.last, self.met) = (now, true);
        }
        self.recent[own].rotate_right(1);
        self.recent[own][0] = Some(pts);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn frames_meet_over_the_rollover_and_behind_the_others_next_frame() {
        let mut partners = Partners::started(at(0));
        partners.saw(0, u32::MAX - 50, at(1));
        partners.saw(0, 16_616, at(17));
        assert!(!partners.met);
        partners.saw(1, 10, at(18));
        assert_eq!((partners.met, partners.last), (true, at(18)));
    }

    #[test]
    fn streams_that_are_apart_never_meet() {
        let mut partners = Partners::started(at(0));
        for frame in 0..600_u32 {
            partners.saw(0, 16_667 * frame, at(17 * u64::from(frame)));
            partners.saw(1, 16_667 * frame + 1_000_000, at(17 * u64::from(frame)));
        }
        assert!(!partners.met && partners.last == at(0));
    }
}
