//! `meniscus run --source replay FILE`: a camera's recording into the same turn.

use super::live_report::LiveReport;
use super::{Arguments, BUFFERS, live};
use crate::glass;
use anyhow::{Context, bail};
use meniscus::blob::Model;
use meniscus::surface::Config;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_bags as bag;
use meniscus_platform::files::write_whole;
use meniscus_service::live::Still;
use meniscus_usb::camera::CameraHealth;
use meniscus_usb::link::link;
use meniscus_virtual::replay::play;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Bytes of a payload beside its pixels.
const HEADER: usize = 1024;

/// Plays the recording; there is no truth to hold the estimate against.
pub(super) fn run(
    arguments: &Arguments,
    model: &Model<'_>,
    frames: usize,
    file: &Path,
) -> anyhow::Result<()> {
    let recording = bag::open(file)?;
    let camera = recording.calibration.clone();
    glass::same_outline(glass::outline(arguments.setup.as_deref())?, file, camera.outline)?;
    let settings = glass::settings(arguments.setup.as_deref(), &model.header, camera.optics())?;
    let config = Config::new(settings).context("the recording's camera cannot see the model's glass")?;
    write_whole(&arguments.out.join("run.json"), b"{}\n").context("the --out folder cannot be used")?;
    let (width, height) = config.image_size();
    let (camera_end, worker_end) = link(BUFFERS, 2 * width * height + HEADER);
    let endless = arguments.page.view && arguments.seconds.is_none();
    let seconds = if endless { f64::INFINITY } else { frames as f64 * FRAME_INTERVAL_S };
    let (mut ended, mut still) = (Ok(0), Still::default());
    let log = {
        let ended = &mut ended;
        let play = move |stop: &AtomicBool| *ended = play(recording, seconds, &camera_end, stop);
        live(arguments, model, config, frames, (&camera.camera, None), play, worker_end, &mut still)?
    };
    let report = LiveReport {
        log: &log,
        camera: None,
        health: CameraHealth::default(),
        notes: Vec::new(),
        realtime: None,
        score: None,
    };
    let json = serde_json::to_string_pretty(&report.json(arguments)?)?;
    write_whole(&arguments.out.join("run.json"), format!("{json}\n").as_bytes())?;
    if arguments.json {
        println!("{json}");
    } else {
        print!("{}", report.text()?);
    }
    // A recording that ends too early is told behind the report of what was seen until then.
    let images = ended?;
    if log.turns.is_empty() {
        bail!("{} images were played and led to no turn: there is nothing to report", images);
    }
    if arguments.check && !report.checks()?.iter().all(|check| check.ok) {
        bail!("a check missed its target");
    }
    Ok(())
}
