//! Types that can be read, and the reasons for which nothing comes.

use super::sample::{MotionMessage, Reading};
use super::{FramePair, plain};
use crate::message::{Imu, JointState, Odometry, PoseStamped, TransformMessage, TransformStamped};

/// Names in one message at the most.
const NAMED: usize = 12;

/// Type of a topic that states a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Odometry,
    Pose,
    Transform,
    Transforms,
    Imu,
    Joints,
}

impl Kind {
    /// All of them.
    const ALL: [Self; 6] =
        [Self::Odometry, Self::Pose, Self::Transform, Self::Transforms, Self::Imu, Self::Joints];

    /// Returns package and name of the type.
    fn name(self) -> (&'static str, &'static str) {
        match self {
            Self::Odometry => Odometry::TYPE,
            Self::Pose => PoseStamped::TYPE,
            Self::Transform => TransformStamped::TYPE,
            Self::Transforms => TransformMessage::TYPE,
            Self::Imu => Imu::TYPE,
            Self::Joints => JointState::TYPE,
        }
    }

    /// Returns the type with this name in DDS; `None` where it cannot be read.
    pub(super) fn of_dds(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| {
            let (package, own) = kind.name();
            name.strip_prefix(package).and_then(|rest| rest.strip_prefix("::msg::dds_::"))
                == Some(&format!("{own}_"))
        })
    }
}

/// Returns the name of a type in DDS as ROS writes it.
fn as_in_ros(name: &str) -> String {
    name.trim_end_matches('_').replace("::dds_::", "/").replace("::", "/")
}

/// Returns names for a person.
fn listed<S: AsRef<str>>(names: impl IntoIterator<Item = S>) -> String {
    let names: Vec<String> = names.into_iter().map(|name| plain(name.as_ref())).collect();
    match names.len().checked_sub(NAMED) {
        None | Some(0) => names.join(", "),
        Some(more) => format!("{} and {more} others", names[..NAMED].join(", ")),
    }
}

/// Returns the reason for which no sample comes, where the publishers of the topic have the types `seen`; `subscribed` is the one that
/// is read.
pub(super) fn absence(reading: &Reading<'_>, seen: &[String], subscribed: Option<Kind>) -> String {
    let topic = &reading.topic.topic;
    match subscribed {
        _ if seen.is_empty() => format!(
            "no message on {topic}: it has no publisher. `ros2 topic list` shows the topics, and the domain has to be the same"
        ),
        None => {
            let known = Kind::ALL.map(|kind| format!("{}/msg/{}", kind.name().0, kind.name().1));
            format!(
                "no message on {topic} that can be read; types that were seen: {}. Types that can be read: {}",
                listed(seen.iter().map(|name| as_in_ros(name))),
                known.join(", ")
            )
        }
        Some(Kind::Transforms) => without_transform(reading),
        Some(Kind::Joints) => without_joint(reading),
        Some(_) => format!("no message on {topic}: its publisher is silent"),
    }
}

fn without_transform(reading: &Reading<'_>) -> String {
    let topic = &reading.topic.topic;
    let Some(FramePair { parent, child }) = &reading.topic.frames else {
        return format!("{topic} has transforms: name the frames with --motion-frames PARENT,CHILD");
    };
    if reading.transforms.is_joined() {
        return format!(
            "no new transform from {parent} to {child} on {topic}: a link between them is not published any more, or never moves"
        );
    }
    let frames = listed(reading.transforms.frames());
    let frames = if frames.is_empty() { "none" } else { &frames };
    format!("no transform from {parent} to {child} on {topic}; frames that were seen: {frames}")
}

fn without_joint(reading: &Reading<'_>) -> String {
    let topic = &reading.topic.topic;
    match &reading.topic.joint {
        None => format!("{topic} has joints: name the one that moves the glass with --motion-joint NAME"),
        Some(joint) if !reading.joints.is_empty() => {
            format!("no joint {joint} on {topic}; joints that were seen: {}", listed(&reading.joints))
        }
        Some(_) => format!("no message on {topic}: its publisher is silent"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_are_known_by_their_name_in_dds() {
        assert_eq!(Kind::of_dds("nav_msgs::msg::dds_::Odometry_"), Some(Kind::Odometry));
        assert_eq!(Kind::of_dds("tf2_msgs::msg::dds_::TFMessage_"), Some(Kind::Transforms));
        for other in ["std_msgs::msg::dds_::String_", "nav_msgs::msg::dds_::OdometryX_", "Odometry", ""] {
            assert_eq!(Kind::of_dds(other), None, "{other}");
        }
        assert_eq!(as_in_ros("std_msgs::msg::dds_::String_"), "std_msgs/msg/String");
        let many: Vec<String> = (0..14).map(|number| number.to_string()).collect();
        assert!(listed(&many).ends_with("11 and 2 others"));
        assert_eq!(listed(["\u{1b}[2J", &"x".repeat(99)]), format!("\\u{{1b}}[2J, {}", "x".repeat(64)));
    }
}
