//! `meniscus run --source v4l:DEVICE`: a colour webcam, or a folder of images, into the same turn, without depth.

use super::BUFFERS;
use super::config::{RunConfig, RunEnd};
use super::live::{Played, ReadyCamera, live};
use super::printed::{announce, print};
use super::usb::YEARS;
use crate::glass;
use crate::webcam::{Eye, setup};
use anyhow::{bail, ensure};
use meniscus::blob::Model;
use meniscus::surface::Config;
use meniscus_data::validity::Validity;
use meniscus_platform::realtime::become_realtime;
use meniscus_score::run_report::CameraReport;
use meniscus_service::ledger::SpanEnd;
use meniscus_service::live::CameraImages;
use meniscus_service::run::RunState;
use meniscus_service::setup::StatedLens;
use meniscus_usb::camera::LinkSink;
use meniscus_usb::link::link;
use meniscus_webcam::{Machine, Pictures, Session, Video};
use std::path::Path;
use std::time::Instant;

/// Runs before a camera without depth.
pub(super) fn run(config: &RunConfig, model: &Model<'_>, eye: &Eye) -> anyhow::Result<()> {
    let (_, lens) = setup(config.setup.as_deref())?;
    match eye {
        Eye::Device(path) => watch(
            config,
            model,
            lens,
            Camera { video: Machine::new(path.into()), path, span_end: SpanEnd::RunsOn },
        ),
        Eye::Pictures(path) => watch(
            config,
            model,
            lens,
            Camera { video: Pictures::open(path)?, path, span_end: SpanEnd::LastFrame },
        ),
    }
}

/// A camera without depth, before it is connected.
struct Camera<'p, V> {
    video: V,
    path: &'p Path,
    /// End of what it takes.
    span_end: SpanEnd,
}

/// Opens the camera, then runs camera thread, worker and front end until the time is up.
fn watch(
    config: &RunConfig,
    model: &Model<'_>,
    lens: StatedLens,
    camera: Camera<'_, impl Video + Send>,
) -> anyhow::Result<()> {
    let Camera { video, path: device, span_end } = camera;
    let mut session = Session::connect(video, &device.display().to_string())?;
    let camera = session.webcam().clone();
    let [width, height] = lens.size;
    ensure!(
        lens.size == camera.mode.size,
        "the lens of the setup is that of images of {width}x{height}, and {} brings {}: run `meniscus setup` before this camera",
        device.display(),
        camera.mode
    );
    let settings = glass::settings(config.setup.as_deref(), &model.header, lens.optics())?;
    let reader = Config::new(settings)?;
    let _alone = announce(config)?;

    let (camera_end, end) = link(BUFFERS, session.buffer_bytes());
    let (mut ended, mut realtime) = (Ok(()), None);
    let length = if config.end == RunEnd::WhenStopped { YEARS } else { config.length() };
    let until = Instant::now() + length;
    let Played { finished, written, notes } = {
        let (session, ended, realtime) = (&mut session, &mut ended, &mut realtime);
        let (rectifier, images) = (Some(lens.rectifier()), CameraImages::OutlineAlone);
        let (name, frames) = (camera.name.as_str(), config.frames_kept());
        let ready =
            ReadyCamera { name, reader, images, rectifier, frames, span_end, truth: None, end, sink: None };
        live(config, model, ready, move |state: &RunState| {
            *realtime = Some(become_realtime());
            *ended = session.stream(&mut LinkSink {
                end: camera_end,
                stop: &state.stop,
                until,
                notes: &state.notes,
            });
        })?
    };
    let report = CameraReport {
        log: &finished.log,
        camera: None,
        webcam: Some(camera.line()),
        health: session.health(),
        notes,
        realtime,
        score: None,
        validity: Validity::of(&model.header),
    };
    print(config, &report.json(&config.labels()), &report.text())?;
    // The camera's error comes after the report of what was seen until then.
    ended?;
    if finished.log.totals.turns == 0 {
        bail!("the run ended before the first frame: there is nothing to report");
    }
    written?;
    config.judge(&report.checks())
}
