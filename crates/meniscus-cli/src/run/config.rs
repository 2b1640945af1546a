//! Configuration of a run: plain values, checked once at the door (`from_flags`). Nothing behind it sees the flags.

use super::motion_source::MotionSource;
use super::source::{RecordingSource, Source};
use crate::profile::Profile;
use meniscus::blob::Variant;
use meniscus::latent::decoder::Selection;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_platform::realtime::Priority;
use meniscus_score::run_report::RunLabels;
use meniscus_service::clock_map::LeastLatency;
use meniscus_service::controller::PlanWire;
use meniscus_service::live::Silence;
use meniscus_service::publish::Destination;
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::time::Duration;

/// Everything that determines a run.
#[derive(Clone, Debug)]
pub(super) struct RunConfig {
    /// Origin of the images.
    pub(super) source: Source,
    /// The source, as the user named it.
    pub(super) source_name: String,
    /// The model: `shipped`, a blob file or a folder of flash slots.
    pub(super) model: PathBuf,
    /// The same, as a person reads it.
    pub(super) model_name: String,
    /// The board's profile, with the key that a flashed model must be signed with.
    pub(super) profile: Option<Profile>,
    /// Glass and position of the camera, as `meniscus setup` wrote them.
    pub(super) setup: Option<PathBuf>,
    /// Serial number of the only camera on a bus that is taken.
    pub(super) serial: Option<String>,
    /// Seed of the simulated camera's noise and faults.
    pub(super) seed: u64,
    /// Frames of the run; of an endless one, frames whose turns are kept one by one.
    pub(super) frames: usize,
    /// End of the run.
    pub(super) end: RunEnd,
    /// Folder for report, picture and flight records.
    pub(super) out: PathBuf,
    /// Table of every turn.
    pub(super) turn_table: Option<PathBuf>,
    /// File of every estimate.
    pub(super) estimates: Option<PathBuf>,
    /// Publishing to other programs.
    pub(super) publishing: Publishing,
    /// Variant of the estimator.
    pub(super) variant: Variant,
    /// Groups of the field that are decoded.
    pub(super) fields: Selection,
    /// Reaction of the worker to a camera that sends nothing.
    pub(super) silence: Silence,
    /// Scheduling of the worker.
    pub(super) priority: Priority,
    /// Truth of a camera on a bus.
    pub(super) truth: Option<RecordingSource>,
    /// Liquids that are compared: `shipped`, notes and folders of notes.
    pub(super) among: Vec<String>,
    /// Least latency from mid-exposure to the arrival of a frame.
    pub(super) latency: LeastLatency,
    /// Commanded motion.
    pub(super) motion: Option<MotionSource>,
    /// The live page.
    pub(super) page: Option<PageConfig>,
    /// Foxglove.
    pub(super) foxglove: FoxgloveConfig,
    /// The ROS 2 node.
    pub(super) ros2: Option<RosConfig>,
    /// Direction of the line of the model in the axes of motion and plans, of length one.
    #[cfg(feature = "ros2")]
    pub(super) motion_line: [f64; 3],
    /// Foreground of the run.
    pub(super) front: Front,
    /// Form of the report on standard output.
    pub(super) output: Output,
    /// Consequence of a missed target.
    pub(super) targets: Targets,
}

/// End of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RunEnd {
    /// After [`RunConfig::frames`] frames.
    AfterFrames,
    /// When a person or the system stops it.
    WhenStopped,
}

/// Publishing to other programs.
#[derive(Clone, Debug)]
pub(super) struct Publishing {
    /// Destinations; none, no publishing.
    pub(super) destinations: Vec<Destination>,
    /// Rate of the full field on Unix sockets, Hz; 0 for never.
    pub(super) field_hz: f64,
    /// Records for a controller.
    pub(super) controller: Controlling,
}

/// Records for a controller.
#[derive(Clone, Debug)]
pub(super) enum Controlling {
    /// None.
    Off,
    /// One a turn, without a plan or with one that comes over UDP.
    On(Option<PlanWire>),
}

/// Address, secret and encryption of the live page.
#[derive(Clone, Debug)]
pub(super) struct PageConfig {
    /// Address to listen at.
    pub(super) listen: SocketAddr,
    /// File whose first line is the token.
    pub(super) token_file: Option<PathBuf>,
    /// Certificate and key.
    pub(super) encryption: Encryption,
}

/// Encryption of the live page.
#[derive(Clone, Debug)]
pub(super) enum Encryption {
    /// None.
    None,
    /// A certificate that is made for the run.
    Made,
    /// Certificate and key in PEM files.
    Given {
        /// The certificate, with those that signed it behind it.
        certificate: PathBuf,
        /// Its key.
        key: PathBuf,
    },
}

/// Server and file for Foxglove.
#[derive(Clone, Debug, Default)]
pub(super) struct FoxgloveConfig {
    /// Address of the WebSocket server.
    pub(super) address: Option<SocketAddr>,
    /// Origins of web pages that may connect besides Foxglove's own.
    #[cfg(feature = "foxglove")]
    pub(super) origins: Vec<String>,
    /// MCAP file.
    pub(super) file: Option<PathBuf>,
}

/// The ROS 2 node.
#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "ros2"), allow(dead_code, reason = "a program without ROS 2 refuses it"))]
pub(super) struct RosConfig {
    /// Domain.
    pub(super) domain: u16,
    /// Own addresses whose networks are used; none for all.
    pub(super) networks: Vec<IpAddr>,
    /// Rate of the tracers' cloud, Hz.
    pub(super) tracers_hz: f64,
    /// Probability of spilling above which the node warns.
    pub(super) spill_limit: f64,
}

/// Foreground of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Front {
    /// Reports to systemd.
    Service,
    /// The live page has everything; the terminal waits.
    Page,
    /// Dashboard in the terminal.
    Dashboard,
    /// A bar with the time left.
    Progress,
}

/// Form of the report on standard output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Output {
    /// A summary for a person.
    Text,
    /// One JSON object.
    Json,
}

/// Consequence of a missed target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Targets {
    /// It is reported.
    Reported,
    /// The command fails.
    Enforced,
}

impl RunConfig {
    /// Returns the length of the run; of an endless one, that of its log.
    pub(super) fn length(&self) -> Duration {
        Duration::from_secs_f64(self.frames as f64 * FRAME_INTERVAL_S)
    }

    /// Returns the frames whose turns are kept one by one, for a table or a truth; the report itself needs none.
    pub(super) fn frames_kept(&self) -> usize {
        let wanted = self.turn_table.is_some() || self.estimates.is_some() || self.truth.is_some();
        if wanted { self.frames } else { 0 }
    }

    /// Returns the names under which the run is reported.
    pub(super) fn labels(&self) -> RunLabels<'_> {
        RunLabels { model: &self.model_name, source: &self.source_name, seed: self.seed }
    }
}
