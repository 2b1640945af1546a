//! Turn sinks: the one way by which a turn leaves the worker.
//!
//! ```text
//!                        .-> PublishOutlet --queue--> publisher's thread --> Unix sockets, UDP, serial
//! worker --TurnRecord----+-> SnapshotOutlet --hand-off--> thread of the live page, of Foxglove
//!                        +-> ProfileOutlet --queue--> thread that identifies the liquid
//!                        +-> FlightRing --hand-off after a missed deadline--> thread that writes files
//!                        '-> Log, CrestImage, LatestTurn: memory that was there before the first frame
//! ```
//! The worker knows the trait and none of its implementations.

use crate::clock_map::ClockFindings;
use crate::commanded_motion::MotionTurns;
use crate::ledger::FrameCounts;
use crate::timed_turn::TimedTurn;
use meniscus::runtime::Memory;
use meniscus::runtime::health::Health;
use meniscus::usb::uvc::{Losses, Solitary};
use std::sync::{Mutex, PoisonError};

/// One turn as the worker hands it to its sinks, borrowed for the length of the call.
#[derive(Clone, Copy, Debug)]
pub struct TurnRecord<'t> {
    /// The turn and its cost.
    pub logged: &'t TimedTurn,
    /// Full field. It is of this turn only where `logged.turn.estimate.field_fresh` says so; empty in a turn for a frame
    /// that never came while a later one is already there.
    pub field: &'t [f32],
    /// State right after the turn; `None` where a later turn of the same payload has moved it on already.
    pub after: Option<StateAfter<'t>>,
}

/// State of estimator and camera reader right after a turn.
#[derive(Clone, Copy, Debug)]
pub struct StateAfter<'t> {
    /// Memory of the estimator, from which a forecast starts.
    pub memory: &'t Memory,
    /// Last whole image of the outline, Y8, row-major.
    pub outline: &'t [u8],
    /// Last whole depth image, Z16 little-endian, row-major.
    pub depth: &'t [u8],
}

/// Counters of a run at its end.
#[derive(Clone, Copy, Debug, Default)]
pub struct RunCounters {
    /// Counters of the estimator.
    pub health: Health,
    /// Counters of the depth stream and of the outline's.
    pub losses: (Losses, Losses),
    /// Frames without a partner.
    pub solitary: Solitary,
    /// Payloads dropped because the worker was late.
    pub payloads_dropped: u64,
    /// Accounts of the camera's frames.
    pub frames: FrameCounts,
    /// Turns by the origin of their motion; `None` without a commanded motion.
    pub motion: Option<MotionTurns>,
    /// The camera's clock beside this computer's.
    pub clock: ClockFindings,
    /// Allocations of all sinks in the worker's thread. Zero is the contract of [`TurnSink`].
    pub sink_allocations: u64,
}

/// A consumer of turns, called in the worker's thread between two payloads.
///
/// # Contract
/// [`Self::accept`] runs inside the 16.67 ms of a turn. It must not block: no lock that another thread may hold (use
/// `try_lock` or `meniscus_platform::handoff`), no queue that waits for room, no I/O. It must not allocate: room is made
/// when the sink is built. A sink that has no room drops the turn and counts it. The worker counts the allocations of its
/// sinks in [`RunCounters::sink_allocations`], and every run checks that they are zero.
pub trait TurnSink: Send {
    /// Takes a turn.
    fn accept(&mut self, record: &TurnRecord<'_>);

    /// Takes the counters of the run, after its last turn.
    fn finish(&mut self, _counters: &RunCounters) {}
}

/// The newest turn, for a thread that polls it: the dashboard, the service's watchdog.
#[derive(Debug, Default)]
pub struct LatestTurn(Mutex<Option<TimedTurn>>);

impl LatestTurn {
    /// Returns the newest turn; `None` before the first.
    #[must_use]
    pub fn get(&self) -> Option<TimedTurn> {
        // A plain copy under the lock: there is nothing that a panic could leave half done.
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl TurnSink for &LatestTurn {
    fn accept(&mut self, record: &TurnRecord<'_>) {
        // Whoever reads it right now gets the next turn.
        if let Ok(mut latest) = self.0.try_lock() {
            *latest = Some(*record.logged);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timed_turn::tests::timed_turn;
    use meniscus::units::Micros;

    #[test]
    fn the_latest_turn_is_the_last_one_and_a_reader_is_not_waited_for() {
        let latest = LatestTurn::default();
        let (mut sink, first, second) = (&latest, timed_turn(1, 0), timed_turn(2, 0));
        sink.accept(&TurnRecord { logged: &first, field: &[], after: None });
        let reader = latest.0.lock().expect("nobody has panicked");
        // A blocking lock would never come back from here.
        sink.accept(&TurnRecord { logged: &second, field: &[], after: None });
        drop(reader);
        assert_eq!(latest.get().map(|logged| logged.turn.time), Some(Micros(1)));
        sink.accept(&TurnRecord { logged: &second, field: &[], after: None });
        assert_eq!(latest.get().map(|logged| logged.turn.time), Some(Micros(2)));
    }
}
