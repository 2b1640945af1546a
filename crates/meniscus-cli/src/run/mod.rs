//! `meniscus run`: the main job, live. Flags become a [`RunConfig`] here, and nothing behind this file sees them.

mod config;
mod foxglove;
mod from_flags;
mod live;
mod motion_source;
mod motion_tag;
mod motion_topic;
mod needs;
mod page;
mod printed;
mod published;
#[cfg(feature = "desk")]
mod rendered;
#[cfg(feature = "bags")]
mod replay;
mod ros2;
#[cfg(feature = "desk")]
mod shown;
#[cfg(not(feature = "desk"))]
#[path = "unshown.rs"]
mod shown;
mod source;
mod usb;
#[cfg(feature = "webcam")]
mod webcam;

use crate::bus;
use crate::inputs::blob;
use crate::variant::VariantName;
use anyhow::Context;
use config::RunConfig;
use foxglove::FoxgloveArguments;
use meniscus::blob::Model;
use meniscus_hil::FaultList;
use meniscus_platform::realtime::Priority;
use meniscus_service::publish::Destination;
use motion_source::MotionArguments;
#[cfg(feature = "desk")]
pub(crate) use motion_tag::{NUMBERS, SIZES_MM};
pub(crate) use needs::Needs;
use page::PageArguments;
#[cfg(feature = "desk")]
pub(crate) use rendered::plate_with;
use ros2::RosArguments;
use source::Source;
use std::path::PathBuf;
use usb::BusCamera;

/// Payload buffers between camera and worker: both streams, four frames deep.
const BUFFERS: usize = 8;

