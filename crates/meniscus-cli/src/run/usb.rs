//! `meniscus run --source usb`: a camera on a bus, real or simulated, into the same turn.

use super::live_report::LiveReport;
use super::{Arguments, BUFFERS, live, recording};
use crate::{bus, glass};
use anyhow::{Context, bail};
use meniscus::blob::Model;
use meniscus::surface::Config;
use meniscus::units::{FRAME_INTERVAL_S, Micros};
use meniscus_hil::device::{Device, FIRST_SHOT_US, Trouble};
use meniscus_platform::files::write_whole;
use meniscus_platform::realtime::become_realtime;
use meniscus_score::baseline::linear_with_motion;
use meniscus_score::score::score;
use meniscus_service::live::Still;
use meniscus_usb::camera::{LinkSink, Session, Settings};
use meniscus_usb::link::link;
use meniscus_usb::transport::Transport;
use meniscus_virtual::render::SceneSettings;
use meniscus_virtual::usb::{RecordedGlass, SimulatedBus};
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// Longer than any service runs.
const YEARS: Duration = Duration::from_secs(100 * 365 * 86_400);

/// A source that is a bus.
pub(super) enum Bus<'a> {
    /// The machine's own.
    Machine,
    /// A simulated one, with a trouble by name, or none.
    Simulated(&'a str),
}

/// The bus that a source names, if it names one.
pub(super) fn bus_of(source: &str) -> Option<Bus<'_>> {
    match source.split_once(':').unwrap_or((source, "")) {
        ("usb", "") => Some(Bus::Machine),
        ("simulated-usb", trouble) => Some(Bus::Simulated(trouble)),
        _ => None,
    }
}

/// Runs with a camera on a bus.
pub(super) fn run(
    arguments: &Arguments,
    model: &Model<'_>,
    frames: usize,
    on: Bus<'_>,
) -> anyhow::Result<()> {
    match on {
        Bus::Machine => watch(arguments, model, frames, bus::machine()?, "D435", true),
        Bus::Simulated(name) => {
            let bus = simulated(arguments, bus::trouble(name)?)?;
            watch(arguments, model, frames, bus, "simulated D435 over USB", false)
        }
    }
}

/// A simulated camera before the shipped recording.
fn simulated(arguments: &Arguments, trouble: Option<Trouble>) -> anyhow::Result<SimulatedBus> {
    let mut settings = SceneSettings { seed: arguments.seed, ..SceneSettings::default() };
    if matches!(trouble, Some(Trouble::AdvancedOff | Trouble::UnitStuck)) {
        settings.camera.depth_unit_m = 1e-3;
    }
    let glass = RecordedGlass::new(recording("shipped")?, settings).repeating(arguments.page.view);
    let device = Device::new(Box::new(glass), trouble, arguments.faults.clone(), arguments.seed);
    Ok(SimulatedBus::new(device).in_real_time())
}

/// Connects, then camera thread, worker and dashboard until the time is up.
fn watch(
    arguments: &Arguments,
    model: &Model<'_>,
    frames: usize,
    transport: impl Transport + Send,
    camera: &str,
    realtime_wanted: bool,
) -> anyhow::Result<()> {
    let truth = arguments.truth.as_deref().map(recording).transpose()?;
    let outline = glass::outline(arguments.setup.as_deref())?.unwrap_or_default();
    let wanted = Settings { serial: arguments.serial.clone(), outline, ..Settings::default() };
    let mut session = Session::connect(transport, wanted)?;
    let connected = session.connected().clone();
    let settings = glass::settings(arguments.setup.as_deref(), &model.header, connected.optics())?;
    let config = Config::new(settings)?;
    let rectifier = connected.rectifier();
    write_whole(&arguments.out.join("run.json"), b"{}\n").context("the --out folder cannot be used")?;

    let (camera_end, worker_end) = link(BUFFERS, session.buffer_bytes());
    let notes = Mutex::new(Vec::with_capacity(LinkSink::NOTES));
    let (mut ended, mut realtime) = (Ok(()), None);
    let mut still = Still::default();
    // A service ends when it is stopped, as a page does; the log has room for the first turns and counts the rest.
    let endless = arguments.service || (arguments.page.view && arguments.seconds.is_none());
    let length = if endless { YEARS } else { Duration::from_secs_f64(frames as f64 * FRAME_INTERVAL_S) };
    let until = Instant::now() + length;
    let log = {
        let (session, notes, ended, realtime) = (&mut session, &notes, &mut ended, &mut realtime);
        let play = move |stop: &AtomicBool| {
            // A simulated camera renders in this thread and would starve the others.
            *realtime = realtime_wanted.then(become_realtime);
            *ended = session.stream(&mut LinkSink { end: camera_end, stop, until, notes });
        };
        live(arguments, model, config, frames, (camera, rectifier), play, worker_end, &mut still)?
    };
    let health = session.health();
    let notes = notes.into_inner().unwrap_or_default();
    let score = truth.map(|truth| {
        let linear = linear_with_motion(&truth);
        score(model, &truth, &linear, &log.turns, Micros(FIRST_SHOT_US))
    });
    let report = LiveReport { log: &log, camera: Some(connected), health, notes, realtime, score };
    let json = serde_json::to_string_pretty(&report.json(arguments)?)?;
    write_whole(&arguments.out.join("run.json"), format!("{json}\n").as_bytes())?;
    if arguments.json {
        println!("{json}");
    } else {
        print!("{}", report.text()?);
    }
    // The camera's end is told behind the report of what was seen until then.
    ended?;
    if log.turns.is_empty() {
        bail!("the run ended before the first frame: there is nothing to report");
    }
    if arguments.check && !report.checks()?.iter().all(|check| check.ok) {
        bail!("a check missed its target");
    }
    Ok(())
}
