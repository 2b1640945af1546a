//! `--motion`: the origin of a commanded motion.

use super::source::{RecordingSource, Source};
use anyhow::{Context, ensure};
use meniscus_service::commanded_motion::CommandedMotion;
use std::net::{SocketAddr, ToSocketAddrs};
use std::time::Duration;

/// Origin of a commanded motion.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum MotionSource {
    /// The motion that the simulated camera's recording was made with.
    Truth,
    /// A table of the position over time, or a motion by name.
    Table(String),
    /// Accelerations over UDP.
    Udp { address: SocketAddr, lag_s: f64 },
}

impl MotionSource {
    /// Returns the origin that `source` spells; `lag_ms` is the extra latency of camera frames over UDP samples.
    pub(super) fn parse(source: &str, lag_ms: f64) -> anyhow::Result<Self> {
        let Some(address) = source.strip_prefix("udp:") else {
            return Ok(if source == "truth" { Self::Truth } else { Self::Table(source.into()) });
        };
        ensure!((0.0..=100.0).contains(&lag_ms), "--motion-lag-ms {lag_ms} is out of range: 0 to 100");
        let unknown = || format!("--motion udp:{address}: expected udp:HOST:PORT, as udp:127.0.0.1:9000");
        let address = address.to_socket_addrs().with_context(unknown)?.next().with_context(unknown)?;
        Ok(Self::Udp { address, lag_s: 1e-3 * lag_ms })
    }

    /// Opens the motion for a run of this length before `camera`.
    pub(super) fn open(&self, camera: &Source, length: Duration) -> anyhow::Result<CommandedMotion> {
        match self {
            Self::Truth => by_table("truth", Some(recording_of(camera)?), length),
            Self::Table(table) => by_table(table, None, length),
            Self::Udp { address, lag_s } => CommandedMotion::by_wire(*address, *lag_s)
                .with_context(|| format!("--motion udp:{address} cannot be listened to")),
        }
    }
}

/// Returns the recording that a simulated camera stands before.
fn recording_of(camera: &Source) -> anyhow::Result<RecordingSource> {
    match camera {
        Source::Rendered { recording, .. } => Ok(recording.clone()),
        Source::SimulatedUsb { .. } => Ok(RecordingSource::Shipped),
        Source::Usb => anyhow::bail!("--motion truth is for a simulated camera: usb has none"),
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
