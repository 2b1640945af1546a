//! Messages that state the motion of a body: `nav_msgs/Odometry`, `geometry_msgs/PoseStamped`, `sensor_msgs/Imu` and
//! `sensor_msgs/JointState`.

use super::{Header, Point, Quaternion, Vector3};
use serde::Deserialize;

/// The 36 numbers of a covariance, in two parts because serde reads arrays of at most 32.
pub type Covariance = ([f64; 32], [f64; 4]);

/// `geometry_msgs/Pose`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct Pose {
    /// Origin of the body.
    pub position: Point,
    /// Its axes.
    pub orientation: Quaternion,
}

/// `geometry_msgs/PoseWithCovariance`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct PoseWithCovariance {
    /// The pose.
    pub pose: Pose,
    /// Its covariance.
    pub covariance: Covariance,
}

/// `geometry_msgs/Twist`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct Twist {
    /// Velocity, m/s.
    pub linear: Vector3,
    /// Angular velocity, rad/s.
    pub angular: Vector3,
}

/// `geometry_msgs/TwistWithCovariance`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct TwistWithCovariance {
    /// The twist.
    pub twist: Twist,
    /// Its covariance.
    pub covariance: Covariance,
}

/// `nav_msgs/Odometry`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Odometry {
    /// Instant, and frame of the pose.
    pub header: Header,
    /// Frame of the twist: that of the body.
    pub child_frame_id: String,
    /// Pose of the body.
    pub pose: PoseWithCovariance,
    /// Its twist.
    pub twist: TwistWithCovariance,
}

/// `geometry_msgs/PoseStamped`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct PoseStamped {
    /// Instant, and frame of the pose.
    pub header: Header,
    /// Pose of the body.
    pub pose: Pose,
}

/// `sensor_msgs/Imu`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Imu {
    /// Instant, and frame of the sensor.
    pub header: Header,
    /// Axes of the sensor in a frame whose z is up.
    pub orientation: Quaternion,
    /// Its covariance; the first number is -1 where there is no orientation.
    pub orientation_covariance: [f64; 9],
    /// Angular velocity, rad/s.
    pub angular_velocity: Vector3,
    /// Its covariance.
    pub angular_velocity_covariance: [f64; 9],
    /// Specific force in the axes of the sensor, m/s2: at rest 9.81 upwards.
    pub linear_acceleration: Vector3,
    /// Its covariance; the first number is -1 where there is none.
    pub linear_acceleration_covariance: [f64; 9],
}

/// `sensor_msgs/JointState`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct JointState {
    /// Instant.
    pub header: Header,
    /// Names of the joints.
    pub name: Vec<String>,
    /// Their positions, m or rad; empty or as many.
    pub position: Vec<f64>,
    /// Their velocities; empty or as many.
    pub velocity: Vec<f64>,
    /// Their forces or torques; empty or as many.
    pub effort: Vec<f64>,
}
