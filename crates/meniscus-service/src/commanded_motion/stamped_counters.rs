//! Counters of the stamped samples.

use std::sync::atomic::{AtomicU64, Ordering};

/// Counters of the stamped samples.
#[derive(Debug, Default)]
pub struct StampedCounters {
    /// Samples that were taken.
    pub taken: AtomicU64,
    /// Samples of them that came behind a newer one.
    pub late: AtomicU64,
    /// Sequence numbers that never came.
    pub lost: AtomicU64,
    /// Samples of them that are off the line that the model knows.
    pub across: AtomicU64,
    /// Samples whose stamp was too old.
    pub stale: AtomicU64,
    /// Samples whose stamp was in the future.
    pub future: AtomicU64,
    /// Samples that came twice.
    pub repeated: AtomicU64,
    /// Frames of another version, length or range.
    pub malformed: AtomicU64,
    /// Messages whose stamp was zero.
    pub unstamped: AtomicU64,
    /// Messages whose quaternion was not of unit length.
    pub unsound: AtomicU64,
    /// Times that nothing came for seconds.
    pub absent: AtomicU64,
    /// Times that the stream stopped.
    pub stops: AtomicU64,
    /// Steps and restarts of the sender's clock.
    pub clock_steps: AtomicU64,
}

/// The same, read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[allow(missing_docs, reason = "each is described at StampedCounters")]
pub struct StampedCounts {
    pub taken: u64,
    pub late: u64,
    pub lost: u64,
    pub across: u64,
    pub stale: u64,
    pub future: u64,
    pub repeated: u64,
    pub malformed: u64,
    pub unstamped: u64,
    pub unsound: u64,
    pub absent: u64,
    pub stops: u64,
    pub clock_steps: u64,
}

impl StampedCounters {
    /// Returns what was counted so far.
    #[must_use]
    pub fn counts(&self) -> StampedCounts {
        let of = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        StampedCounts {
            taken: of(&self.taken),
            late: of(&self.late),
            lost: of(&self.lost),
            across: of(&self.across),
            stale: of(&self.stale),
            future: of(&self.future),
            repeated: of(&self.repeated),
            malformed: of(&self.malformed),
            unstamped: of(&self.unstamped),
            unsound: of(&self.unsound),
            absent: of(&self.absent),
            stops: of(&self.stops),
            clock_steps: of(&self.clock_steps),
        }
    }
}
