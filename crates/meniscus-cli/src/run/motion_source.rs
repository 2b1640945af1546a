//! `--motion`: the origin of a commanded motion.

use super::motion_tag::TagMotion;
use super::motion_topic::{TopicArguments, TopicMotion, direction};
use super::source::{RecordingSource, Source};
use crate::profile::Profile;
use anyhow::{Context, ensure};
use meniscus_platform::files::read_text;
use meniscus_service::commanded_motion::{
    CameraInlet, CommandedMotion, ExpectedSender, InletMotion, MotionInlet, WireMotion,
};
use meniscus_service::controller::PlanWire;
use std::net::{IpAddr, SocketAddr, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Letters of a token at the least.
const TOKEN_LEAST: usize = 16;
/// Letters of a token at the most: the datagram has to hold it.
const TOKEN_MOST: usize = 128;

/// Latency of the simulated camera's frames beyond that of samples, ms.
const LAG_MS: f64 = 8.0;

/// Flags of a commanded motion.
#[derive(clap::Args)]
pub(super) struct MotionArguments {
    /// Commanded or measured motion of the glass.
    ///
    /// A table of its position over time (t,x_m; second 0 is the first frame), the motion of the simulated camera's
    /// recording (truth), or datagrams: accelerations along x in m/s2, one ASCII number each, or stamped samples in three
    /// dimensions (docs/robots.md), 100 or more a second. A number before the ASCII one, as in `#17 -1.25`, has to rise.
    ///
    /// With --ros2 also a topic, as ros2:/odom, of type nav_msgs/Odometry, geometry_msgs/PoseStamped or TransformStamped,
    /// tf2_msgs/TFMessage, sensor_msgs/Imu or JointState. Whoever reaches the domain can publish on this topic.
    ///
    /// tag:7,40 is the AprilTag 7 of the family 36h11, whose black square is 40 mm wide, fixed to the glass or to what holds it. Its
    /// pose is taken from the camera's own images (docs/robots.md).
    ///
    /// Without a motion, while no sample comes, and while the image
    /// contradicts the samples, the glass is tracked in the image.
    #[arg(
        long,
        value_name = "FILE.csv|truth|tag:ID,SIZE_MM|udp:HOST:PORT|ros2:TOPIC",
        help_heading = "Motion of the glass"
    )]
    pub(super) motion: Option<String>,
    /// With --motion udp or ros2: latency of frames beyond that of samples, ms [default: 8].
    ///
    /// A stamped sample has none, so that this is the least latency of frames. 8 is the simulated camera's; nobody has measured a D435's.
    #[arg(long, value_name = "MS", help_heading = "Motion of the glass")]
    pub(super) motion_lag_ms: Option<f64>,
    /// With stamped samples: direction of the camera's x, the line of the model, in their axes.
    ///
    /// Those of a tag are the camera's: right, down, forward.
    #[arg(long, default_value = "1,0,0", value_name = "X,Y,Z", help_heading = "Motion of the glass")]
    pub(super) motion_line: String,
    /// With --motion udp: only address heard [default: the profile's].
    ///
    /// Needed, or a token, where others reach the port.
    #[arg(long, value_name = "ADDRESS", help_heading = "Motion of the glass")]
    pub(super) motion_from: Option<IpAddr>,
    /// With --motion udp: file of a word that each datagram has to begin with [default: the profile's].
    ///
    /// At least 16 letters, digits, - or _. It travels unencrypted.
    #[arg(long, value_name = "FILE", help_heading = "Motion of the glass")]
    pub(super) motion_token_file: Option<PathBuf>,
    /// A topic of ROS 2.
    #[command(flatten)]
    topic: TopicArguments,
}

/// Returns the direction that --motion-line spells.
fn line(text: &str) -> anyhow::Result<[f64; 3]> {
    direction("--motion-line", text)
}

/// Returns the token in the file at `path`.
fn token(path: &Path) -> anyhow::Result<String> {
    let text = read_text(path)
        .with_context(|| format!("the token of --motion in {} cannot be read", path.display()))?;
    let token = text.trim();
    let plain = |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '-' | '_');
    ensure!(
        (TOKEN_LEAST..=TOKEN_MOST).contains(&token.len()) && token.chars().all(plain),
        "the token of --motion in {0} has to be one line of {TOKEN_LEAST} to {TOKEN_MOST} letters, digits, - or _: \
         openssl rand -hex 16 > {0}",
        path.display()
    );
    Ok(token.into())
}

