//! The ladder of recovery: a state machine that decides, and does nothing itself.

use crate::transport::UsbError;
use meniscus::usb::d4xx::DeviceError;
use std::time::Duration;

/// Frames on every stream for this long end the climb.
const HEALTHY: Duration = Duration::from_secs(1);

/// Rung of the recovery ladder, mildest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rung {
    /// Cancel, drain, clear-halt, queue again.
    Requeue,
    /// The same with probe and commit.
    Renegotiate,
    /// The camera's own restart, and opening it anew.
    Restart,
    /// Reset of the USB port, and opening it anew.
    Reset,
    /// Waiting for the camera to be plugged in, and opening it by its serial number.
    Replug,
}

impl Rung {
    /// The next one; the last repeats.
    #[must_use]
    pub fn next(self) -> Self {
        match self {
            Self::Requeue => Self::Renegotiate,
            Self::Renegotiate => Self::Restart,
            Self::Restart => Self::Reset,
            Self::Reset | Self::Replug => Self::Replug,
        }
    }

    /// Time after which frames must have come.
    #[must_use]
    pub fn settle(self) -> Duration {
        Duration::from_millis(match self {
            Self::Requeue => 500,
            Self::Renegotiate => 1_500,
            Self::Restart | Self::Reset | Self::Replug => 2_000,
        })
    }
}

/// Trouble that starts or continues a recovery.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// No whole new frame on the named stream for too long.
    Silence(&'static str),
    /// Both streams bring frames, and none are of one instant.
    Apart,
    /// The named stream's endpoint is halted.
    Halted(&'static str),
    /// Damaged transfers in a row on the named stream.
    Damaged(&'static str),
    /// The camera pushed an error: a stream could not be started.
    Start(DeviceError),
    /// A transfer could not be queued.
    Submit(UsbError),
    /// The camera has left the bus.
    Gone,
    /// The rung did not work.
    Failed(Rung),
}

impl std::fmt::Display for Trouble {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Silence(stream) => write!(f, "no new {stream} frames"),
            Self::Apart => write!(f, "depth and outline come, but never of one instant"),
            Self::Halted(stream) => write!(f, "the {stream} endpoint is halted"),
            Self::Damaged(stream) => write!(f, "{stream} transfers are damaged"),
            Self::Start(error) => write!(f, "{error}"),
            Self::Submit(error) => write!(f, "a transfer cannot be queued: {error}"),
            Self::Gone => write!(f, "the camera has left the bus"),
            Self::Failed(rung) => write!(f, "{rung:?} did not work"),
        }
    }
}

/// Next step of the recovery.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Wait for the pause, then do this.
    Do(Rung, Duration),
    /// End the session.
    GiveUp,
}

/// Where on the ladder the session stands.
#[derive(Clone, Copy, Debug)]
pub struct Ladder {
    patience: Duration,
    since: Option<Duration>,
    next: Rung,
    replugs: u32,
    good_since: Option<Duration>,
}

impl Ladder {
    /// At the bottom.
    #[must_use]
    pub fn new(patience: Duration) -> Self {
        Self { patience, since: None, next: Rung::Requeue, replugs: 0, good_since: None }
    }

    /// Trouble: the next rung, or the end.
    pub fn climb(&mut self, trouble: Trouble, now: Duration) -> Step {
        self.good_since = None;
        let since = *self.since.get_or_insert(now);
        if now.saturating_sub(since) > self.patience {
            return Step::GiveUp;
        }
        let least = match trouble {
            Trouble::Gone => Rung::Replug,
            Trouble::Start(_) => Rung::Renegotiate,
            _ => Rung::Requeue,
        };
        let rung = self.next.max(least);
        self.next = rung.next();
        let pause = if rung == Rung::Replug {
            self.replugs = self.replugs.saturating_add(1);
            Duration::from_millis((50 << self.replugs.min(6)).min(2_000))
        } else {
            Duration::ZERO
        };
        Step::Do(rung, pause)
    }

    /// Every stream brings frames; whether this ends a climb.
    pub fn good(&mut self, now: Duration) -> bool {
        let good_since = *self.good_since.get_or_insert(now);
        let ends = self.since.is_some() && now.saturating_sub(good_since) >= HEALTHY;
        if ends {
            *self = Self::new(self.patience);
        }
        ends
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUIET: Trouble = Trouble::Silence("depth");

    fn at(seconds: u64) -> Duration {
        Duration::from_secs(seconds)
    }

    fn rung(step: Step) -> Option<Rung> {
        match step {
            Step::Do(rung, _) => Some(rung),
            Step::GiveUp => None,
        }
    }

    #[test]
    fn trouble_that_stays_climbs_to_the_top_and_ends() {
        let mut ladder = Ladder::new(at(60));
        let rungs: Vec<_> = (0..7).map(|s| rung(ladder.climb(QUIET, at(s)))).collect();
        let all = [Rung::Requeue, Rung::Renegotiate, Rung::Restart, Rung::Reset, Rung::Replug, Rung::Replug];
        assert_eq!(rungs[..6], all.map(Some));
        assert_eq!(ladder.climb(QUIET, at(61)), Step::GiveUp);
    }

    #[test]
    fn the_pause_before_a_re_plug_doubles_up_to_two_seconds() {
        let mut ladder = Ladder::new(at(600));
        let pause = |step| match step {
            Step::Do(Rung::Replug, pause) => pause.as_millis(),
            Step::Do(..) | Step::GiveUp => 0,
        };
        let pauses: Vec<_> = (0..7).map(|s| pause(ladder.climb(Trouble::Gone, at(s)))).collect();
        assert_eq!(pauses, [100, 200, 400, 800, 1600, 2000, 2000]);
    }

    #[test]
    fn only_a_second_of_frames_ends_the_climb() {
        let mut ladder = Ladder::new(at(60));
        ladder.climb(QUIET, at(0));
        assert!(!ladder.good(Duration::from_millis(100)) && !ladder.good(Duration::from_millis(1050)));
        assert_eq!(rung(ladder.climb(QUIET, Duration::from_millis(1060))), Some(Rung::Renegotiate));
        assert!(!ladder.good(at(2)) && ladder.good(at(3)));
        assert_eq!(rung(ladder.climb(QUIET, at(100))), Some(Rung::Requeue), "patience begins anew");
    }

    #[test]
    fn a_pushed_start_error_begins_at_the_negotiation() {
        let mut ladder = Ladder::new(at(60));
        assert_eq!(rung(ladder.climb(Trouble::Start(DeviceError(23)), at(0))), Some(Rung::Renegotiate));
        assert_eq!(rung(ladder.climb(QUIET, at(1))), Some(Rung::Restart));
    }
}
