//! `diagnostic_msgs/DiagnosticArray`.

use super::Header;
use serde::{Serialize, Serializer};

/// Level of a status.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// All is well.
    Ok = 0,
    /// Worth a look.
    Warn = 1,
    /// Not usable.
    Error = 2,
    /// Nothing new comes.
    Stale = 3,
}

impl Serialize for Level {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u8(*self as u8)
    }
}

/// `diagnostic_msgs/KeyValue`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct KeyValue {
    /// Name of the figure.
    pub key: String,
    /// The figure.
    pub value: String,
}

/// `diagnostic_msgs/DiagnosticStatus`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DiagnosticStatus {
    /// Level.
    pub level: Level,
    /// Part of the program.
    pub name: String,
    /// State of the part in a sentence.
    pub message: String,
    /// The camera.
    pub hardware_id: String,
    /// Its figures.
    pub values: Vec<KeyValue>,
}

/// `diagnostic_msgs/DiagnosticArray`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DiagnosticArray {
    /// Instant.
    pub header: Header,
    /// Parts.
    pub status: Vec<DiagnosticStatus>,
}
