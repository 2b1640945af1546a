//! Samples of an acceleration over time, and what a turn takes from them.

use meniscus::units::FRAME_INTERVAL_S;
use std::collections::VecDeque;

/// Samples that are kept: a quarter of a second at 1 kHz.
pub(super) const KEPT: usize = 256;
/// Time for which the newest sample is extrapolated, seconds; after it the tracked position of the glass is used.
const HOLD_S: f64 = 0.025;

/// Accelerations of an image and of the one before it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Accelerations {
    /// At the image before, m/s2.
    pub(super) before: f64,
    /// At the image, m/s2.
    pub(super) now: f64,
}

/// Samples, oldest first: time in seconds, acceleration in m/s2.
#[derive(Debug, Default)]
pub(super) struct Samples(VecDeque<(f64, f64)>);

impl Samples {
    /// Returns room for [`KEPT`] samples.
    pub(super) fn room() -> Self {
        Self(VecDeque::with_capacity(KEPT))
    }

    /// Returns the samples of a table, which are in order.
    pub(super) fn table(samples: impl Iterator<Item = (f64, f64)>) -> Self {
        Self(samples.collect())
    }

    /// Forgets all samples.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// Adds a sample in place of the oldest one; a sample that is not newer than the last is left out.
    pub(super) fn push(&mut self, sample: (f64, f64)) {
        if self.0.back().is_some_and(|(t, _)| sample.0 <= *t) {
            return;
        }
        if self.0.len() == KEPT {
            self.0.pop_front();
        }
        self.0.push_back(sample);
    }

    /// Replaces the acceleration of the newest sample by a better one.
    pub(super) fn correct_newest(&mut self, acceleration: f64) {
        if let Some(newest) = self.0.back_mut() {
            newest.1 = acceleration;
        }
    }

    /// Acceleration between the samples around `time_s`; `None` before the first and beyond the last one's hold.
    pub(super) fn now(&self, time_s: f64) -> Option<f64> {
        let after = self.0.partition_point(|(t, _)| *t <= time_s);
        let (t0, a0) = *self.0.get(after.checked_sub(1)?)?;
        match self.0.get(after) {
            Some((t1, a1)) => Some(a0 + (a1 - a0) * (time_s - t0) / (t1 - t0)),
            None => (time_s - t0 <= HOLD_S).then_some(a0),
        }
    }

    /// The mean around `time_s` with the weights of the second difference; as [`Self::now`] where no sample lies there.
    pub(super) fn around(&self, time_s: f64) -> Option<f64> {
        let h = FRAME_INTERVAL_S;
        let first = self.0.partition_point(|(t, _)| *t <= time_s - h);
        let near = self.0.range(first..).take_while(|(t, _)| *t < time_s + h);
        let (sum, weights) = near.fold((0.0, 0.0), |(sum, weights), (t, a)| {
            let weight = 1.0 - (t - time_s).abs() / h;
            (sum + weight * a, weights + weight)
        });
        if weights > 0.0 { Some(sum / weights) } else { self.now(time_s) }
    }
}
