//! Planned motion of the glass: jolts along x, with rest before and after.
//!
//! A jolt is one period of a sine of acceleration, so that the glass rests before and after it:
//! ```text
//! x'' = A sin(2 pi s),   x = A T^2/(2 pi) (s - sin(2 pi s)/(2 pi)),   s = (t - t0)/T
//! ```
//! Of period T near that of the first mode it leaves a crest of about `pi b A/g`: 9 mm for 1 m/s2 in the
//! glass of radius 35 mm.

use meniscus::units::FRAME_INTERVAL_S;
use std::f64::consts::TAU;
use std::fmt::Write;

/// Rest at the start, s: the frames from which the noise is learnt.
pub const REST_S: f64 = 0.4;

/// One jolt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jolt {
    /// Start, s.
    pub start_s: f64,
    /// Period T, s.
    pub period_s: f64,
    /// Acceleration A, m/s2.
    pub strength_m_s2: f64,
}

/// One motion of the glass along x.
#[derive(Clone, PartialEq)]
pub struct MotionPlan {
    /// Jolts in order of time.
    pub jolts: Vec<Jolt>,
    /// Length of the recording, s.
    pub seconds: f64,
}

impl std::fmt::Debug for MotionPlan {
    /// Writes jolts and length under the name `Course`: this text goes into the digests that name files of the study.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Course").field("jolts", &self.jolts).field("seconds", &self.seconds).finish()
    }
}

impl MotionPlan {
    /// Returns a single jolt of `period_s` and `strength_m_s2` in a recording of `seconds`.
    #[must_use]
    pub fn jolt(period_s: f64, strength_m_s2: f64, seconds: f64) -> Self {
        Self { jolts: vec![Jolt { start_s: REST_S, period_s, strength_m_s2 }], seconds }
    }

    /// Returns the number of frames of the recording.
    #[must_use]
    pub fn frames(&self) -> usize {
        (self.seconds / FRAME_INTERVAL_S).round() as usize
    }

    /// Returns the position of the glass at `time_s`, m.
    #[must_use]
    pub fn position(&self, time_s: f64) -> f64 {
        let one = |jolt: &Jolt| {
            let s = ((time_s - jolt.start_s) / jolt.period_s).clamp(0.0, 1.0);
            jolt.strength_m_s2 * jolt.period_s * jolt.period_s / TAU * (s - (TAU * s).sin() / TAU)
        };
        self.jolts.iter().map(one).sum()
    }

    /// Returns time and position every 4 ms.
    #[must_use]
    pub fn samples(&self) -> Vec<(f64, f64)> {
        let at = |n: usize| 0.004 * n as f64;
        (0..=(self.seconds / 0.004).ceil() as usize).map(|n| (at(n), self.position(at(n)))).collect()
    }

    /// Returns the motion file of [`Self::samples`].
    #[must_use]
    pub fn csv(&self) -> String {
        let mut text = String::from("t,x_m\n");
        for (t, x) in self.samples() {
            // Writing into a string cannot fail.
            let _ = writeln!(text, "{t:.3},{x:.9}");
        }
        text
    }
}
