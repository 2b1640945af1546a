//! `meniscus run`: the main job, live. Flags become a [`RunConfig`] here, and nothing behind this file sees them.

mod config;
mod foxglove;
mod live;
mod motion_source;
mod page;
mod printed;
mod published;
mod rendered;
#[cfg(feature = "bags")]
mod replay;
mod source;
mod usb;

use crate::bus;
use crate::inputs::blob;
use anyhow::Context;
use config::RunConfig;
use foxglove::FoxgloveArguments;
use meniscus::blob::Model;
use meniscus_hil::FaultList;
use meniscus_platform::realtime::Priority;
use meniscus_service::publish::Destination;
use page::PageArguments;
use source::Source;
use std::path::PathBuf;
use usb::BusCamera;

/// Payload buffers between camera and worker: both streams, four frames deep.
const BUFFERS: usize = 8;

/// Watch the liquid: camera frames in, the whole liquid out, 60 times a second.
///
/// Without any option this shows the main job with no hardware: a simulated D435 looks at a glass
/// of glycerine in a recording that the model has never seen, its frames go byte for byte through
/// the same reader as a real camera's, and at the end the estimate is held against the truth.
///
/// With --source usb a D435 or D435i is read over plain USB; there is no truth then, and no check against
/// one. --source simulated-usb goes the same way from the first control request on, with a simulated
/// camera on a simulated bus before the same recording; simulated-usb:TROUBLE gives it a trouble by name
/// or number (simulated-usb:unplug; a wrong name lists them all). `meniscus doctor` checks the camera.
///
/// With --source replay FILE a recording of `meniscus record`, a librealsense .bag or .db3, or a folder of images is
/// played at its own pace through the same reader.
///
/// In a terminal a dashboard shows the surface, the modes, the stage times, energy and entropy;
/// q or Ctrl-C ends the run in order. At the end comes a summary, and a picture in the --out folder.
///
/// With --view a live page shows all that and the whole liquid in 3D in any browser, in the dashboard's place.
///
/// Around a turn that missed its deadline of 16.67 ms ten seconds of turns are written to the --out folder
/// (flight-01.csv and on, the last 20 are kept).
///
/// Modes: Filling (the window of 16 frames is not full), Tracking, Coasting (frame lost or liquid not
/// seen: the GENERIC step alone), Halted (nothing for a second: no estimate is given).
///
/// Faults are spelled NAME:SHARE or NAME@FRAME, joined by commas, as in drop:0.02,tear@100. Names:
/// drop tear late fid eof err length0 length2 length200 duplicate gap split noinfrared overlong empty.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "Examples:\n  meniscus run\n  meniscus run --seconds 10 --json\n  meniscus run --patient --json\n  meniscus run --faults drop:0.05,late:0.02 --out /tmp/faulty\n  meniscus run --view\n  meniscus run --view --listen 0.0.0.0:8060\n  meniscus run --foxglove --mcap run.mcap\n  meniscus run --estimates run.safetensors\n  meniscus run --among shipped\n  meniscus run --motion truth\n  meniscus run --source usb --motion udp:0.0.0.0:9000\n  meniscus run --source usb\n  meniscus run --source simulated-usb:unplug --seconds 8\n  meniscus run --source replay try.mcap"
)]
pub(crate) struct Arguments {
    /// Length of the run, s: 10 by default, with --view until Ctrl-C. Without --view it ends with the recording at the
    /// latest.
    #[arg(long)]
    seconds: Option<f64>,
    /// What the simulated camera looks at, the recording in the program (shipped) or a recording file; or
    /// a camera on the bus (usb), or a simulated one on a simulated bus (simulated-usb), or a camera's
    /// recording (replay, with its FILE).
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE|usb|simulated-usb[:TROUBLE]|replay")]
    source: String,
    /// Glass and position of the camera, as `meniscus setup` wrote them; without it a level camera 400 mm before the
    /// model's glass, 30 mm above its foot.
    #[arg(long, value_name = "FILE.toml")]
    setup: Option<PathBuf>,
    /// The camera's recording, with --source replay.
    file: Option<PathBuf>,
    /// The model: the one in the program (shipped), a blob file, or a folder that `meniscus flash` has written.
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE|FOLDER")]
    model: String,
    /// The board's profile, whose key a flashed model must be signed with.
    #[arg(long, value_name = "FILE.toml")]
    profile: Option<PathBuf>,
    /// Faults on the camera's wire.
    #[arg(long, default_value = "", value_name = "LIST")]
    faults: FaultList,
    /// Only the camera with this serial number (the one that USB shows), with --source usb.
    #[arg(long)]
    serial: Option<String>,
    /// Seed of the camera's noise and faults.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder for the picture; it is made if it is not there.
    #[arg(long, default_value = "out")]
    out: PathBuf,
    /// Hand every estimate on to unix:PATH, udp:HOST:PORT or serial:DEVICE[@BAUD]; may be repeated. The
    /// format is in firmware-config/SPEC.md, clients in examples/.
    #[arg(long, value_name = "WHERE")]
    publish: Vec<Destination>,
    /// How often the full field goes to those who read a Unix socket, times a second.
    #[arg(long, default_value_t = 0.0, value_name = "HZ")]
    field_hz: f64,
    /// Decode no more of the field than these groups (q, v, e, sigma, tau, joined by commas; none leaves the surface
    /// alone): for a board that has not the time for all. The surface and the audit are never left out.
    #[arg(long, default_value = "all", value_name = "all|none|GROUPS")]
    fields: String,
    /// Also write every turn as a row of this table: wall clock, camera clock, frame, mode, times.
    #[arg(long, value_name = "FILE.csv")]
    turns: Option<PathBuf>,
    /// Also write every estimate into this file: times on both clocks, reduced state with its covariance, surface,
    /// intervals, energy. The format is in firmware-config/SPEC.md.
    #[arg(long, value_name = "FILE.safetensors")]
    estimates: Option<PathBuf>,
    /// The simulated camera waits for the worker and not for the clock: nothing is late, however busy the machine, so
    /// that the errors are the same everywhere; times then tell nothing of a camera's 60 Hz.
    #[arg(long, conflicts_with_all = ["view", "service"])]
    patient: bool,
    /// Ask for what keeps a deadline: real-time priority (SCHED_FIFO) and a core of its own for the worker, all memory
    /// locked. A refusal is reported with its remedy, and the run goes on. --service always asks.
    #[arg(long)]
    realtime: bool,
    /// Run until it is stopped (SIGTERM, Ctrl-C), as a service: tells systemd that it is ready and alive, and standard
    /// error every change of the mode. For --source usb; --seconds is not used.
    #[arg(long, conflicts_with_all = ["seconds", "truth", "turns", "estimates"])]
    service: bool,
    /// Score a run with a camera on a bus against the truth of this recording: for a simulated camera that shows it from
    /// the first frame on.
    #[arg(long, value_name = "shipped|FILE")]
    truth: Option<String>,
    /// Also identify the liquid among these: those in the program (shipped), a note of `meniscus recognise learn`, or a
    /// folder of notes; may be repeated. A thread of its own does it; the turn does not wait.
    #[arg(long, value_name = "shipped|FILE|DIR")]
    among: Vec<String>,
    /// Commanded motion of the glass: a table of its position over time (t,x_m; second 0 is the first frame), the motion
    /// of the simulated camera's recording, or accelerations along x in m/s2 over UDP, one ASCII number a datagram, 100 or
    /// more a second. Without it, and while no sample comes, the position of the glass is tracked in the image.
    #[arg(long, value_name = "FILE.csv|truth|udp:HOST:PORT")]
    motion: Option<String>,
    /// With --motion udp: extra latency of camera frames over UDP samples, ms. 8 is the simulated camera's; that of a D435
    /// has not been measured.
    #[arg(long, default_value_t = 8.0, value_name = "MS")]
    motion_lag_ms: f64,
    /// The live page.
    #[command(flatten)]
    page: PageArguments,
    /// Foxglove.
    #[command(flatten)]
    foxglove: FoxgloveArguments,
    /// One JSON object on standard output instead of dashboard and summary.
    #[arg(long)]
    json: bool,
    /// Fail (exit status 1) if any check misses its target.
    #[arg(long)]
    check: bool,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let config = RunConfig::try_from(arguments)?;
    let bytes = blob(&config.model, config.profile.as_deref())?;
    let model = Model::load(&bytes).with_context(|| format!("the model {} is refused", config.model))?;
    match &config.source {
        Source::Rendered { recording, faults } => rendered::run(&config, &model, recording, faults),
        Source::Usb => {
            let (transport, priority) = (bus::machine()?, Priority::RealTime);
            usb::run(&config, &model, BusCamera { transport, name: "D435", priority })
        }
        Source::SimulatedUsb { trouble, faults } => {
            let transport = usb::simulated(&config, *trouble, faults)?;
            let (name, priority) = ("simulated D435 over USB", Priority::Normal);
            usb::run(&config, &model, BusCamera { transport, name, priority })
        }
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
