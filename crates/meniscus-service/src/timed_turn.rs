//! A turn with its cost and its time on the host's clock.

use crate::ledger::FrameCounts;
use meniscus::runtime::Turn;
use meniscus::runtime::output::HostTime;
use std::time::Instant;

/// One turn, when it was taken and what it cost.
#[derive(Clone, Copy, Debug)]
pub struct TimedTurn {
    /// The turn.
    pub turn: Turn,
    /// Mid-exposure of the turn on the host's clock, with the latency to the end of the turn; `None` before the first frame
    /// and where no clock was mapped.
    pub host: Option<HostTime>,
    /// When it ended.
    pub ended: Instant,
    /// From the arrival of its last payload to its end, microseconds; the time of the turn itself
    /// where there was no payload.
    pub latency_us: u64,
    /// From handing the payload to the assembler to the end of the turn, microseconds.
    pub turn_us: u64,
    /// Allocations of the worker between the two.
    pub allocations: u64,
    /// Accounts of the camera's frames after the turn.
    pub frames: FrameCounts,
}

impl TimedTurn {
    /// Returns `turn` as it ends now, without cost, allocations and host time: a turn outside a live run.
    #[must_use]
    pub fn untimed(turn: Turn) -> Self {
        let (ended, frames) = (Instant::now(), FrameCounts::default());
        Self { turn, host: None, ended, latency_us: 0, turn_us: 0, allocations: 0, frames }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use meniscus::blob::Model;
    use meniscus::runtime::{Estimator, Memory, TurnInput};
    use meniscus::units::Micros;
    use meniscus_platform::clock::Monotonic;
    use meniscus_platform::files::AlignedBytes;

    /// A turn without a frame at `time`, with this latency.
    pub(crate) fn timed_turn(time: u64, latency_us: u64) -> TimedTurn {
        let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
        let model = Model::load(&bytes).expect("the shipped model");
        let mut memory = Memory::default();
        let estimate =
            Estimator::new(&model).turn(&mut memory, TurnInput::default(), &mut Monotonic::start(), &mut []);
        let turn = Turn { time: Micros(time), stamp: None, profile: None, estimate };
        TimedTurn { latency_us, turn_us: latency_us, ..TimedTurn::untimed(turn) }
    }
}
