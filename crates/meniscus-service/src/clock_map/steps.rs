//! Steps of the camera's clock, distinguished from frames that wait.
//!
//! A delay only ever adds to arrival minus camera time, so a frame below the envelope is a step once more frames agree. A
//! frame above it has waited, or the clock has stepped back; but a queue drains, so only what stays above is a step.

use meniscus::units::FRAME_INTERVAL_S;

/// Change of the offset from which on the camera's clock has restarted, s: far above any delay of a running camera.
pub(crate) const STEP_S: f64 = 1.0;

/// Frames in a row behind the envelope by [`STEP_S`], none of which catches up, after which the clock has restarted and is
/// not merely late.
pub(super) const STEP_FRAMES: u32 = 30;

/// Part of the delay that a queue makes up for in [`STEP_FRAMES`] frames at the least, s.
const DRAINED_S: f64 = FRAME_INTERVAL_S;

/// Change of the offset that is a step at all, s: well above the error of the envelope.
const GATE_S: f64 = 0.005;

/// Frames in a row below the envelope that agree within [`GATE_S`], after which the clock has stepped.
const EARLY_FRAMES: u32 = 3;

/// Frames in a row above the envelope after which the clock has stepped, where the camera's counter broke off before them
/// and where it did not: a busy host may delay every frame for a second.
const LATE_FRAMES: [u32; 2] = [20, 120];

/// Difference between the least delays of both halves of such a row above which a queue drains, s.
const EVEN_S: f64 = 0.002;

/// Verdict on a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// It is in the envelope or above it.
    Ordinary,
    /// It is below the envelope, which one frame alone does not move.
    Doubtful,
    /// The clock has stepped by less than [`STEP_S`].
    Stepped,
    /// The clock has restarted.
    Restarted,
}

/// A frame beside the envelope.
#[derive(Clone, Copy, Debug)]
pub(super) struct Compared {
    /// Arrival minus camera time, s.
    pub(super) seen_s: f64,
    /// The same less the envelope, s.
    pub(super) above_s: f64,
    /// Whether the camera's counter allows that its clock has restarted since the last frame.
    pub(super) may_restart: bool,
    /// Whether the envelope is so young that its frames may all have waited.
    pub(super) young: bool,
}

/// Frames in a row that are behind by [`STEP_S`] or more.
#[derive(Clone, Copy, Debug, Default)]
struct Behind {
    count: u32,
    first_s: f64,
}

/// Frames in a row that are above by [`GATE_S`] to [`STEP_S`].
#[derive(Clone, Copy, Debug, Default)]
struct Late {
    count: u32,
    wanted: u32,
    least_s: f64,
    least_of_first_half_s: f64,
}

/// Rows of frames that may turn out to be a step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Suspicion {
    behind: Behind,
    late: Late,
    /// Frames below the envelope, and the newest of them.
    early: u32,
    early_s: f64,
}

impl Suspicion {
    /// Judges a frame.
    pub(super) fn judge(&mut self, frame: Compared) -> Verdict {
        let Compared { seen_s, above_s, may_restart, young } = frame;
        if (may_restart && above_s < -STEP_S) || self.is_behind(frame) {
            return self.clear(Verdict::Restarted);
        }
        if above_s < -GATE_S && !young {
            let agrees = self.early > 0 && (seen_s - self.early_s).abs() < GATE_S;
            self.early = if agrees { self.early + 1 } else { 1 };
            self.early_s = seen_s;
            return if self.early >= EARLY_FRAMES { self.clear(Verdict::Stepped) } else { Verdict::Doubtful };
        }
        self.early = 0;
        if self.is_late(frame) { self.clear(Verdict::Stepped) } else { Verdict::Ordinary }
    }

    fn clear(&mut self, verdict: Verdict) -> Verdict {
        *self = Self::default();
        verdict
    }

    /// Whether enough frames have stayed behind by a restart. One that began anew looks like late frames, and so does a
    /// computer that stood still while frames queued.
    fn is_behind(&mut self, frame: Compared) -> bool {
        let Compared { seen_s, above_s, may_restart, .. } = frame;
        let behind = &mut self.behind;
        if above_s <= STEP_S {
            behind.count = 0;
        } else if behind.count > 0 && seen_s >= behind.first_s - DRAINED_S {
            behind.count += 1;
        } else if behind.count > 0 || may_restart {
            *behind = Behind { count: 1, first_s: seen_s };
        }
        behind.count > STEP_FRAMES
    }

    /// Whether enough frames have stayed above by less than a restart.
    fn is_late(&mut self, frame: Compared) -> bool {
        let Compared { above_s, may_restart, .. } = frame;
        if !(GATE_S..STEP_S).contains(&above_s) {
            self.late = Late::default();
            return false;
        }
        let late = &mut self.late;
        if late.count == 0 {
            let [after_a_break, else_] = LATE_FRAMES;
            let wanted = if may_restart { after_a_break } else { else_ };
            *late = Late { wanted, least_s: f64::INFINITY, ..Late::default() };
        }
        late.count += 1;
        late.least_s = late.least_s.min(above_s);
        if late.count == late.wanted / 2 {
            (late.least_of_first_half_s, late.least_s) = (late.least_s, f64::INFINITY);
        }
        if late.count < late.wanted {
            return false;
        }
        let even = (late.least_s - late.least_of_first_half_s).abs() < EVEN_S;
        *late = Late::default();
        even
    }
}
