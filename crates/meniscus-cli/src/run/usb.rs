//! `meniscus run --source usb`: a camera on a bus, real or simulated, into the same turn.

use super::BUFFERS;
use super::config::{Front, RunConfig, RunEnd};
use super::live::{Played, ReadyCamera, live};
use super::printed::{announce, print, say_position};
use super::source::{RecordingSource, Source};
use crate::glass;
use anyhow::bail;
use meniscus::blob::Model;
use meniscus::surface::Config;
use meniscus::units::Micros;
use meniscus_data::validity::Validity;
#[cfg(feature = "desk")]
use meniscus_hil::FaultList;
use meniscus_hil::device::FIRST_SHOT_US;
#[cfg(feature = "desk")]
use meniscus_hil::device::{Device, Trouble};
use meniscus_platform::realtime::{Priority, become_realtime};
use meniscus_score::baseline::linear_with_motion;
use meniscus_score::run_report::CameraReport;
use meniscus_score::score::score;
use meniscus_service::ledger::SpanEnd;
use meniscus_service::live::CameraImages;
use meniscus_service::run::RunState;
use meniscus_usb::camera::{LinkSink, Session, Settings};
use meniscus_usb::link::link;
use meniscus_usb::transport::Transport;
#[cfg(feature = "desk")]
use meniscus_virtual::render::SceneSettings;
#[cfg(feature = "desk")]
use meniscus_virtual::usb::{RecordedGlass, SimulatedBus};
use std::time::{Duration, Instant};

/// Longer than any service runs.
pub(super) const YEARS: Duration = Duration::from_secs(100 * 365 * 86_400);

/// A camera on a bus, before it is connected.
pub(super) struct BusCamera<T> {
    /// The bus.
    pub(super) transport: T,
    /// Name of the camera, for titles.
    pub(super) name: &'static str,
    /// Scheduling of its thread. A simulated camera renders in it and would starve the others in real time.
    pub(super) priority: Priority,
}

/// Returns a simulated bus with a camera before the shipped recording.
#[cfg(feature = "desk")]
pub(super) fn simulated(
    config: &RunConfig,
    trouble: Option<Trouble>,
    faults: &FaultList,
) -> anyhow::Result<SimulatedBus> {
    let mut settings = SceneSettings { seed: config.seed, ..SceneSettings::default() };
    settings.tag = super::rendered::plate(config, &settings.camera);
    if matches!(trouble, Some(Trouble::AdvancedOff | Trouble::UnitStuck)) {
        settings.camera.depth_unit_m = 1e-3;
    }
    let repeating = config.page.is_some();
    let glass = RecordedGlass::new(RecordingSource::Shipped.load()?, settings).repeating(repeating);
    let device = Device::new(Box::new(glass), trouble, faults.clone(), config.seed);
    Ok(SimulatedBus::new(device).in_real_time())
}

/// Connects the camera, then runs camera thread, worker and front end until the time is up.
pub(super) fn run(
    config: &RunConfig,
    model: &Model<'_>,
    camera: BusCamera<impl Transport + Send>,
) -> anyhow::Result<()> {
    let truth = config.truth.as_ref().map(RecordingSource::load).transpose()?;
    let outline = glass::outline(config.setup.as_deref())?.unwrap_or_default();
    let waits_for_arrival = config.front == Front::Service;
    let wanted =
        Settings { serial: config.serial.clone(), outline, waits_for_arrival, ..Settings::default() };
    let mut session = Session::connect(camera.transport, wanted)?;
    let connected = session.connected().clone();
    let settings = glass::settings(config.setup.as_deref(), &model.header, connected.optics())?;
    let reader = Config::new(settings)?;
    if config.source == Source::Usb {
        say_position(config);
    }
    let _alone = announce(config)?;

    let (camera_end, end) = link(BUFFERS, session.buffer_bytes());
    let (mut ended, mut realtime) = (Ok(()), None);
    let length = if config.end == RunEnd::WhenStopped { YEARS } else { config.length() };
    let until = Instant::now() + length;
    let Played { finished, written, notes } = {
        let (session, ended, realtime) = (&mut session, &mut ended, &mut realtime);
        let rectifier = connected.rectifier();
        let (name, frames, span_end) = (camera.name, config.frames_kept(), SpanEnd::RunsOn);
        let images = CameraImages::DepthAndOutline;
        let ready =
            ReadyCamera { name, reader, images, rectifier, frames, span_end, truth: None, end, sink: None };
        live(config, model, ready, move |state: &RunState| {
            *realtime = (camera.priority == Priority::RealTime).then(become_realtime);
            *ended = session.stream(&mut LinkSink {
                end: camera_end,
                stop: &state.stop,
                until,
                notes: &state.notes,
            });
        })?
    };
    let health = session.health();
    let log = &finished.log;
    let score = truth.map(|truth| {
        let linear = linear_with_motion(&truth);
        score(model, &truth, &linear, &log.turns, Micros(FIRST_SHOT_US))
    });
    let validity = Validity::of(&model.header);
    let report =
        CameraReport { log, camera: Some(connected), webcam: None, health, notes, realtime, score, validity };
    print(config, &report.json(&config.labels()), &report.text())?;
    // The camera's error comes after the report of what was seen until then.
    ended?;
    if log.totals.turns == 0 {
        bail!("the run ended before the first frame: there is nothing to report");
    }
    written?;
    config.judge(&report.checks())
}
