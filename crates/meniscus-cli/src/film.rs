//! `meniscus camera film`: what the simulated camera will show in the rig, and the same run in process.

use super::inputs::file;
use anyhow::{Context, ensure};
use meniscus::blob::Model;
use meniscus::units::Micros;
use meniscus_data::recording::Recording;
use meniscus_hil::device::FIRST_SHOT_US;
use meniscus_platform::files::check_writable;
use meniscus_score::baseline::linear_with_motion;
use meniscus_score::score::score;
use meniscus_virtual::render::SceneSettings;
use meniscus_virtual::usb::film;
use serde_json::{Value, json};
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Write the simulated camera's images for the rig, and score them.
///
/// The film holds images of 640x480 one after the other, Z16 depth then Y8 infrared: 921600 bytes a frame. The same frames go
/// through the camera's session on a simulated bus in virtual time. `hil/run` compares the rig's errors with the ones of this run.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus camera film --frames 600 --out film.raw --json\n  meniscus camera film --motion tag:7,40 --out tag.raw"
)]
pub(crate) struct Film {
    /// Recording in the program (shipped) or a recording file.
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE", help_heading = "Input")]
    source: String,
    /// Frames from the beginning of the recording, 30 to 36000.
    #[arg(
        long,
        default_value_t = 600,
        value_parser = clap::value_parser!(u32).range(30..=36_000),
        help_heading = "Input"
    )]
    frames: u32,
    /// Draw an AprilTag above the glass, as `run` looks for it.
    #[arg(long, value_name = "tag:ID,SIZE_MM", help_heading = "Input")]
    motion: Option<String>,
    /// Film to write; an old one is replaced.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    out: PathBuf,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Film) -> anyhow::Result<()> {
    let recording = match arguments.source.as_str() {
        "shipped" => Recording::from_bytes(Path::new("the shipped recording"), meniscus_shipped::RECORDING)?,
        path => super::inputs::recording(Path::new(path))?,
    };
    let frames = arguments.frames as usize;
    ensure!(
        frames <= recording.frames(),
        "--frames {frames}: {} has {} frames",
        arguments.source,
        recording.frames()
    );
    let bytes = file("shipped")?;
    let model = Model::load(&bytes).context("the model is refused")?;
    let mut scene = SceneSettings::default();
    if let Some(motion) = &arguments.motion {
        let tag = motion.strip_prefix("tag:");
        let tag = tag.with_context(|| format!("--motion {motion}: expected tag:ID,SIZE_MM, as tag:7,40"))?;
        scene.tag = super::run::plate_with(tag, scene.camera.rim_m)?;
    }
    let out = &arguments.out;
    // Beside it and renamed: a film that is there is a whole one.
    let beside = out.with_extension("part");
    check_writable(out)?;
    let file = File::create(&beside).with_context(|| format!("cannot write {}", beside.display()))?;
    let filmed = film(&model, recording.clone(), scene, frames, BufWriter::new(file));
    let kept = filmed.map_err(anyhow::Error::from).and_then(|(turns, mut file)| {
        file.flush().and_then(|()| fs::rename(&beside, out))?;
        Ok(turns)
    });
    if kept.is_err() {
        // A part of a film helps nobody; that it cannot be removed either adds nothing.
        let _left = fs::remove_file(&beside);
    }
    let turns = kept.context("the film cannot be written")?;
    let linear = linear_with_motion(&recording);
    let score = score(&model, &recording, &linear, &turns, Micros(FIRST_SHOT_US));
    let fields: Value = score.known_field().map(|one| (one.name.to_owned(), json!(one.error))).collect();
    let report = json!({
        "command": "meniscus camera film",
        "version": env!("CARGO_PKG_VERSION"),
        "frames": frames,
        "frames_scored": score.frames,
        "slosh_rel": score.estimate.slosh_rel(),
        "field_error": fields,
    });
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        let percent = 100.0 * score.estimate.slosh_rel();
        println!("{}: {frames} frames, slosh-relative error of the surface {percent:.1} %", out.display());
    }
    Ok(())
}
