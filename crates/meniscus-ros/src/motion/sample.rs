//! Messages to stamped samples.
//!
//! ```text
//! v = R v_b                 Odometry: the twist is in the axes of the body, R those of the body in the frame of the pose
//! a = R f - g e_z           Imu: f specific force in the axes of the sensor, R its orientation, e_z up
//! a = f                     Imu without an orientation: its axes do not turn, and the line is level in them
//! x = q n, v = q' n         JointState: n axis of length one
//! ```
//! A velocity that has always been zero counts as not stated: many publishers leave the field at its default.

use super::MotionTopic;
use super::rotation::{point, rotation, vector};
use super::stamped::{Give, Sample};
use super::transforms::Transforms;
use crate::message::{Imu, JointState, Odometry, PoseStamped, TransformMessage, TransformStamped};
use meniscus_service::commanded_motion::{SampleFault, SenderId};
use nalgebra::Vector3;
use serde::de::DeserializeOwned;
use std::collections::BTreeSet;

/// Standard gravity, m/s2.
const GRAVITY: f64 = 9.806_65;

/// Most names that are kept for a message to a person.
const NAMES_MOST: usize = 64;

/// First number of a covariance whose quantity the publisher does not know.
const UNKNOWN: f64 = -1.0;

/// State of the reading of a topic.
#[derive(Debug)]
pub(super) struct Reading<'t> {
    pub(super) topic: &'t MotionTopic,
    pub(super) transforms: Transforms,
    /// Joints that were seen.
    pub(super) joints: BTreeSet<String>,
    /// Sentence for a person.
    pub(super) notice: Option<String>,
    /// Whether a velocity other than zero was stated.
    has_moved: bool,
    /// Whether the missing orientation was reported.
    is_level: bool,
}

/// A message with samples of the motion of the glass.
pub(super) trait MotionMessage: DeserializeOwned + 'static {
    /// Package and name of its type.
    const TYPE: (&'static str, &'static str);
    /// Whether every message has a sample, so that a missing number is a lost one.
    const IS_WHOLE: bool = true;

    /// Gives the samples of a message of `from`, or its faults.
    fn read(self, from: SenderId, reading: &mut Reading<'_>, give: Give<'_>);
}

impl<'t> Reading<'t> {
    pub(super) fn of(topic: &'t MotionTopic) -> Self {
        let transforms = Transforms::of(topic.frames.as_ref(), topic.clock);
        let (has_moved, is_level) = (false, false);
        Self { topic, transforms, joints: BTreeSet::new(), notice: None, has_moved, is_level }
    }

    fn velocity(&mut self, velocity_m_s: [f64; 3]) -> Option<[f64; 3]> {
        self.has_moved |= velocity_m_s != [0.0; 3];
        self.has_moved.then_some(velocity_m_s)
    }

    fn odometry(&mut self, message: &Odometry) -> Result<Sample, SampleFault> {
        let pose = message.pose.pose;
        let axes = rotation(pose.orientation)?;
        let velocity_m_s = self.velocity((axes * Vector3::from(vector(message.twist.twist.linear))).into());
        Ok(Sample { velocity_m_s, ..Sample::at(&message.header, point(pose.position))? })
    }

    fn imu(&mut self, message: &Imu) -> Result<Sample, SampleFault> {
        let without = |covariance: &[f64; 9]| covariance[0] == UNKNOWN;
        if without(&message.linear_acceleration_covariance) {
            return Err(SampleFault::Malformed(
                "linear_acceleration_covariance[0] is -1: the sensor has no accelerometer".into(),
            ));
        }
        let force = vector(message.linear_acceleration);
        let acceleration = if without(&message.orientation_covariance) {
            if !std::mem::replace(&mut self.is_level, true) {
                self.notice = Some(format!(
                    "{} states no orientation: its axes are taken as fixed, and --motion-line as level. Each degree of slope \
                     adds 0.17 m/s2",
                    self.topic.topic
                ));
            }
            force
        } else {
            let [x, y, z] = (rotation(message.orientation)? * Vector3::from(force)).into();
            [x, y, z - GRAVITY]
        };
        Ok(Sample { acceleration_m_s2: Some(acceleration), ..Sample::at(&message.header, [0.0; 3])? })
    }

    /// Returns `None` where the message has another joint alone.
    fn joint(&mut self, message: &JointState) -> Option<Result<Sample, SampleFault>> {
        let place = message.name.iter().position(|name| Some(name) == self.topic.joint.as_ref());
        let Some(place) = place else {
            let room = NAMES_MOST.saturating_sub(self.joints.len());
            self.joints.extend(message.name.iter().take(room).cloned());
            return None;
        };
        let Some(position_m) = message.position.get(place) else {
            let why = format!("it has no position of joint {}", message.name[place]);
            return Some(Err(SampleFault::Malformed(why)));
        };
        let axis = self.topic.axis;
        let length = axis.iter().map(|n| n * n).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        let along = |value: f64| axis.map(|n| n / length * value);
        // Controllers state what they do not know as no number.
        let velocity = message.velocity.get(place).filter(|velocity| velocity.is_finite());
        let velocity_m_s = velocity.and_then(|velocity| self.velocity(along(*velocity)));
        let sample = Sample::at(&message.header, along(*position_m));
        Some(sample.map(|sample| Sample { velocity_m_s, ..sample }))
    }
}

impl MotionMessage for Odometry {
    const TYPE: (&'static str, &'static str) = ("nav_msgs", "Odometry");

    fn read(self, _: SenderId, reading: &mut Reading<'_>, give: Give<'_>) {
        give(reading.odometry(&self));
    }
}

impl MotionMessage for PoseStamped {
    const TYPE: (&'static str, &'static str) = ("geometry_msgs", "PoseStamped");

    fn read(self, _: SenderId, _: &mut Reading<'_>, give: Give<'_>) {
        let sound = rotation(self.pose.orientation);
        give(sound.and_then(|_| Sample::at(&self.header, point(self.pose.position))));
    }
}

impl MotionMessage for TransformStamped {
    const TYPE: (&'static str, &'static str) = ("geometry_msgs", "TransformStamped");

    fn read(self, _: SenderId, _: &mut Reading<'_>, give: Give<'_>) {
        let sound = rotation(self.rotation);
        give(sound.and_then(|_| Sample::at(&self.header, vector(self.translation))));
    }
}

impl MotionMessage for Imu {
    const TYPE: (&'static str, &'static str) = ("sensor_msgs", "Imu");

    fn read(self, _: SenderId, reading: &mut Reading<'_>, give: Give<'_>) {
        give(reading.imu(&self));
    }
}

impl MotionMessage for JointState {
    const TYPE: (&'static str, &'static str) = ("sensor_msgs", "JointState");
    const IS_WHOLE: bool = false;

    fn read(self, _: SenderId, reading: &mut Reading<'_>, give: Give<'_>) {
        if let Some(sample) = reading.joint(&self) {
            give(sample);
        }
    }
}

impl MotionMessage for TransformMessage {
    const TYPE: (&'static str, &'static str) = ("tf2_msgs", "TFMessage");
    const IS_WHOLE: bool = false;

    fn read(self, from: SenderId, reading: &mut Reading<'_>, give: Give<'_>) {
        reading.transforms.take(&self, from, give);
    }
}

#[cfg(test)]
mod tests;
