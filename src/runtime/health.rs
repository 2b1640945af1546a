//! One Copy record of counters: everything that was missed, lost or refused, by cause.

use serde::{Deserialize, Serialize};

/// Counters of the estimator since the start; each names the bound that was missed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Health {
    /// Turns taken, one a frame interval, seen or not.
    pub turns: u64,
    /// Turns in which a measurement was used.
    pub tracking: u64,
    /// Turns that only predicted.
    pub coasting: u64,
    /// Turns without a valid estimate because too many frames had been missing.
    pub halted: u64,
    /// Turns spent filling the window.
    pub filling: u64,
    /// Frames that never came.
    pub frames_missing: u64,
    /// Frames that came after their turn had been taken.
    pub frames_stale: u64,
    /// Of these, frames that the next turn started from; the others were not used.
    pub frames_caught_up: u64,
    /// Frames in which the liquid was not seen.
    pub not_seen: u64,
    /// Frames whose glass edges were not found, so that the acceleration was carried over.
    pub glass_not_seen: u64,
    /// Glass accelerations beyond what the model was built for, clipped.
    pub acceleration_clipped: u64,
    /// Measurements refused because heights or the encoder gave something that is not a number.
    pub measurement_refused: u64,
    /// Implicit steps whose iterations ran out.
    pub step_unconverged: u64,
    /// Implicit steps that were shortened to keep the law.
    pub step_backtracked: u64,
    /// Steps that gave nothing finite; the state stayed.
    pub step_held: u64,
    /// Turns whose full field was left out to keep the deadline.
    pub field_shed: u64,
    /// Turns that ended after their deadline.
    pub deadline_missed: u64,
}

/// Adds one to a counter; a counter that is full stays full.
pub(super) fn count(counter: &mut u64) {
    *counter = counter.saturating_add(1);
}
