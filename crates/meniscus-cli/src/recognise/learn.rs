//! `meniscus recognise learn`: learning of a liquid from recordings.

use super::Noise;
use crate::filmed::{Sightings, all_filmed, by_camera, setup};
use crate::inputs::{files, level, recordings};
use crate::outputs::Force;
use anyhow::ensure;
use meniscus_discover::identify::{learn, render_profiles};
use meniscus_platform::files::write_whole;
use meniscus_report::checks::{Check, table};
use meniscus_service::identify::{GlassSize, Note};
use serde_json::json;
use std::path::PathBuf;

/// Learn a liquid from two recordings of it or more.
///
/// Six numbers of its first mode are fitted to the surface in all recordings: frequency, three parts of the decay, softening,
/// lever. Their error comes from fits that leave out one recording each. Two recordings show little of how recordings differ;
/// four are better, some of them with large waves.
///
/// A camera's recordings (.mcap, .bag, .db3, or a folder) need --setup.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus simulate --liquid beer --motion strokes:1x0.25 \\\n    --motion strokes:2x0.25 --motion strokes:3x0.25 --seconds 4 --out beer\n  meniscus recognise learn --recordings beer --out liquids/beer.liquid.json\n  meniscus recognise learn --recordings one.mcap two.mcap three.mcap \\\n    --setup glass.toml --out liquids/mine.liquid.json"
)]
pub(super) struct Arguments {
    /// Recordings of the liquid: files, or a folder for all of its *.safetensors.
    #[arg(long, required = true, num_args = 1.., value_name = "FILES", help_heading = "Input")]
    recordings: Vec<PathBuf>,
    /// Glass and camera position, as `meniscus setup` wrote them, for a camera's recordings.
    #[arg(long, value_name = "FILE.toml", help_heading = "Input")]
    setup: Option<PathBuf>,
    /// Name of the liquid [default: that of the recordings, or of the note].
    #[arg(long, value_name = "NAME", help_heading = "Input")]
    liquid: Option<String>,
    #[command(flatten)]
    noise: Noise,
    /// Note to write, NAME.liquid.json.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    out: PathBuf,
    #[command(flatten)]
    force: Force,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Recordings that a liquid is learnt from.
struct Lesson {
    liquid: String,
    /// Inner radius, and height of the liquid at rest, m.
    glass: (f64, f64),
    motions: Vec<String>,
    seen: Vec<Sightings>,
}

/// Reads recordings of the simulator through their camera.
fn simulated(arguments: &Arguments) -> anyhow::Result<Lesson> {
    let all = recordings(&arguments.recordings, "", level)?;
    let Some(first) = all.first() else { anyhow::bail!("no recording is given") };
    let mut seen = Vec::new();
    for (own_seed, recording) in (arguments.noise.seed..).zip(&all) {
        let own = &recording.provenance.liquid;
        ensure!(
            *own == first.provenance.liquid,
            "the recordings are of {} and of {own}: one liquid makes one note",
            first.provenance.liquid
        );
        ensure!(
            recording.glass == first.glass,
            "the recordings are of different glasses: one note is of one"
        );
        seen.push(render_profiles(recording, arguments.noise.noise_px, own_seed)?);
    }
    Ok(Lesson {
        liquid: first.provenance.liquid.clone(),
        glass: (first.glass.radius_m, first.glass.fill_m),
        motions: all.iter().map(|recording| recording.provenance.motion.clone()).collect(),
        seen,
    })
}

/// Reads a camera's recordings of the liquid `name`; their files stand for their motions.
fn filmed(arguments: &Arguments, name: &str) -> anyhow::Result<Lesson> {
    let setup = setup(arguments.setup.as_ref())?;
    let look = |path: &PathBuf| {
        by_camera(path, Some(setup.view.outline), |camera| Ok(setup.settings(camera.optics())))
    };
    let file = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Lesson {
        liquid: name.into(),
        glass: (1e-3 * setup.glass.radius_mm, 1e-3 * setup.glass.fill_mm),
        motions: arguments.recordings.iter().map(file).collect(),
        seen: arguments.recordings.iter().map(look).collect::<anyhow::Result<_>>()?,
    })
}

/// Runs the verb.
pub(super) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    arguments.noise.check()?;
    let Noise { noise_px, seed } = arguments.noise;
    let name = arguments.out.file_name().unwrap_or_default().to_string_lossy();
    ensure!(
        name.ends_with(".liquid.json"),
        "--out {name} must end with .liquid.json, so that --among finds it"
    );
    arguments.force.check(&arguments.out)?;
    let lesson = if all_filmed(&arguments.recordings)? {
        filmed(arguments, name.trim_end_matches(".liquid.json"))?
    } else {
        ensure!(
            arguments.setup.is_none(),
            "--setup is for a camera's recordings, and these are the simulator's"
        );
        // Before they are read, which takes seconds.
        let named = files(&arguments.recordings, "")?;
        let all_there = named.iter().all(|file| file.exists());
        ensure!(
            named.len() > 1 || !all_there,
            "1 recording cannot say how much recordings of the liquid differ: give two or more, better four"
        );
        simulated(arguments)?
    };
    let Lesson { liquid, glass, motions, seen } = lesson;
    let liquid = arguments.liquid.clone().unwrap_or(liquid);
    let parts: Vec<&[_]> = seen.iter().map(|seen| &seen[..]).collect();
    let known = learn(&parts, glass)?;
    let command = format!("meniscus recognise learn --noise-px {noise_px} --seed {seed}");
    let (radius_m, fill_m) = glass;
    let note = Note::new(&liquid, GlassSize { radius_m, fill_m }, known, motions, &command);
    write_whole(&arguments.out, format!("{:#}\n", json!(note)).as_bytes())?;
    let tone = &known.tone;
    let checks = [
        Check::informational("frequency", tone.frequency / std::f64::consts::TAU, "Hz"),
        Check::informational("decay", tone.decay, "1/s"),
        Check::informational("decay_of_yielding", tone.yielding, "1/s"),
        Check::informational("decay_at_10_mm", tone.breaking, "1/s"),
        Check::informational("softening_at_10_mm", tone.softening, "1"),
        Check::informational("lever", tone.lever, "1"),
        Check::informational("miss_of_the_wave", known.calibration.scale, "1"),
        Check::informational("miss_scatter", known.calibration.scatter, "1"),
        Check::informational("numbers_a_frame", known.calibration.numbers, "1"),
    ];
    if arguments.json {
        println!("{:#}", json!({ "note": arguments.out, "liquid": liquid, "checks": checks }));
    } else {
        println!("{liquid}, from {} recordings", seen.len());
        print!("{}", table(&checks));
        println!("written: {}", arguments.out.display());
    }
    Ok(())
}
