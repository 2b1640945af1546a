//! Reasons for which a sizing ends early.

use crate::insert::simulator::SimulatorFault;
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
    /// The simulator itself is of no use.
    #[error("{reason}; no verdict is written, and the simulations that were made are kept")]
    Broken {
        /// Reason, in words.
        reason: String,
    },
    /// The simulator cannot carry the effects or the recordings.
    #[error("{reason}")]
    NotSimulated {
        /// Reason, in words.
        reason: String,
    },
    /// The effects are of camera, clock, drive or fill.
    #[error(
        "{names} acts outside the liquid: the reduced model sizes it, and simulated particles would add their scatter"
    )]
    OutsideTheLiquid {
        /// Effects, in words.
        names: String,
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

impl From<SimulatorFault> for SizingError {
    fn from(fault: SimulatorFault) -> Self {
        match fault {
            SimulatorFault::Here(reason) => Self::NotSimulated { reason },
            SimulatorFault::Broken(reason) => Self::Broken { reason },
            SimulatorFault::Stopped => Self::Stopped,
        }
    }
}

impl SizingError {
    /// Returns whether the whole discovery ends with it: a verdict now would look finished.
    #[must_use]
    pub fn ends_all(&self) -> bool {
        matches!(self, Self::Pending { .. } | Self::Stopped | Self::Write(_) | Self::Broken { .. })
    }
}
