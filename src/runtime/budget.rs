//! The deadline of a turn and where its time goes. The clock is an argument.

use serde::{Deserialize, Serialize};

/// A turn has to end before the next frame: 1/60 s, in microseconds.
pub const DEADLINE_US: u64 = 16_667;

/// Latest start of the full field, from the start of the turn: three quarters of the deadline. When
/// it is missed the full field is left out and counted; the surface and the audit never are.
pub(super) fn field_start_us(deadline_us: u64) -> u64 {
    deadline_us - deadline_us / 4
}

/// Where a turn's time comes from: a real clock on the board, a counter in a test.
pub trait Clock {
    /// Microseconds since some fixed start, never falling.
    fn now_us(&mut self) -> u64;
}

/// Time of each stage of a turn, microseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stages {
    /// Image to profile.
    pub surface_us: u64,
    /// The GENERIC step.
    pub predict_us: u64,
    /// Window to latent.
    pub encode_us: u64,
    /// Filter, coefficients, surface.
    pub correct_us: u64,
    /// Full field.
    pub field_us: u64,
}

impl Stages {
    /// The whole turn.
    #[must_use]
    pub fn total_us(&self) -> u64 {
        [self.surface_us, self.predict_us, self.encode_us, self.correct_us, self.field_us]
            .iter()
            .fold(0, |sum, &stage| stage.saturating_add(sum))
    }
}

/// A clock and the time of its last reading.
pub(super) struct Lap<'c, C> {
    clock: &'c mut C,
    start_us: u64,
    last_us: u64,
}

impl<'c, C: Clock> Lap<'c, C> {
    /// Starts now.
    pub(super) fn start(clock: &'c mut C) -> Self {
        let now = clock.now_us();
        Self { clock, start_us: now, last_us: now }
    }

    /// Time since the last reading.
    pub(super) fn lap_us(&mut self) -> u64 {
        let now = self.clock.now_us();
        let lap = now.saturating_sub(self.last_us);
        self.last_us = now;
        lap
    }

    /// Time since the start, at the last reading.
    pub(super) fn elapsed_us(&self) -> u64 {
        self.last_us.saturating_sub(self.start_us)
    }
}
