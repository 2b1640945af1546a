//! `meniscus run`: the main job, live.

mod flight;
mod foxglove;
mod live;
mod live_report;
mod motion_source;
mod page;
mod published;
#[cfg(feature = "bags")]
mod replay;
mod report;
mod service;
mod turns;
mod usb;
mod view;

use crate::glass;
use crate::inputs::{blob, check_level};
use anyhow::{Context, bail, ensure};
use foxglove::FoxgloveArguments;
use live::live;
use meniscus::blob::Model;
use meniscus::surface::{Config, Settings};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::recording::Recording;
use meniscus_hil::FaultList;
use meniscus_platform::files::write_whole;
use meniscus_service::live::Still;
use meniscus_service::publish::Destination;
use meniscus_usb::link::link;
use meniscus_virtual::camera::{PAYLOAD_ROOM, SimulatedCamera};
use meniscus_virtual::render::SceneSettings;
use page::PageArguments;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Payload buffers between camera and worker: both streams, four frames deep.
const BUFFERS: usize = 8;

/// Length of a run that nobody has told another, seconds.
const SECONDS: f64 = 10.0;

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
    after_help = "Examples:\n  meniscus run\n  meniscus run --seconds 10 --json\n  meniscus run --patient --json\n  meniscus run --faults drop:0.05,late:0.02 --out /tmp/faulty\n  meniscus run --view\n  meniscus run --view --listen 0.0.0.0:8060\n  meniscus run --foxglove --mcap run.mcap\n  meniscus run --among shipped\n  meniscus run --motion truth\n  meniscus run --source usb --motion udp:0.0.0.0:9000\n  meniscus run --source usb\n  meniscus run --source simulated-usb:unplug --seconds 8\n  meniscus run --source replay try.mcap"
)]
pub(crate) struct Arguments {
    /// Length of the run, s: 10 unless told, and with --view until Ctrl-C. Without --view it ends earlier where the
    /// recording does.
    #[arg(long)]
    seconds: Option<f64>,
    /// What the simulated camera looks at, the recording in the program (shipped) or a recording file; or
    /// a camera on the bus (usb), or a simulated one on a simulated bus (simulated-usb), or a camera's
    /// recording (replay, with its FILE).
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE|usb|simulated-usb[:TROUBLE]|replay")]
    source: String,
    /// The glass and the place of the camera, as `meniscus setup` has written them; without it a camera 400 mm before the
    /// model's glass, 30 mm above its foot, level.
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
    /// The simulated camera waits for the worker and not for the clock: nothing is late, however busy the machine, so
    /// that the errors are the same everywhere; times then tell nothing of a camera's 60 Hz.
    #[arg(long, conflicts_with_all = ["view", "service"])]
    patient: bool,
    /// Ask for what keeps a deadline: real-time priority (SCHED_FIFO) and a core of its own for the worker, all memory
    /// locked. What the system refuses is told, with what to do, and the run goes on. --service asks always.
    #[arg(long)]
    realtime: bool,
    /// Run until it is stopped (SIGTERM, Ctrl-C), as a service: tells systemd that it is ready and alive, and standard
    /// error every change of the mode. For --source usb; --seconds is not used.
    #[arg(long, conflicts_with_all = ["seconds", "truth", "turns"])]
    service: bool,
    /// Hold a run with a camera on a bus against this recording's truth: for a simulated camera that shows it
    /// from the first frame on.
    #[arg(long, value_name = "shipped|FILE")]
    truth: Option<String>,
    /// Also say which of these liquids it is: those in the program (shipped), a note of `meniscus recognise learn`, or a
    /// folder of notes; may be repeated. A thread of its own does it, and the turn waits for nothing.
    #[arg(long, value_name = "shipped|FILE|DIR")]
    among: Vec<String>,
    /// How the glass moves, from somebody who knows: a table of its place over time (t,x_m; second 0 is the first
    /// frame), the motion that the simulated camera's recording was made with, or an IMU or a robot that sends its
    /// acceleration along x in m/s2, a number in ASCII a datagram, 100 or more a second. Without it, and while
    /// nothing is told, the edges of the glass tell it.
    #[arg(long, value_name = "FILE.csv|truth|udp:HOST:PORT")]
    motion: Option<String>,
    /// With --motion udp: by how much later a frame arrives behind the middle of its exposure than a datagram behind
    /// what it tells, ms. 8 is the simulated camera's; no D435's has been measured.
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
    let frames = frames(arguments.seconds.unwrap_or(SECONDS))?;
    let bytes = blob(&arguments.model, arguments.profile.as_deref())?;
    let model = Model::load(&bytes).with_context(|| format!("the model {} is refused", arguments.model))?;
    if let Some(bus) = usb::bus_of(&arguments.source) {
        return usb::run(arguments, &model, frames, bus);
    }
    ensure!(!arguments.service, "--service is for a camera on a bus");
    ensure!(arguments.truth.is_none(), "--truth is for a camera on a bus; a recording brings its own");
    match (&arguments.file, arguments.source == "replay") {
        #[cfg(feature = "bags")]
        (Some(file), true) => return replay::run(arguments, &model, frames, file),
        #[cfg(not(feature = "bags"))]
        (Some(file), true) => bail!(
            "{} cannot be read: this program was built without recordings of a camera; from the repository: cargo run \
             --release -- run --source replay {0}",
            file.display()
        ),
        (None, true) => bail!("--source replay needs the recording: meniscus run --source replay FILE"),
        (Some(file), false) => bail!("{} is taken with --source replay only", file.display()),
        (None, false) => {}
    }
    let recording = recording(&arguments.source)?;
    let settings = settings(&model, &recording)?;
    let config = Config::new(glass::settings(arguments.setup.as_deref(), &model.header, settings.optics())?)?;
    // Told before the run, not after it: a folder that cannot be written would lose the picture.
    let picture = arguments.out.join("run.png");
    write_whole(&arguments.out.join("run.json"), b"{}\n").context("the --out folder cannot be used")?;

