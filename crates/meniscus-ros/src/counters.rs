//! Counters of what was published and what was not.

use std::sync::atomic::{AtomicU64, Ordering};

/// Counters, shared between the worker's end and the threads of the node.
#[derive(Debug, Default)]
pub struct Counters {
    /// Turns that were published.
    pub(crate) turns: AtomicU64,
    /// Turns that the publisher had no time for.
    pub(crate) queue_full: AtomicU64,
    /// Turns for a missing frame while a later one was there already: there is no state of them.
    pub(crate) overtaken: AtomicU64,
    /// Messages that the middleware did not take.
    pub(crate) refused: AtomicU64,
    /// Requests for a plan that were answered.
    pub(crate) plans: AtomicU64,
}

/// Values of the counters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Turns that were published.
    pub turns: u64,
    /// Turns that were left out by a full queue.
    pub queue_full: u64,
    /// Turns that a later frame had overtaken.
    pub overtaken: u64,
    /// Messages that the middleware did not take.
    pub refused: u64,
    /// Requests for a plan that were answered.
    pub plans: u64,
    /// Datagrams that could not be sent, by whatever network.
    pub unsent: u64,
}

impl Counters {
    /// Returns the values.
    #[must_use]
    pub fn counts(&self) -> Counts {
        let of = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        Counts {
            turns: of(&self.turns),
            queue_full: of(&self.queue_full),
            overtaken: of(&self.overtaken),
            refused: of(&self.refused),
            plans: of(&self.plans),
            unsent: crate::unsent::count(),
        }
    }
}

/// Adds one.
pub(crate) fn count(counter: &AtomicU64) {
    counter.fetch_add(1, Ordering::Relaxed);
}
