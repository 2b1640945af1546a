//! The log of a run: every turn with what it cost, in memory that was there before the first frame.

use crate::identify::Standing;
use meniscus::runtime::Turn;
use meniscus::runtime::health::Health;
use meniscus::usb::uvc::{Losses, Solitary};
use std::time::Instant;

/// One turn and what it cost.
#[derive(Clone, Copy, Debug)]
pub struct Logged {
    /// The turn.
    pub turn: Turn,
    /// When it ended.
    pub ended: Instant,
    /// From the arrival of its last payload to its end, microseconds; the time of the turn itself
    /// where there was no payload.
    pub latency_us: u64,
    /// From handing the payload to the assembler to the end of the turn, microseconds.
    pub turn_us: u64,
    /// Allocations of the worker between the two.
    pub allocations: u64,
}

/// Everything that a run leaves behind.
#[derive(Debug, Default)]
pub struct Log {
    /// Turns, oldest first.
    pub turns: Vec<Logged>,
    /// Turns that found no room.
    pub overflow: u64,
    /// Counters of the estimator.
    pub health: Health,
    /// Counters of the depth stream and of the outline's.
    pub losses: (Losses, Losses),
    /// Frames without a partner.
    pub solitary: Solitary,
    /// Payloads dropped because the worker was late.
    pub payloads_dropped: u64,
    /// Turns whose motion was told by somebody, and turns for which nothing was; none where nobody was asked.
    pub told: Option<(u64, u64)>,
    /// Which liquid it was, where several models were asked.
    pub recognised: Option<Standing>,
}

impl Log {
    /// A log with room for `turns` turns.
    #[must_use]
    pub fn with_room(turns: usize) -> Self {
        Self { turns: Vec::with_capacity(turns), ..Self::default() }
    }

    /// Appends a turn, or counts that there was no room: the log never grows during a run.
    pub(super) fn push(&mut self, logged: Logged) {
        if self.turns.len() < self.turns.capacity() {
            self.turns.push(logged);
        } else {
            self.overflow += 1;
        }
    }
}
