//! Reasons for which a sizing ends early.

use thiserror::Error;

/// Reason for which the sizes were not found by simulation.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SizingError {
    /// The simulations of this share are done, others are still to be made elsewhere.
    #[error(
        "{missing} simulations of this round belong to other shards: when all shards are done, run the same command again \
         for the next round"
    )]
    Pending {
        /// Simulations that other shards make.
        missing: usize,
    },
    /// The program was interrupted.
    #[error("interrupted; the simulations that are done are kept")]
    Stopped,
    /// The simulator cannot carry the effects or the recordings.
    #[error("{reason}")]
    NotSimulated {
        /// Reason, in words.
        reason: String,
    },
    /// Too few sizes could be simulated.
    #[error("the simulator failed at all sizes but {left}: {reason}")]
    TooFewSizes {
        /// Sizes at which it did not fail.
        left: usize,
        /// Reason of the last failure.
        reason: String,
    },
    /// A simulation could not be kept on disk.
    #[error("{0}")]
    Write(String),
}
