//! The accounts of the ledger, as reports and viewers show them.

use serde_json::{Value, json};
use std::fmt;

/// Frames that the camera took in the run's span, by account.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameCounts {
    /// Frames whose turn ended within a frame interval of their due time.
    pub in_time: u64,
    /// Frames whose turn ended later, or was taken before they came.
    pub late: u64,
    /// Frames that never came as a pair of whole images.
    pub lost: u64,
    /// Frames that were due while the host stood still, or dropped because no buffer was spare.
    pub never_handled: u64,
    /// Length of the span, s.
    pub over_s: f64,
}

impl FrameCounts {
    /// Returns the frames that the camera took.
    #[must_use]
    pub fn taken(&self) -> u64 {
        self.in_time + self.late + self.lost + self.never_handled
    }

    /// Returns the missed deadlines: frames that had no turn in time, for whatever reason.
    #[must_use]
    pub fn missed(&self) -> u64 {
        self.late + self.lost + self.never_handled
    }

    /// Returns the accounts as a JSON object.
    #[must_use]
    pub fn json(&self) -> Value {
        json!({ "over_s": self.over_s, "taken": self.taken(), "in_time": self.in_time, "late": self.late,
                "lost": self.lost, "never_handled": self.never_handled })
    }
}

impl fmt::Display for FrameCounts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "over {:.1} s the camera took {} frames: {} in time, {} late, {} lost, {} never handled",
            self.over_s,
            self.taken(),
            self.in_time,
            self.late,
            self.lost,
            self.never_handled
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_has_the_same_figures() {
        let counts = FrameCounts { in_time: 2800, late: 40, lost: 7, never_handled: 33, over_s: 48.0 };
        assert_eq!((counts.taken(), counts.missed()), (2880, 80));
        let line = "over 48.0 s the camera took 2880 frames: 2800 in time, 40 late, 7 lost, 33 never handled";
        assert_eq!(counts.to_string(), line);
        let json = counts.json();
        let sum = ["in_time", "late", "lost", "never_handled"].map(|name| json[name].as_u64().unwrap_or(0));
        assert_eq!(json["taken"], sum.iter().sum::<u64>());
        assert_eq!(json["over_s"], 48.0);
    }
}
