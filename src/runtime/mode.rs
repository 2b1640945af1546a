//! Mode of the estimator: filling, tracking, coasting or halted.

use serde::{Deserialize, Serialize};

/// Frames (1 s) that may be missing in a row before the estimate is no longer given.
pub const COAST_LIMIT: u32 = 60;

/// Mode of a turn. An estimate is fresh only while tracking.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mode {
    /// The window is not full yet: the estimate is a liquid at rest, moved by the port.
    #[default]
    Filling,
    /// This turn used a measurement.
    Tracking,
    /// No usable frame this turn: the GENERIC step alone.
    Coasting,
    /// Too many frames missing: no full field until the window has filled again.
    Halted,
}

impl Mode {
    /// The mode after a turn with or without a measurement; `missed` is the number of turns in a row
    /// without one, this turn included.
    pub(super) fn next(self, measured: bool, missed: u32) -> Self {
        match self {
            _ if measured => Self::Tracking,
            Self::Filling => Self::Filling,
            Self::Halted => Self::Halted,
            Self::Tracking | Self::Coasting if missed > COAST_LIMIT => Self::Halted,
            Self::Tracking | Self::Coasting => Self::Coasting,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Mode::{Coasting, Filling, Halted, Tracking};
    use super::*;

    #[test]
    fn every_transition() {
        let table = [
            ((Filling, true, 0), Tracking),
            ((Filling, false, 5), Filling),
            ((Filling, false, COAST_LIMIT + 1), Filling),
            ((Tracking, true, 0), Tracking),
            ((Tracking, false, 1), Coasting),
            ((Coasting, true, 0), Tracking),
            ((Coasting, false, COAST_LIMIT), Coasting),
            ((Coasting, false, COAST_LIMIT + 1), Halted),
            ((Halted, false, 99), Halted),
            ((Halted, true, 0), Tracking),
        ];
        for ((mode, measured, missed), expected) in table {
            assert_eq!(mode.next(measured, missed), expected, "{mode:?} {measured} {missed}");
        }
    }
}