/// Origin of a commanded motion.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum MotionSource {
    /// The motion that the simulated camera's recording was made with.
    Truth,
    /// A table of the position over time, or a motion by name.
    Table(String),
    /// Accelerations or stamped samples over UDP.
    Udp(WireMotion),
    /// Messages on a topic of ROS 2.
    Topic(TopicMotion),
    /// A tag in the camera's images.
    Tag(TagMotion),
}

/// A motion for a run.
pub(super) struct OpenMotion {
    /// The run's end.
    pub(super) motion: CommandedMotion,
    /// The other end of a motion by messages.
    #[cfg_attr(not(feature = "ros2"), allow(dead_code, reason = "a program without ROS 2 has none"))]
    pub(super) inlet: Option<MotionInlet>,
    /// The other end of a motion by images.
    pub(super) tag: Option<(TagMotion, CameraInlet)>,
}

impl MotionArguments {
    /// Returns the address and the sender of `option`, whose value is `udp:ADDRESS`, with the sender of `profile` where the
    /// flags name none.
    fn wire(
        &self,
        option: &str,
        address: &str,
        profile: Option<&Profile>,
    ) -> anyhow::Result<(SocketAddr, ExpectedSender)> {
        let unknown = || format!("{option} udp:{address}: expected udp:HOST:PORT, as udp:127.0.0.1:9000");
        let address = address.to_socket_addrs().with_context(unknown)?.next().with_context(unknown)?;
        let file = self.motion_token_file.as_ref();
        let file = file.or(profile.and_then(|profile| profile.motion_token_file.as_ref()));
        let expected = ExpectedSender {
            address: self.motion_from.or(profile.and_then(|profile| profile.motion_from)),
            token: file.map(|path| token(path)).transpose()?,
        };
        ensure!(
            address.ip().is_loopback() || expected != ExpectedSender::default(),
            "{option} udp:{address}: others reach that address and could move the estimated glass. Name the sender with \
             --motion-from ADDRESS, or give it a token with --motion-token-file FILE"
        );
        Ok((address, expected))
    }

    /// Refuses flags of another kind of motion than `kind`.
    fn refuse_others(&self, kind: &str, source: &str) -> anyhow::Result<()> {
        let of_udp = self.motion_from.is_some() || self.motion_token_file.is_some();
        ensure!(
            kind == "udp" || !(of_udp || (self.motion_lag_ms.is_some() && kind != "ros2")),
            "--motion-from, --motion-token-file and --motion-lag-ms are for --motion udp:HOST:PORT, the last also for \
             ros2:TOPIC: add it, or leave them out"
        );
        ensure!(
            kind == "ros2" || !self.topic.any(),
            "--motion-frames, --motion-joint, --motion-axis and --motion-clock are for --motion ros2:TOPIC, not {source:?}"
        );
        Ok(())
    }

    /// Returns the direction of the line of the model, of length one.
    #[cfg(feature = "ros2")]
    pub(super) fn line(&self) -> anyhow::Result<[f64; 3]> {
        line(&self.motion_line)
    }

    /// Returns where plans come in, as `plan` spells it.
    pub(super) fn plan_wire(&self, plan: &str, profile: Option<&Profile>) -> anyhow::Result<PlanWire> {
        let address = plan.strip_prefix("udp:");
        let address = address
            .with_context(|| format!("--plan {plan}: expected udp:HOST:PORT, as udp:127.0.0.1:9001"))?;
        let (address, expected) = self.wire("--plan", address, profile)?;
        Ok(PlanWire { address, line: line(&self.motion_line)?, expected })
    }
}

impl MotionSource {
    /// Returns the origin that `arguments` spell, with the senders of `profile` where they name none.
    pub(super) fn parse(
        arguments: &MotionArguments,
        profile: Option<&Profile>,
    ) -> anyhow::Result<Option<Self>> {
        let Some(source) = arguments.motion.as_deref() else {
            arguments.refuse_others("", "")?;
            return Ok(None);
        };
        let (kind, rest) = source.split_once(':').unwrap_or(("", ""));
        arguments.refuse_others(kind, source)?;
        let lag_ms = arguments.motion_lag_ms.unwrap_or(LAG_MS);
        ensure!((0.0..=100.0).contains(&lag_ms), "--motion-lag-ms {lag_ms} is out of range: 0 to 100");
        let (line, lag_s) = (line(&arguments.motion_line)?, 1e-3 * lag_ms);
        Ok(Some(match (kind, source) {
            ("udp", _) => {
                let (address, expected) = arguments.wire("--motion", rest, profile)?;
                Self::Udp(WireMotion { address, lag_s, line, expected })
            }
            ("tag", _) => Self::Tag(TagMotion::parse(rest, line)?),
            ("ros2", _) => Self::Topic(arguments.topic.motion(rest, line, lag_s)?),
            (_, "truth") => Self::Truth,
            (_, table) => Self::Table(table.into()),
        }))
    }

