//! The motions of the study: single jolts, pairs of jolts, slow jolts, and what the workflow may ask for.
//!
//! A jolt is one period of a sine of acceleration, so that the glass rests before and after it:
//! ```text
//! x'' = A sin(2 pi s),   x = A T^2/(2 pi) (s - sin(2 pi s)/(2 pi)),   s = (t - t0)/T
//! ```
//! Of period T near that of the first mode it leaves a crest of about `pi b A/g`: 9 mm for 1 m/s2 in the
//! glass of radius 35 mm. Six recordings belong to a course: two to fit, one to choose, one sealed;
//! more are asked for one by one.

use meniscus::units::FRAME_INTERVAL_S;
use std::f64::consts::TAU;
use std::fmt::Write;

/// The glass rests this long at the start, s: the frames from which the noise is learnt.
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
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// Jolts in order of time.
    pub jolts: Vec<Jolt>,
    /// Length of the recording, s.
    pub seconds: f64,
}

impl Course {
    /// A single jolt of `period_s` and `strength_m_s2` in a recording of `seconds`.
    #[must_use]
    pub fn jolt(period_s: f64, strength_m_s2: f64, seconds: f64) -> Self {
        Self { jolts: vec![Jolt { start_s: REST_S, period_s, strength_m_s2 }], seconds }
    }

    /// Frames of the recording.
    #[must_use]
    pub fn frames(&self) -> usize {
        (self.seconds / FRAME_INTERVAL_S).round() as usize
    }

    /// Place of the glass at `time_s`, m.
    #[must_use]
    pub fn position(&self, time_s: f64) -> f64 {
        let one = |jolt: &Jolt| {
            let s = ((time_s - jolt.start_s) / jolt.period_s).clamp(0.0, 1.0);
            jolt.strength_m_s2 * jolt.period_s * jolt.period_s / TAU * (s - (TAU * s).sin() / TAU)
        };
        self.jolts.iter().map(one).sum()
    }

    /// Time and place every 4 ms.
    #[must_use]
    pub fn samples(&self) -> Vec<(f64, f64)> {
        let at = |n: usize| 0.004 * n as f64;
        (0..=(self.seconds / 0.004).ceil() as usize).map(|n| (at(n), self.position(at(n)))).collect()
    }

    /// The motion file of [`Self::samples`].
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

/// The kinds of course that a glass of liquid is taken through.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    /// One jolt at the first mode's period.
    Single,
    /// A short jolt and a longer one the other way.
    Double,
    /// One jolt half as long again.
    Slow,
    /// What may be asked for.
    Asked,
}

/// The courses of a kind; the last is the sealed one (none is among those that may be asked for).
#[must_use]
pub fn courses(kind: Kind) -> Vec<Course> {
    const SECONDS: f64 = 2.2;
    let double = |strength: f64| Course {
        jolts: vec![
            Jolt { start_s: REST_S, period_s: 0.20, strength_m_s2: strength },
            Jolt { start_s: 0.9, period_s: 0.30, strength_m_s2: -0.8 * strength },
        ],
        seconds: SECONDS,
    };
    match kind {
        Kind::Single => [0.6, 1.25, 2.2, 1.7].map(|a| Course::jolt(0.28, a, SECONDS)).to_vec(),
        Kind::Double => [0.7, 1.3, 2.0, 1.6].map(double).to_vec(),
        Kind::Slow => [0.7, 1.2, 1.9, 1.5].map(|a| Course::jolt(0.40, a, SECONDS)).to_vec(),
        Kind::Asked => [(0.28, 2.0, 4.4), (0.16, 3.0, 2.2), (0.28, 0.3, 2.2)]
            .map(|(period, strength, seconds)| Course::jolt(period, strength, seconds))
            .to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_course_starts_and_ends_at_rest_and_has_the_acceleration_of_its_jolts() {
        for kind in [Kind::Single, Kind::Double, Kind::Slow, Kind::Asked] {
            for course in courses(kind) {
                let h = 1e-4;
                let second = |t: f64| {
                    (course.position(t + h) - 2.0 * course.position(t) + course.position(t - h)) / (h * h)
                };
                assert!(second(0.3).abs() < 1e-6 && second(course.seconds - 0.1).abs() < 1e-6);
                let jolt = course.jolts[0];
                let quarter = second(jolt.start_s + 0.25 * jolt.period_s);
                assert!((quarter / jolt.strength_m_s2 - 1.0).abs() < 1e-3, "{quarter}");
                assert!(course.position(1e3).abs() < 0.065, "{course:?} goes too far");
            }
        }
    }
}
