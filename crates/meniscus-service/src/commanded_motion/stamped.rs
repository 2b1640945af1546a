//! Stamped samples of the motion of the glass: put in order, projected onto the line of the model, differentiated.
//!
//! ```text
//! x_i = n . p_i                               p position, n direction of the line in the sender's axes
//! across_i = |(p_i - n x_i) - (p_0 - n x_0)|  what the model leaves out
//! a = n . a_i                                 where the sender states accelerations; else
//! a = (v_i - v_j) / (t_i - t_j)               at (t_i + t_j) / 2, from velocities; else
//! a = 2 / (t_i - t_k) [ (x_i - x_j) / (t_i - t_j) - (x_j - x_k) / (t_j - t_k) ]    at (t_i + t_j + t_k) / 3
//! ```
//! The divided differences are over samples at least [`APART_S`] apart.

use super::frame::MotionFrame;
use super::samples::{KEPT, Samples};
use std::collections::VecDeque;

/// Least time between the samples of a difference, s.
const APART_S: f64 = 0.004;
/// Time by which a stamp may be ahead of now: a command is known before it is carried out, s.
const AHEAD_S: f64 = 0.1;
/// Age from which on no turn wants a sample, s.
const STALE_S: f64 = 0.25;
/// Two stamps nearer than this are one, s.
const SAME_S: f64 = 1e-6;
/// Distance from the line from which on a sample counts as across it, m.
const ACROSS_M: f64 = 0.002;

/// Outcome of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Taken {
    /// It is the newest one.
    InOrder,
    /// It is older than another one and was put where it belongs.
    Late,
    /// Its stamp is there already.
    Repeated,
    /// Its stamp is too far in the past.
    Stale,
    /// Its stamp is in the future.
    Future,
}

/// One sample on the line.
#[derive(Clone, Copy, Debug)]
struct OnLine {
    time_s: f64,
    position_m: f64,
    velocity_m_s: Option<f64>,
    acceleration_m_s2: Option<f64>,
}

/// Samples on the line, oldest first.
#[derive(Debug)]
pub(super) struct StampedSamples {
    line: [f64; 3],
    kept: VecDeque<OnLine>,
    /// Part of the first position that is across the line.
    origin: Option<[f64; 3]>,
    /// Accelerations from them.
    pub(super) samples: Samples,
}

impl StampedSamples {
    /// Returns room for samples of a motion whose line has the direction `line` in the sender's axes, of length one.
    pub(super) fn room(line: [f64; 3]) -> Self {
        Self { line, kept: VecDeque::with_capacity(KEPT), origin: None, samples: Samples::room() }
    }

    /// Forgets all samples: their clock has begun anew.
    pub(super) fn clear(&mut self) {
        self.kept.clear();
        self.samples.clear();
    }

    /// Returns whether the position of `frame` is off the line that goes through the first one.
    pub(super) fn is_across(&mut self, frame: &MotionFrame) -> bool {
        let along_m = dot(&self.line, &frame.position_m);
        let across: [f64; 3] = std::array::from_fn(|axis| frame.position_m[axis] - along_m * self.line[axis]);
        let origin = *self.origin.get_or_insert(across);
        let off: [f64; 3] = std::array::from_fn(|axis| across[axis] - origin[axis]);
        dot(&off, &off).sqrt() > ACROSS_M
    }

    /// Takes the sample of `frame`, whose instant is `time_s`, at `now_s`.
    pub(super) fn take(&mut self, frame: &MotionFrame, time_s: f64, now_s: f64) -> Taken {
        if time_s > now_s + AHEAD_S {
            return Taken::Future;
        }
        if time_s < now_s - STALE_S {
            return Taken::Stale;
        }
        let place = self.kept.partition_point(|kept| kept.time_s < time_s);
        let near = [place.checked_sub(1), Some(place)].into_iter().flatten().filter_map(|k| self.kept.get(k));
        if near.into_iter().any(|kept| (kept.time_s - time_s).abs() < SAME_S) {
            return Taken::Repeated;
        }
        let newest = place == self.kept.len();
        if self.kept.len() == KEPT {
            self.kept.pop_front();
        }
        let along = |vector: &[f64; 3]| dot(&self.line, vector);
        let sample = OnLine {
            time_s,
            position_m: along(&frame.position_m),
            velocity_m_s: frame.velocity_m_s.as_ref().map(along),
            acceleration_m_s2: frame.acceleration_m_s2.as_ref().map(along),
        };
        self.kept.insert(place.min(self.kept.len()), sample);
        if newest {
            if let Some(sample) = self.acceleration(self.kept.len() - 1) {
                self.samples.push(sample);
            }
            return Taken::InOrder;
        }
        self.samples.clear();
        for index in 0..self.kept.len() {
            if let Some(sample) = self.acceleration(index) {
                self.samples.push(sample);
            }
        }
        Taken::Late
    }