    /// Opens the motion for a run of this length before `camera`.
    pub(super) fn open(&self, camera: &Source, length: Duration) -> anyhow::Result<OpenMotion> {
        let say = Box::new(|line: &str| eprintln!("{line}"));
        let motion = match self {
            Self::Truth => by_table("truth", Some(recording_of(camera)?), length)?,
            Self::Table(table) => by_table(table, None, length)?,
            Self::Udp(wire) => CommandedMotion::by_wire(wire.clone(), say)
                .with_context(|| format!("--motion udp:{} cannot be listened to", wire.address))?,
            Self::Topic(TopicMotion { lag_s, line, .. }) => {
                let settings = InletMotion { lag_s: *lag_s, line: *line };
                let (motion, inlet) = CommandedMotion::by_inlet(settings, say);
                return Ok(OpenMotion { motion, inlet: Some(inlet), tag: None });
            }
            Self::Tag(tag) => {
                let (motion, inlet) = CommandedMotion::by_camera(tag.line, say);
                return Ok(OpenMotion { motion, inlet: None, tag: Some((*tag, inlet)) });
            }
        };
        Ok(OpenMotion { motion, inlet: None, tag: None })
    }
}

/// Returns the recording that a simulated camera stands before.
fn recording_of(camera: &Source) -> anyhow::Result<RecordingSource> {
    match camera {
        Source::Rendered { recording, .. } => Ok(recording.clone()),
        Source::SimulatedUsb { .. } => Ok(RecordingSource::Shipped),
        Source::Usb | Source::Webcam(_) => {
            anyhow::bail!("--motion truth is for a simulated camera: a camera before a glass has none")
        }
        Source::Replay { .. } => anyhow::bail!("--motion truth is for a simulated camera: replay has none"),
    }
}

#[cfg(not(feature = "studies"))]
fn by_table(source: &str, _: Option<RecordingSource>, _: Duration) -> anyhow::Result<CommandedMotion> {
    anyhow::bail!(
        "--motion {source} cannot be read: this program was built without the simulator, which knows motions; from the \
         repository: cargo run --release -- run --motion {source}"
    )
}

#[cfg(feature = "studies")]
fn by_table(
    source: &str,
    recording: Option<RecordingSource>,
    length: Duration,
) -> anyhow::Result<CommandedMotion> {
    use meniscus_data::motion::Motion;

    /// Rate at which a table is checked before it is used, Hz.
    const CHECKS_HZ: f64 = 50.0;
    /// Largest distance of the glass from the line along x, m: a hand's unsteadiness, which the model ignores.
    const BESIDE_M: f64 = 0.010;

    let seconds = length.as_secs_f64();
    let motion = match recording {
        Some(recording) => of_recording(&recording)?,
        None => Motion::parse(source, seconds).with_context(|| format!("--motion {source}"))?,
    };
    // Behind the end of a table the tracked position of the glass is used.
    let seconds = seconds.min(motion.end_s());
    for time_s in (0..(seconds * CHECKS_HZ) as u64).map(|k| k as f64 / CHECKS_HZ) {
        let [away_m, height_m, tilt_rad] = [motion.away(time_s), motion.height(time_s), motion.tilt(time_s)];
        ensure!(
            away_m.abs() <= BESIDE_M && height_m == 0.0 && tilt_rad == 0.0,
            "--motion {source}: at {time_s:.2} s the glass is {away_m:.4} m beside its line, lifted by {height_m:.4} m and \
             inclined by {tilt_rad:.4} rad; the model knows motion along x alone, and bears {BESIDE_M} m beside it"
        );
    }
    Ok(CommandedMotion::by_table(seconds, |time_s| motion.acceleration(time_s.max(0.0))))
}

/// Returns the motion of the glass in a recording, from its position in every frame.
#[cfg(feature = "studies")]
fn of_recording(recording: &RecordingSource) -> anyhow::Result<meniscus_data::motion::Motion> {
    let recording = recording.load()?;
    let positions: Vec<(f64, f64)> =
        (0..).map(|frame| f64::from(frame) / 60.0).zip(recording.glass_x_m.iter().copied()).collect();
    meniscus_data::motion::Motion::sampled(&positions).context("the recording has no motion")
}