    let scene = SceneSettings { camera: settings, seed: arguments.seed, ..SceneSettings::default() };
    let mut camera = SimulatedCamera::new(&recording, scene, arguments.faults.clone());
    if arguments.patient {
        camera = camera.patient();
    }
    let mut frames = frames.min(recording.frames());
    let mut shots = frames;
    if arguments.page.view {
        camera = camera.repeating();
        shots = arguments.seconds.map_or(Ok(usize::MAX), self::frames)?;
        // The log has room for the first round, which is held against the truth, and counts the rest.
        frames = shots.min(recording.frames());
    }
    let mut still = Still::default();
    let (camera_end, worker_end) = link(BUFFERS, PAYLOAD_ROOM);
    let play = move |stop: &AtomicBool| camera.play(shots, &camera_end, stop);
    let log =
        live(arguments, &model, config, frames, ("simulated D435", None), play, worker_end, &mut still)?;

    let report = report::Report::new(&model, &recording, &log)?;
    let json = serde_json::to_string_pretty(&report.json(arguments))?;
    write_whole(&arguments.out.join("run.json"), format!("{json}\n").as_bytes())?;
    let drawn = view::picture(&model, &recording, &config, &log, &report.score, &still)?;
    if let Some(png) = &drawn {
        write_whole(&picture, png)?;
    }
    if arguments.json {
        println!("{json}");
    } else {
        print!("{}", report.text());
        if drawn.is_some() {
            println!("picture: {}", picture.display());
        }
    }
    if arguments.check && !report.checks.iter().all(|check| check.ok) {
        bail!("a check missed its target");
    }
    Ok(())
}

/// Whole frames in `seconds`, at least a window and a second.
fn frames(seconds: f64) -> anyhow::Result<usize> {
    if !(1.5..=3600.0).contains(&seconds) {
        bail!("--seconds {seconds} is out of range: 1.5 to 3600");
    }
    Ok((seconds / FRAME_INTERVAL_S).round() as usize)
}

/// The recording that the camera looks at.
fn recording(source: &str) -> anyhow::Result<Recording> {
    if source == "shipped" {
        return Ok(Recording::from_bytes(Path::new("the shipped recording"), meniscus_shipped::RECORDING)?);
    }
    let recording = Recording::load(Path::new(source))?;
    check_level(&recording, &source)?;
    Ok(recording)
}

/// Camera settings for the model's glass; a recording of another glass is refused.
fn settings(model: &Model<'_>, recording: &Recording) -> anyhow::Result<Settings> {
    let (header, glass) = (&model.header, &recording.glass);
    let pairs = [
        ("radius", header.radius_m, glass.radius_m),
        ("fill", header.fill_m, glass.fill_m),
        ("rim", header.rim_m, glass.rim_m),
    ];
    for (name, model_m, recording_m) in pairs {
        if (model_m - recording_m).abs() > 1e-4 {
            let (model_mm, recording_mm) = (1e3 * model_m, 1e3 * recording_m);
            bail!(
                "the model was trained for a glass with {name} {model_mm:.1} mm, the recording has \
                 {recording_mm:.1} mm: train a model for this glass, or choose another recording"
            );
        }
    }
    if model.field_len() != meniscus_data::recording::STATE {
        bail!("the model has {} tracers, recordings have 2134", model.header.particles);
    }
    Ok(Settings::for_glass(header.radius_m, header.fill_m, header.rim_m))
}
