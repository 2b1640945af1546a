//! `meniscus run --source replay FILE`: a camera's recording into the same turn.

use super::BUFFERS;
use super::config::{RunConfig, RunEnd};
use super::live::{Played, ReadyCamera, live};
use super::printed::{announce, print, say_position};
use crate::glass;
use anyhow::{Context, ensure};
use meniscus::blob::Model;
use meniscus::surface::Config;
use meniscus_bags as bag;
use meniscus_bags::{PlayedImages, play};
use meniscus_data::validity::Validity;
use meniscus_score::run_report::CameraReport;
use meniscus_service::ledger::SpanEnd;
use meniscus_service::live::CameraImages;
use meniscus_service::run::RunState;
use meniscus_usb::camera::CameraHealth;
use meniscus_usb::link::link;
use std::path::Path;

/// Fewer images a second are said, Hz: three of four of the camera's 60.
const SLOW_HZ: f64 = 45.0;

/// Bytes of a payload beside its pixels.
const HEADER: usize = 1024;

/// Plays the recording; there is no truth beside the estimate.
pub(super) fn run(config: &RunConfig, model: &Model<'_>, file: &Path) -> anyhow::Result<()> {
    let recording = bag::open(file)?;
    let camera = recording.calibration.clone();
    glass::same_outline(glass::outline(config.setup.as_deref())?, file, camera.outline)?;
    let settings = glass::settings(config.setup.as_deref(), &model.header, camera.optics())?;
    let reader = Config::new(settings).context("the recording's camera cannot see the model's glass")?;
    say_position(config);
    let _alone = announce(config)?;
    let (width, height) = reader.image_size();
    let (camera_end, end) = link(BUFFERS, 2 * width * height + HEADER);
    let seconds = match config.end {
        RunEnd::WhenStopped => f64::INFINITY,
        RunEnd::AfterFrames => config.length().as_secs_f64(),
    };
    let mut ended = Ok(PlayedImages::default());
    let Played { finished, written, notes } = {
        let ended = &mut ended;
        let (name, frames, span_end) = (camera.camera.as_str(), config.frames_kept(), SpanEnd::LastFrame);
        let images = CameraImages::DepthAndOutline;
        let ready = ReadyCamera {
            name,
            reader,
            images,
            rectifier: None,
            frames,
            span_end,
            truth: None,
            end,
            sink: None,
        };
        live(config, model, ready, move |state: &RunState| {
            *ended = play(recording, seconds, &camera_end, &state.stop);
        })?
    };
    let report = CameraReport {
        log: &finished.log,
        camera: None,
        webcam: None,
        health: CameraHealth::default(),
        notes,
        realtime: None,
        score: None,
        validity: Validity::of(&model.header),
    };
    print(config, &report.json(&config.labels()), &report.text())?;
    // A recording that ends too early fails only after the report of what was seen until then.
    let PlayedImages { images, rate_hz } = ended?;
    if let Some(rate_hz) = rate_hz.filter(|rate_hz| *rate_hz < SLOW_HZ) {
        eprintln!(
            "the recording has {rate_hz:.0} depth images a second, and the model's step is a sixtieth: in the turns between \
             them it predicts"
        );
    }
    ensure!(
        finished.log.totals.turns > 0,
        "{images} images were played and led to no turn: there is nothing to report"
    );
    written?;
    config.judge(&report.checks())
}
