//! Counters of a commanded motion.

use super::stamped_counters::{StampedCounters, StampedCounts};
use super::tag_counts::TagCounts;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Counters of a commanded motion.
#[derive(Debug, Default)]
pub struct MotionCounters {
    /// Turns with a commanded motion.
    pub commanded: AtomicU64,
    /// Turns without a sample, which used the tracked position of the glass.
    pub tracked: AtomicU64,
    /// Turns whose commanded motion the camera denied. One from the wire is not used in them, a table is.
    pub contradicted: AtomicU64,
    /// Times that the camera denied the commanded motion.
    pub contradictions: AtomicU64,
    /// Samples that were taken from datagrams.
    pub samples: AtomicU64,
    /// Datagrams that are no acceleration, lack the token, or come twice.
    pub refused: AtomicU64,
    /// Datagrams of other senders.
    pub strangers: AtomicU64,
    /// Datagrams beyond the rate of a sender.
    pub flooded: AtomicU64,
    /// Counters of the stamped samples.
    pub stamped: StampedCounters,
    /// Counters of a tag's images; `None` of another motion.
    pub tag: Mutex<Option<TagCounts>>,
    /// The camera agrees again, which is not reported yet.
    pub(super) reconciled: AtomicBool,
}

impl MotionCounters {
    /// Returns the turns so far.
    #[must_use]
    pub fn turns(&self) -> MotionTurns {
        let of = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        MotionTurns {
            commanded: of(&self.commanded),
            tracked: of(&self.tracked),
            contradicted: of(&self.contradicted),
            contradictions: of(&self.contradictions),
            refused: of(&self.refused) + of(&self.strangers) + of(&self.flooded),
            stamped: self.stamped.counts(),
            tag: self.tag.lock().ok().and_then(|tag| *tag),
        }
    }
}

/// Turns by the origin of their motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionTurns {
    /// Turns with a commanded motion.
    pub commanded: u64,
    /// Turns that used the tracked position of the glass.
    pub tracked: u64,
    /// Turns whose commanded motion the camera denied.
    pub contradicted: u64,
    /// Times that the camera denied the commanded motion.
    pub contradictions: u64,
    /// Datagrams that were not taken.
    pub refused: u64,
    /// Stamped samples.
    pub stamped: StampedCounts,
    /// Images of a tag; `None` of another motion.
    pub tag: Option<TagCounts>,
}