/// Estimate the liquid in the glass from camera images at 60 Hz.
///
/// Without options no camera is needed: a simulated D435 looks at a glass of glycerine that the model has never seen. The
/// estimate is compared with the truth at the end.
///
/// --source usb reads a D435 or D435i. There is no truth then. `meniscus doctor` checks the camera. A camera's recording
/// (.mcap, .bag, .db3 or a folder of images) is played at its own pace.
///
/// --source v4l:/dev/video0 reads a colour webcam, which has no depth: `meniscus setup` takes its lens and its distance by
/// hand. Most have 30 Hz; the turns between their frames predict. A folder of images with their times is played in the same
/// way (docs/formats.md).
///
/// A terminal shows a dashboard with the liquid inside, its surface, the stage times, energy and heat; q or Ctrl-C ends the run.
/// --view shows the liquid in 3D in a browser instead. A summary follows, and a picture in the --out folder.
///
/// A turn that misses its deadline of 16.67 ms is written to the --out folder with the ten seconds around it
/// (flight-01.csv and on; the last 20 are kept).
///
/// Modes: Filling (the window of 16 frames is not full yet), Tracking, Coasting (frame lost or liquid not seen: prediction
/// alone), Halted (no frame for a second: no estimate).
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus run\n  meniscus run --view\n  meniscus run --source usb\n  meniscus run --source v4l:/dev/video0 --setup glass.toml\n  meniscus run --source try.mcap --setup glass.toml\n  meniscus run --source simulated-usb:unplug --seconds 8\n  meniscus run --patient --json\n  meniscus run --patient --variant small\n  meniscus run --faults drop:0.05,late:0.02 --out /tmp/faulty\n  meniscus run --motion truth\n  meniscus run --motion tag:7,40\n  meniscus run --source usb --motion udp:0.0.0.0:9000 \\\n    --motion-from 192.168.1.20\n  meniscus run --among shipped\n  meniscus run --estimates run.safetensors\n  meniscus run --view --listen 0.0.0.0:8060\n  meniscus run --foxglove --mcap run.mcap\n  meniscus run --ros2\n  meniscus run --ros2 --motion ros2:/odom --motion-line 0,1,0\n  meniscus run --ros2 --motion ros2:/tf \\\n    --motion-frames world,glass_holder\n  meniscus run --ros2 5 --ros2-network 192.168.1.7"
)]
pub(crate) struct Arguments {
    /// Origin of the images.
    ///
    /// A simulated camera before the recording in the program (shipped) or a recording of `meniscus simulate`; a camera on
    /// the bus (usb); a simulated camera on a simulated bus (simulated-usb, with a trouble by name or number); or a camera's
    /// recording (.mcap, .bag, .db3, folder). `--source replay FILE` names it too. v4l:DEVICE is a webcam.
    #[arg(
        long,
        default_value = "shipped",
        value_name = "shipped|usb|v4l:DEVICE|simulated-usb[:TROUBLE]|FILE|FOLDER",
        help_heading = "Images"
    )]
    source: PathBuf,
    /// Glass and camera position, as `meniscus setup` wrote them.
    ///
    /// Without it a level camera 400 mm before the model's glass, 30 mm above its foot.
    #[arg(long, value_name = "FILE.toml", help_heading = "Images")]
    setup: Option<PathBuf>,
    /// A camera's recording, with `--source replay` only.
    file: Option<PathBuf>,
    /// Serial number of the only camera that is taken, as USB shows it.
    #[arg(long, help_heading = "Images")]
    serial: Option<String>,
    /// Least latency from mid-exposure to the arrival of a frame, ms, as you measured it.
    ///
    /// Without it the stamps on this computer's clock assume 0 to 33 ms, and say so by their uncertainty. 8.3 is the
    /// simulated camera's.
    #[arg(long, value_name = "MS", help_heading = "Images")]
    camera_latency_ms: Option<f64>,
    /// Faults on the simulated camera's wire.
    ///
    /// Spelled NAME:SHARE or NAME@FRAME, joined by commas, as in drop:0.02,tear@100. Names: drop tear late fid eof err
    /// length0 length2 length200 duplicate gap split noinfrared overlong empty.
    #[arg(long, default_value = "", hide_default_value = true, value_name = "LIST", help_heading = "Images")]
    faults: FaultList,
    /// Seed of the simulated camera's noise and faults.
    #[arg(long, default_value_t = 1, help_heading = "Images")]
    seed: u64,
    /// Recording that a camera on a bus is scored against.
    ///
    /// For a simulated camera that begins with this recording's first frame.
    #[arg(long, value_name = "shipped|FILE", help_heading = "Images")]
    truth: Option<String>,
    /// The model: the one in the program (shipped), a blob, or a folder of `meniscus flash`.
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE|FOLDER", help_heading = "Model")]
    model: PathBuf,
    /// The board's profile, whose key must have signed the model.
    ///
    /// For a file, the signature is FILE.sig beside it. The model in the program needs none. Without this option the rules of
    /// /etc/meniscus/board.toml hold for the slots that it names.
    #[arg(long, value_name = "FILE.toml", help_heading = "Model")]
    profile: Option<PathBuf>,
    /// Field groups to decode: q, v, e, sigma, tau, joined by commas.
    ///
    /// For a board that lacks the time for all. `none` leaves the surface; surface and audit are always computed.
    #[arg(long, default_value = "all", value_name = "all|none|GROUPS", help_heading = "Model")]
    fields: String,
    /// Estimator: all of it, or what a microcontroller computes at 60 Hz.
    ///
    /// `small` has the surface and no field, in single precision: a sixth of the instructions on a Cortex-M7.
    #[arg(long, default_value = "full", help_heading = "Model")]
    variant: VariantName,
    /// Also identify the liquid among these known ones; may be repeated.
    ///
    /// Those in the program (shipped), a note of `meniscus recognise learn`, or a folder of notes. It has a thread of its
    /// own.
    #[arg(long, value_name = "shipped|FILE|DIR", help_heading = "Model")]
    among: Vec<String>,
    /// Options from a file; those of the command line go before it.
    ///
    /// Its groups and keys are those of this help, as in `[images]`, `source = "usb"`. `meniscus service check` shows what
    /// comes of it. The installed service reads /etc/meniscus/meniscus.toml.
    #[arg(long, value_name = "FILE.toml", help_heading = "Configuration")]
    config: Option<PathBuf>,
    /// Motion of the glass.
    #[command(flatten)]
    motion: MotionArguments,
    /// Length of the run, s, 1.5 to 3600; 10 by default, endless with --view.
    ///
    /// Without --view the run ends with the recording at the latest.
    #[arg(long, help_heading = "Time")]
    seconds: Option<f64>,
    /// Let the simulated camera wait for the estimator: no frame is late, and the errors are the same everywhere.
    ///
    /// Times then say nothing about a camera's 60 Hz, and their checks are informational.
    #[arg(long, conflicts_with = "service", help_heading = "Time")]
    patient: bool,
    /// Ask for real-time priority, a core for the worker and locked memory.
    ///
    /// A refusal is reported with its remedy, and the run goes on. --service always asks.
    #[arg(long, help_heading = "Time")]
    realtime: bool,
    /// Run as a service until SIGTERM or Ctrl-C.
    ///
    /// Reports to systemd that it is ready and alive, and every change of the mode to standard error. For --source usb.
    #[arg(long, conflicts_with_all = ["seconds", "truth", "turns", "estimates"], help_heading = "Time")]
    service: bool,
    /// The live page.
    #[command(flatten)]
    page: PageArguments,
    /// Foxglove.
    #[command(flatten)]
    foxglove: FoxgloveArguments,
    /// ROS 2.
    #[command(flatten)]
    ros2: RosArguments,
    /// Send every estimate to unix:PATH, udp:HOST:PORT or serial:DEVICE[@BAUD]; may be repeated.
    ///
    /// The format is in firmware-config/SPEC.md, clients are in examples/.
    #[arg(long, value_name = "WHERE", help_heading = "Publishing")]
    publish: Vec<Destination>,
    /// Rate of the full field on Unix sockets, Hz; 0 for never.
    #[arg(long, default_value_t = 0.0, value_name = "HZ", help_heading = "Publishing")]
    field_hz: f64,
    /// Also publish a record for a controller with each turn, on Unix sockets and UDP.
    ///
    /// Modes of the surface with their covariance, risk of spilling, and ten times a second the linearised model.
    /// docs/robots.md has its layout.
    #[arg(long, requires = "publish", help_heading = "Publishing")]
    controller: bool,
    /// With --controller: address that listens for plans of the motion.
    ///
    /// The forecast under the newest plan is in the record. The sender and the line of --motion udp: hold for
    /// plans, too.
    #[arg(long, value_name = "udp:HOST:PORT", requires = "controller", help_heading = "Publishing")]
    plan: Option<String>,
    /// Folder for report, picture and flight records; it is made.
    #[arg(long, default_value = "out", help_heading = "Output")]
    out: PathBuf,
    /// Write every turn as a row: both clocks, frame, mode and times.
    #[arg(long, value_name = "FILE.csv", help_heading = "Output")]
    turns: Option<PathBuf>,
    /// Write every estimate: state, covariance, surface, intervals, energy.
    ///
    /// The format is in firmware-config/SPEC.md.
    #[arg(long, value_name = "FILE.safetensors", help_heading = "Output")]
    estimates: Option<PathBuf>,
    /// Print one JSON object instead of dashboard and summary.
    #[arg(long, help_heading = "Output")]
    json: bool,
    /// Exit with status 1 if a check misses its target.
    #[arg(long, help_heading = "Output")]
    check: bool,
}

