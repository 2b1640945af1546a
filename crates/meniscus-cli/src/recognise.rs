//! `meniscus recognise`: identification of the liquid, and learning of a new one.

mod learn;

use super::among::among;
use super::filmed::{Sightings, all_filmed, by_camera, setup};
use super::inputs::level;
use anyhow::{Context, ensure};
use meniscus_discover::identify::{picture, recognise, render_profiles};
use meniscus_platform::files::check_writable;
use meniscus_service::identify::{GlassSize, Note, Standing};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Identify the liquid of a recording among known ones.
///
/// Each known liquid gets a probability, and so does "none of these". A known liquid is an oscillator with six numbers of its own,
/// driven by the tracked motion of the glass. The one that predicts the surface best is reported. If none predicts it as well as
/// its own recordings, none is.
///
/// Recordings of the simulator are seen through the simulated camera. A camera's recordings (.mcap, .bag, .db3, or a folder with
/// frames.csv) need --setup. `meniscus run --among` does the same beside a live camera.
///
/// The program knows blood, butter, gazpacho, glycerine, honey and water, as simulated, in the glass of the recordings. `meniscus
/// recognise learn` adds any liquid from two recordings of it or more. Beer is taken for water: their decays differ by less than
/// those of two recordings of one liquid.
#[derive(clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Examples:\n  meniscus recognise recordings/glycerine-unseen.safetensors\n  meniscus recognise strokes-1.safetensors --picture liquid.png\n  meniscus recognise one.mcap --setup glass.toml --among liquids\n  meniscus recognise learn --recordings mine --out liquids/mine.liquid.json\n  meniscus recognise try.safetensors --among liquids --among shipped"
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    verb: Option<Verb>,
    #[command(flatten)]
    asked: Asked,
}

#[derive(clap::Subcommand)]
enum Verb {
    Learn(learn::Arguments),
}

// No documentation here: clap would take it for that of the verb.
#[derive(clap::Args)]
struct Asked {
    /// Recordings, all of the simulator or all of a camera.
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    /// Glass and camera position, as `meniscus setup` wrote them, for a camera's recordings.
    #[arg(long, value_name = "FILE.toml", help_heading = "Input")]
    setup: Option<PathBuf>,
    /// Known liquids: shipped, a note, or a folder of notes; may be repeated.
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE|DIR", help_heading = "Input")]
    among: Vec<String>,
    #[command(flatten)]
    noise: Noise,
    /// Draw predictions of the last recording, and probabilities over time.
    #[arg(long, value_name = "FILE.png", help_heading = "Output")]
    picture: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    match &arguments.verb {
        Some(Verb::Learn(arguments)) => learn::run(arguments),
        None => ask(&arguments.asked),
    }
}

// No documentation here either.
#[derive(clap::Args)]
struct Noise {
    /// Noise of the simulated camera's disparity, pixels rms, 0 to 5.
    ///
    /// 0.08 is a D435, 0.24 makes 2 mm of depth at 0.4 m.
    #[arg(long, default_value_t = 0.08, value_name = "PX", help_heading = "Input")]
    noise_px: f64,
    /// Seed of that noise.
    #[arg(long, default_value_t = 1, help_heading = "Input")]
    seed: u64,
}

impl Noise {
    /// Refuses what no camera has.
    fn check(&self) -> anyhow::Result<()> {
        let noise_px = self.noise_px;
        ensure!((0.0..=5.0).contains(&noise_px), "--noise-px {noise_px} is out of range: 0 to 5");
        Ok(())
    }
}

/// Recording whose liquid is to be identified.
struct Question {
    /// Profiles, frame by frame.
    seen: Sightings,
    /// Height of the liquid at rest, m.
    fill_m: f64,
    /// Known liquids.
    notes: Vec<Note>,
}

/// Reads a recording of the simulator through its camera.
fn simulated(path: &Path, asked: &Asked) -> anyhow::Result<Question> {
    let recording = level(path)?;
    let glass = &recording.glass;
    let notes = among(&asked.among, GlassSize { radius_m: glass.radius_m, fill_m: glass.fill_m })?;
    let seen = render_profiles(&recording, asked.noise.noise_px, asked.noise.seed)
        .with_context(|| format!("{} cannot be looked at", path.display()))?;
    Ok(Question { seen, fill_m: glass.fill_m, notes })
}

/// Reads a camera's own recording.
fn filmed(path: &Path, asked: &Asked) -> anyhow::Result<Question> {
    let setup = setup(asked.setup.as_ref())?;
    let (radius_m, fill_m) = (1e-3 * setup.glass.radius_mm, 1e-3 * setup.glass.fill_mm);
    let notes = among(&asked.among, GlassSize { radius_m, fill_m })?;
    let seen = by_camera(path, Some(setup.view.outline), |camera| Ok(setup.settings(camera.optics())))?;
    Ok(Question { seen, fill_m, notes })
}

fn ask(asked: &Asked) -> anyhow::Result<()> {
    asked.noise.check()?;
    asked.picture.as_deref().map_or(Ok(()), check_writable)?;
    let by_camera = all_filmed(&asked.recordings)?;
    ensure!(
        by_camera || asked.setup.is_none(),
        "--setup is for a camera's recordings, and these are the simulator's"
    );
    let mut said: Vec<(String, Standing)> = Vec::new();
    for (which, path) in asked.recordings.iter().enumerate() {
        let question = if by_camera { filmed(path, asked) } else { simulated(path, asked) };
        let Question { seen, fill_m, notes } = question?;
        let drawn = asked.picture.as_ref().filter(|_| which + 1 == asked.recordings.len());
        let standing = match drawn {
            None => recognise(&notes, fill_m, &seen, |_, _, _| {}),
            Some(file) => {
                let title = path.file_name().unwrap_or_default().to_string_lossy();
                picture(&notes, fill_m, &seen, &title, file)?
            }
        };
        said.push((path.display().to_string(), standing));
    }
    if asked.json {
        let all: Vec<_> =
            said.iter().map(|(path, standing)| json!({ "recording": path, "said": standing })).collect();
        println!("{:#}", json!({ "command": "meniscus recognise", "recordings": all }));
        return Ok(());
    }
    for (path, standing) in &said {
        println!("{path}: {}", standing.line());
    }
    if let Some(file) = &asked.picture {
        println!("picture: {}", file.display());
    }
    Ok(())
}