    /// Returns the time and the acceleration of which sample `index` is the last; `None` where the ones before do not
    /// suffice.
    fn acceleration(&self, index: usize) -> Option<(f64, f64)> {
        let last = self.kept.get(index)?;
        if let Some(acceleration) = last.acceleration_m_s2 {
            return Some((last.time_s, acceleration));
        }
        let middle = self.kept.range(..index).rev().find(|kept| last.time_s - kept.time_s >= APART_S)?;
        let late_s = last.time_s - middle.time_s;
        if let (Some(v1), Some(v0)) = (last.velocity_m_s, middle.velocity_m_s) {
            return Some((0.5 * (last.time_s + middle.time_s), (v1 - v0) / late_s));
        }
        let first = self.kept.range(..index).rev().find(|kept| middle.time_s - kept.time_s >= APART_S)?;
        let early_s = middle.time_s - first.time_s;
        let bend =
            (last.position_m - middle.position_m) / late_s - (middle.position_m - first.position_m) / early_s;
        let time_s = (last.time_s + middle.time_s + first.time_s) / 3.0;
        Some((time_s, 2.0 * bend / (late_s + early_s)))
    }
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::super::frame::StampClock;
    use super::*;

    /// A glass that swings by 10 mm at 20 rad/s along a line at 30 degrees to the sender's axes.
    const LINE: [f64; 3] = [0.866_025_403_784_438_6, 0.5, 0.0];

    #[derive(Clone, Copy)]
    enum Stated {
        Position,
        Velocity,
        Acceleration,
    }

    fn frame(time_s: f64, stated: Stated) -> MotionFrame {
        let along = |value: f64| LINE.map(|n| n * value);
        let (sin, cos) = (20.0 * time_s).sin_cos();
        MotionFrame {
            clock: StampClock::Host,
            sequence: 0,
            stamp_ns: 0,
            position_m: along(0.01 * sin),
            velocity_m_s: matches!(stated, Stated::Velocity).then(|| along(0.2 * cos)),
            acceleration_m_s2: matches!(stated, Stated::Acceleration).then(|| along(-4.0 * sin)),
        }
    }

    fn fed(stated: Stated, order: &[u32]) -> (StampedSamples, Vec<Taken>) {
        let mut samples = StampedSamples::room(LINE);
        let taken = order.iter().map(|k| {
            let time_s = f64::from(*k) * 0.005;
            samples.take(&frame(time_s, stated), time_s, f64::from(*order.iter().max().unwrap_or(&0)) * 0.005)
        });
        let taken = taken.collect();
        (samples, taken)
    }

    #[test]
    fn accelerations_are_those_of_the_motion_whatever_is_stated() {
        let order: Vec<u32> = (0..40).collect();
        for (stated, bound) in
            [(Stated::Acceleration, 0.02), (Stated::Velocity, 0.03), (Stated::Position, 0.04)]
        {
            let (samples, taken) = fed(stated, &order);
            assert!(taken.iter().all(|taken| *taken == Taken::InOrder));
            for k in 6..36 {
                let time_s = f64::from(k) * 0.005 + 0.001;
                let (now, due) =
                    (samples.samples.now(time_s).expect("between samples"), -4.0 * (20.0 * time_s).sin());
                assert!((now - due).abs() < bound, "{time_s}: {now} for {due}");
            }
        }
    }

    #[test]
    fn samples_out_of_order_give_the_same_as_in_order() {
        let straight: Vec<u32> = (0..40).collect();
        let mut mixed = straight.clone();
        mixed.swap(10, 12);
        mixed.swap(25, 26);
        let (due, _) = fed(Stated::Position, &straight);
        let (is, taken) = fed(Stated::Position, &mixed);
        assert_eq!(taken.iter().filter(|taken| **taken == Taken::Late).count(), 3);
        for k in 6..36 {
            let time_s = f64::from(k) * 0.005 + 0.002;
            assert_eq!(is.samples.now(time_s), due.samples.now(time_s), "{time_s}");
        }
    }

    #[test]
    fn stamps_that_cannot_be_are_named_and_what_is_across_is_noticed() {
        let mut samples = StampedSamples::room(LINE);
        let of = |time_s: f64| frame(time_s, Stated::Acceleration);
        assert_eq!(samples.take(&of(1.0), 1.0, 1.0), Taken::InOrder);
        assert_eq!(samples.take(&of(1.0), 1.0, 1.0), Taken::Repeated);
        assert_eq!(samples.take(&of(0.7), 0.7, 1.0), Taken::Stale);
        assert_eq!(samples.take(&of(1.6), 1.6, 1.0), Taken::Future);
        assert_eq!(samples.take(&of(1.09), 1.09, 1.0), Taken::InOrder, "a command is known before");
        assert!(!samples.is_across(&of(1.0)) && !samples.is_across(&of(1.07)), "along the line");
        let beside = MotionFrame { position_m: [0.0, 0.0, 0.003], ..of(1.0) };
        assert!(samples.is_across(&beside));
    }
}