impl Arguments {
    /// Whether it is the run of a service.
    pub(crate) fn is_service(&self) -> bool {
        self.service
    }
}

/// Returns what a run asks of the system around it, all of it checked as at a start but for the camera.
pub(crate) fn needs(arguments: &Arguments) -> anyhow::Result<Needs> {
    let config = RunConfig::try_from(arguments)?;
    let bytes = blob(&config.model, config.profile.as_ref())?;
    Model::load(&bytes).with_context(|| format!("the model {} is refused", config.model_name))?;
    match &config.source {
        Source::Webcam(_) => drop(crate::webcam::setup(config.setup.as_deref())?),
        _ => drop(crate::glass::outline(config.setup.as_deref())?),
    }
    Ok(Needs::of(&config))
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let config = RunConfig::try_from(arguments)?;
    let bytes = blob(&config.model, config.profile.as_ref())?;
    let mut model =
        Model::load(&bytes).with_context(|| format!("the model {} is refused", config.model_name))?;
    model.header.variant = config.variant;
    match &config.source {
        #[cfg(feature = "desk")]
        Source::Rendered { recording, faults } => rendered::run(&config, &model, recording, faults),
        Source::Usb => {
            let (transport, priority) = (bus::machine()?, Priority::RealTime);
            usb::run(&config, &model, BusCamera { transport, name: "D435", priority })
        }
        #[cfg(not(feature = "desk"))]
        Source::Rendered { .. } | Source::SimulatedUsb { .. } => anyhow::bail!(bus::WITHOUT_SIMULATED),
        #[cfg(feature = "desk")]
        Source::SimulatedUsb { trouble, faults } => {
            let transport = usb::simulated(&config, *trouble, faults)?;
            let (name, priority) = ("simulated D435 over USB", Priority::Normal);
            usb::run(&config, &model, BusCamera { transport, name, priority })
        }
        #[cfg(feature = "webcam")]
        Source::Webcam(eye) => webcam::run(&config, &model, eye),
        #[cfg(not(feature = "webcam"))]
        Source::Webcam(eye) => Err(crate::webcam::not_built_in(eye.path())),
        #[cfg(feature = "bags")]
        Source::Replay { file } => replay::run(&config, &model, file),
        #[cfg(not(feature = "bags"))]
        Source::Replay { file } => anyhow::bail!(
            "{} cannot be read: this program was built without recordings of a camera; from the repository: cargo run \
             --release -- run --source replay {0}",
            file.display()
        ),
    }
}
