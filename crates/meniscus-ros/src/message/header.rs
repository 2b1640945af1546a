//! `std_msgs/Header` and what every message is made of.

use serde::{Deserialize, Serialize, Serializer};

/// Frame of the glass.
pub(crate) const GLASS: &str = "glass";

/// Nanoseconds of a second.
const SECOND_NS: u64 = 1_000_000_000;

/// `builtin_interfaces/Time`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stamp {
    /// Seconds since 1970 UTC.
    pub sec: i32,
    /// Nanoseconds behind them.
    pub nanosec: u32,
}

impl Stamp {
    /// Returns the stamp of an instant in nanoseconds since 1970 UTC; the last one that there is, from 2038 on.
    #[must_use]
    pub fn of_unix_ns(unix_ns: u64) -> Self {
        let sec = i32::try_from(unix_ns / SECOND_NS).unwrap_or(i32::MAX);
        // Below a second, and so below 2^32.
        Self { sec, nanosec: (unix_ns % SECOND_NS) as u32 }
    }

    /// Returns the instant in nanoseconds since 1970 UTC; `None` before, or where the nanoseconds are a second or more.
    #[must_use]
    pub fn unix_ns(self) -> Option<u64> {
        let sec = u64::try_from(self.sec).ok()?;
        (u64::from(self.nanosec) < SECOND_NS).then_some(sec * SECOND_NS + u64::from(self.nanosec))
    }
}

/// `std_msgs/Header`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// Instant of the data.
    pub stamp: Stamp,
    /// Frame of the data.
    pub frame_id: String,
}

/// A sequence of octets, which is written as a whole.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Octets(pub Vec<u8>);

impl Serialize for Octets {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_come_back() {
        for unix_ns in [0, 1_790_000_000_999_999_999] {
            assert_eq!(Stamp::of_unix_ns(unix_ns).unix_ns(), Some(unix_ns));
        }
        assert_eq!(Stamp { sec: -1, nanosec: 0 }.unix_ns(), None);
        assert_eq!(Stamp { sec: 1, nanosec: 1_000_000_000 }.unix_ns(), None);
    }
}
