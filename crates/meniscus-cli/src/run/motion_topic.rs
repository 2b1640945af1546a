//! `--motion ros2:TOPIC`: the motion of the glass from a topic of ROS 2.

use anyhow::{Context, bail, ensure};
use meniscus_service::commanded_motion::StampClock;

/// Topic of transforms.
const TRANSFORMS: &str = "/tf";

/// Flags of a motion from a topic.
#[derive(clap::Args)]
pub(super) struct TopicArguments {
    /// With transforms: frame in which the glass moves, and its own frame.
    ///
    /// Names as in /tf, which may have other frames between them. --motion-line is in the axes of the parent.
    #[arg(long, value_name = "PARENT,CHILD", help_heading = "Motion of the glass")]
    motion_frames: Option<String>,
    /// With joint states: the prismatic joint that moves the glass.
    #[arg(long, value_name = "NAME", help_heading = "Motion of the glass")]
    motion_joint: Option<String>,
    /// With joint states: direction in which the joint's position rises, in the axes of --motion-line [default: 1,0,0].
    #[arg(long, value_name = "X,Y,Z", help_heading = "Motion of the glass")]
    motion_axis: Option<String>,
    /// With ros2: clock of the stamps [default: host].
    ///
    /// host is this computer's wall clock, which others have to be set to. sender is any clock that runs at the same rate, as that of
    /// use_sim_time at real-time factor 1: it is mapped by arrivals.
    #[arg(long, value_name = "host|sender", help_heading = "Motion of the glass")]
    motion_clock: Option<String>,
}

/// A motion from a topic.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(not(feature = "ros2"), allow(dead_code, reason = "a program without ROS 2 refuses it"))]
pub(super) struct TopicMotion {
    /// The topic, with its leading slash.
    pub(super) topic: String,
    /// Frames of transforms.
    pub(super) frames: Option<Frames>,
    /// Joint of joint states.
    pub(super) joint: Option<String>,
    /// Direction in which its position rises.
    pub(super) axis: [f64; 3],
    /// Clock of the stamps.
    pub(super) clock: StampClock,
    /// Latency of frames, s.
    pub(super) lag_s: f64,
    /// Direction of the line of the model, of length one.
    pub(super) line: [f64; 3],
}

/// Frames of transforms.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(not(feature = "ros2"), allow(dead_code, reason = "a program without ROS 2 refuses it"))]
pub(super) struct Frames {
    /// Frame in which the glass moves.
    pub(super) parent: String,
    /// Frame of the glass.
    pub(super) child: String,
}

impl TopicArguments {
    /// Whether one of the flags is given.
    pub(super) fn any(&self) -> bool {
        let Self { motion_frames, motion_joint, motion_axis, motion_clock } = self;
        motion_frames.is_some() || motion_joint.is_some() || motion_axis.is_some() || motion_clock.is_some()
    }

    /// Returns the motion from `topic` along `line`.
    pub(super) fn motion(&self, topic: &str, line: [f64; 3], lag_s: f64) -> anyhow::Result<TopicMotion> {
        let plain = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
        let parts = topic.strip_prefix('/').unwrap_or(topic).split('/');
        let is_name = parts.clone().all(|part| {
            part.chars().all(plain) && part.chars().next().is_some_and(|first| !first.is_ascii_digit())
        });
        ensure!(
            is_name,
            "--motion ros2:{topic}: {topic:?} is no name of a topic; expected ros2:TOPIC, as ros2:/odom. `ros2 topic list` shows them"
        );
        let topic = format!("/{}", topic.trim_start_matches('/'));
        let frames = self.motion_frames.as_deref().map(frames).transpose()?;
        ensure!(
            frames.is_some() || topic != TRANSFORMS,
            "--motion ros2:{topic} has many transforms: name the one of the glass with --motion-frames PARENT,CHILD"
        );
        let clock = match self.motion_clock.as_deref() {
            None | Some("host") => StampClock::Host,
            Some("sender") => StampClock::Sender,
            Some(other) => bail!("--motion-clock {other}: expected host or sender"),
        };
        let axis = match &self.motion_axis {
            Some(text) => direction("--motion-axis", text)?,
            None => [1.0, 0.0, 0.0],
        };
        Ok(TopicMotion { topic, frames, joint: self.motion_joint.clone(), axis, clock, lag_s, line })
    }
}

/// Returns the frames that --motion-frames spells.
fn frames(text: &str) -> anyhow::Result<Frames> {
    let both = text.split_once(',').map(|(parent, child)| (parent.trim(), child.trim()));
    let both = both.filter(|(parent, child)| {
        !parent.is_empty() && !child.is_empty() && parent != child && !child.contains(',')
    });
    let (parent, child) = both.with_context(|| {
        format!("--motion-frames {text}: expected two different frames, PARENT,CHILD, as world,glass_holder")
    })?;
    Ok(Frames { parent: parent.into(), child: child.into() })
}

/// Returns the direction that the value `text` of `option` spells, of length one.
pub(super) fn direction(option: &str, text: &str) -> anyhow::Result<[f64; 3]> {
    let numbers: Vec<f64> = text.split(',').map_while(|number| number.trim().parse().ok()).collect();
    let line: Option<[f64; 3]> = numbers.try_into().ok().filter(|line: &[f64; 3]| {
        let square: f64 = line.iter().map(|n| n * n).sum();
        square > 1e-12 && square < 1e12
    });
    // Of length one: distances along it are lengths.
    let line = line.map(|line| {
        let length = line.iter().map(|n| n * n).sum::<f64>().sqrt();
        line.map(|n| n / length)
    });
    line.with_context(|| format!("{option} {text}: expected three numbers that are not all zero, as 0,1,0"))
}
