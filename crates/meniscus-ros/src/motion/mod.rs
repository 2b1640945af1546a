//! Motion of the glass from a topic, into the source of stamped samples ([`MotionInlet`]).
//!
//! | type | sample, in the axes of the frame in brackets |
//! |---|---|
//! | `nav_msgs/Odometry` | position; velocity `R v` of the twist (`header.frame_id`) |
//! | `geometry_msgs/PoseStamped`, `TransformStamped` | position (`header.frame_id`) |
//! | `tf2_msgs/TFMessage` | position of the child in the parent, both named by the user (the parent) |
//! | `sensor_msgs/Imu` | acceleration `R f - g e_z` (that of its orientation, z up) |
//! | `sensor_msgs/JointState` | position `q n` and velocity along the axis `n` of one prismatic joint (that of the axis) |
//!
//! The type is that of the topic's publishers, so nobody has to name it. `sample` reads messages, `transforms` follows `/tf`,
//! `reader` is the thread.

mod kind;
mod links;
mod reader;
mod rotation;
mod sample;
mod stamped;
mod transforms;
mod wait;

pub(crate) use reader::MotionReader;

use meniscus_service::commanded_motion::{MotionInlet, StampClock};

/// Letters of a name from the network in a message at the most.
const NAME_MOST: usize = 64;

/// Returns a name from the network for a person: a terminal obeys control characters.
fn plain(name: &str) -> String {
    name.chars().take(NAME_MOST).flat_map(char::escape_debug).collect()
}

/// Two frames of `/tf`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FramePair {
    /// Frame in which the glass moves.
    pub parent: String,
    /// Frame of the glass.
    pub child: String,
}

/// Topic that states the motion of the glass.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionTopic {
    /// Its name, with the leading slash.
    pub topic: String,
    /// Frames, for `tf2_msgs/TFMessage`.
    pub frames: Option<FramePair>,
    /// Joint, for `sensor_msgs/JointState`.
    pub joint: Option<String>,
    /// Direction in which a positive position moves the joint; any length but zero.
    pub axis: [f64; 3],
    /// Clock of the stamps.
    pub clock: StampClock,
}

/// A motion by a topic: where it comes from, and where it goes to.
#[derive(Debug)]
pub struct RosMotion {
    /// The topic.
    pub topic: MotionTopic,
    /// The source of stamped samples.
    pub inlet: MotionInlet,
}
