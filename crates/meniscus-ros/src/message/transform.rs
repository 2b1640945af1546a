//! `tf2_msgs/TFMessage`.

use super::Header;
use serde::{Deserialize, Serialize};

/// `geometry_msgs/Vector3`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Vector3 {
    /// x, m.
    pub x: f64,
    /// y, m.
    pub y: f64,
    /// z, m.
    pub z: f64,
}

/// `geometry_msgs/Quaternion`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    /// Part of x.
    pub x: f64,
    /// Part of y.
    pub y: f64,
    /// Part of z.
    pub z: f64,
    /// Real part.
    pub w: f64,
}

/// `geometry_msgs/TransformStamped`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransformStamped {
    /// Instant and parent frame.
    pub header: Header,
    /// Frame whose place it is.
    pub child_frame_id: String,
    /// Its origin in the parent frame.
    pub translation: Vector3,
    /// Its axes in the parent frame.
    pub rotation: Quaternion,
}

/// `tf2_msgs/TFMessage`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransformMessage {
    /// Places of frames.
    pub transforms: Vec<TransformStamped>,
}
