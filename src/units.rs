//! The units that cross module walls, as types; inside a function a suffix (`_m`, `_us`) does.

use serde::{Deserialize, Serialize};

/// A device time in microseconds, unwrapped from the camera's 32-bit clock; never a host clock.
///
/// ```
/// use meniscus::units::Micros;
///
/// let (first, second) = (Micros(1_000), Micros(17_667));
/// assert_eq!(second.since(first), 16_667);
/// assert_eq!(first.since(second), 0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Micros(pub u64);

impl Micros {
    /// Time from `earlier` to `self`, zero if `earlier` is later.
    #[must_use]
    pub fn since(self, earlier: Self) -> u64 {
        self.0.saturating_sub(earlier.0)
    }
}

/// The camera's frame interval at 60 Hz, in seconds. The paper writes 0.015 s; 60 Hz is 1/60 s.
pub const FRAME_INTERVAL_S: f64 = 1.0 / 60.0;

/// Standard gravity in m/s2 (CODATA, exact by definition).
pub const GRAVITY_M_S2: f64 = 9.806_65;
