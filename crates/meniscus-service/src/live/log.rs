//! The log of a run: totals over all turns, and the first turns with their cost, in memory that was there before the first
//! frame.

use super::totals::RunTotals;
use crate::clock_map::ClockFindings;
use crate::commanded_motion::MotionTurns;
use crate::identify::Standing;
use crate::ledger::FrameCounts;
use crate::sink::{RunCounters, TurnRecord, TurnSink};
use crate::timed_turn::TimedTurn;
use meniscus::runtime::health::Health;
use meniscus::usb::uvc::{Losses, Solitary};

/// Turns and counters of a run.
#[derive(Debug, Default)]
pub struct Log {
    /// Figures over all turns.
    pub totals: RunTotals,
    /// Accounts of the camera's frames.
    pub frames: FrameCounts,
    /// First turns of the run, as many as there is room for, oldest first: for tables and the comparison with a truth.
    pub turns: Vec<TimedTurn>,
    /// Later turns, which are in the totals only.
    pub overflow: u64,
    /// Counters of the estimator.
    pub health: Health,
    /// Counters of the depth stream and of the outline's.
    pub losses: (Losses, Losses),
    /// Frames without a partner.
    pub solitary: Solitary,
    /// Payloads dropped because the worker was late.
    pub payloads_dropped: u64,
    /// Turns by the origin of their motion; `None` without a commanded motion.
    pub motion: Option<MotionTurns>,
    /// The camera's clock beside this computer's.
    pub clock: ClockFindings,
    /// Allocations of the sinks in the worker's thread.
    pub sink_allocations: u64,
    /// Identified liquid, where several models were compared.
    pub recognised: Option<Standing>,
}

impl Log {
    /// Returns a log with room for `turns` turns.
    #[must_use]
    pub fn with_room(turns: usize) -> Self {
        Self { turns: Vec::with_capacity(turns), ..Self::default() }
    }

    /// Returns a log with room for a turn a frame, for those that faults and silence add, and for a second more; of no frame,
    /// one that keeps the totals alone.
    #[must_use]
    pub fn for_frames(frames: usize) -> Self {
        Self::with_room(if frames == 0 { 0 } else { frames + frames / 2 + 64 })
    }

    /// Returns the allocations of the worker's thread during turns and in the sinks.
    #[must_use]
    pub fn allocations(&self) -> u64 {
        self.totals.allocations + self.sink_allocations
    }
}

impl TurnSink for Log {
    /// Adds a turn to the totals and keeps it, or counts that there was no room: the log never grows during a run.
    fn accept(&mut self, record: &TurnRecord<'_>) {
        self.totals.add(record.logged);
        if self.turns.len() < self.turns.capacity() {
            self.turns.push(*record.logged);
        } else {
            self.overflow += 1;
        }
    }

    fn finish(&mut self, counters: &RunCounters) {
        self.health = counters.health;
        self.losses = counters.losses;
        self.solitary = counters.solitary;
        self.payloads_dropped = counters.payloads_dropped;
        self.frames = counters.frames;
        self.motion = counters.motion;
        self.clock = counters.clock;
        self.sink_allocations = counters.sink_allocations;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timed_turn::tests::timed_turn;

    #[test]
    fn a_full_log_counts_and_does_not_grow() {
        let mut log = Log::with_room(2);
        let room = log.turns.capacity();
        let turn = timed_turn(1, 0);
        for _ in 0..room + 3 {
            log.accept(&TurnRecord { logged: &turn, field: &[], after: None });
        }
        assert_eq!((log.turns.len(), log.turns.capacity(), log.overflow), (room, room, 3));
        assert_eq!(log.totals.turns, room as u64 + 3, "the totals have every turn");
        assert_eq!(Log::for_frames(0).turns.capacity(), 0);
    }
}
