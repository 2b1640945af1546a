//! `meniscus camera`: the camera's side held against the truth.

use anyhow::Context;
use meniscus_platform::files::write_whole;
use meniscus_virtual::camera_study as study;
use meniscus_virtual::camera_study::{Material, SEED, errors_png, faults, report, scenes_png};
use serde_json::json;
use std::path::PathBuf;

/// Study the surface reader and the camera's faults.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(clap::Subcommand)]
enum Verb {
    Study(Study),
    Film(super::film::Film),
}

/// Compare the measured surface with the truth in rendered scenes.
///
/// The scenes: looks of five liquids, three distances from 0.3 to 0.6 m, camera tilts up to 15 degrees, the D435's noise and twice
/// that, up to 30 % of holes, foam, glare, a finger before the glass, and scenes without liquid, in which no profile may come out.
/// The stated interval of a point must hold 95 % of them.
///
/// Then every line of the fault table goes through the camera session in virtual time, the depth filters are compared with frames
/// of the reference library, and two stages are timed. These scenes have no refraction by the glass and no meniscus on its wall.
///
/// Path-traced glasses that nobody looked at while the reader was written have both: dark, bright and clear liquids, walls of 1 to 4
/// mm, wrong borders of the depth image, dots, too much light, and empty glasses.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  meniscus camera study\n  meniscus camera study --scenes 40 --json")]
struct Study {
    /// Number of scenes, 20 to 100000.
    #[arg(
        long,
        default_value_t = 200,
        value_parser = clap::value_parser!(u32).range(20..=100_000),
        help_heading = "Method"
    )]
    scenes: u32,
    /// Seed of the scenes; the intervals were calibrated on others.
    #[arg(long, default_value_t = SEED, help_heading = "Method")]
    seed: u64,
    /// Folder of the filters' reference frames (manifest.json, frames.npz) [default: the repository's].
    #[arg(long, value_name = "DIR", help_heading = "Method")]
    reference: Option<PathBuf>,
    /// Folder of the path-traced scenes (truth.json and images) [default: the repository's].
    #[arg(long, value_name = "DIR", help_heading = "Method")]
    traced: Option<PathBuf>,
    /// Folder for study.html, study.md, errors.png and scenes.png; it is made.
    #[arg(long, default_value = "out/camera", value_name = "DIR", help_heading = "Output")]
    out: PathBuf,
    /// Print one JSON object instead of the table.
    #[arg(long, help_heading = "Output")]
    json: bool,
    /// Exit with status 1 if a check misses its target.
    #[arg(long, help_heading = "Output")]
    check: bool,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    match &arguments.verb {
        Verb::Study(study) => study_camera(study),
        Verb::Film(film) => super::film::run(film),
    }
}

fn study_camera(arguments: &Study) -> anyhow::Result<()> {
    let Study { scenes, seed, out, reference, traced, json, check } = arguments;
    let page = out.join("study.md");
    // Reported before the work, not after it.
    write_whole(&page, b"\n").context("the --out folder cannot be used")?;
    let bar = crate::bars::bar(u64::from(*scenes) + (faults::TABLE.len() * faults::HABITS.len()) as u64);
    bar.set_style(crate::bars::style("scenes and faults {wide_bar} {pos}/{len}, {left}")?);
    let material = Material { reference: reference.as_deref(), traced: traced.as_deref() };
    let outcome = study::study(*seed, *scenes as usize, material, || bar.inc(1))?;
    bar.finish_and_clear();
    let command = format!("meniscus camera study --scenes {scenes} --seed {seed}");
    let report = report(&outcome, &command)?;
    write_whole(&page, report.markdown().as_bytes())?;
    write_whole(&out.join("study.html"), report.html().as_bytes())?;
    errors_png(&outcome.scenes, &out.join("errors.png"))?;
    scenes_png(&outcome.scenes, &out.join("scenes.png"))?;
    let not_compared: Vec<&String> =
        outcome.golden.as_ref().err().into_iter().chain(&outcome.traced_missing).collect();
    if *json {
        let object = json!({
            "command": "meniscus camera study",
            "version": env!("CARGO_PKG_VERSION"),
            "scenes": scenes,
            "seed": seed,
            "rows": outcome.rows,
            "golden_not_covered": not_compared,
            "faults_unrecovered": outcome.unrecovered,
            "checks": outcome.checks,
        });
        println!("{}", serde_json::to_string_pretty(&object)?);
    } else {
        println!("{}", report.text());
        not_compared.iter().for_each(|why| println!("not compared: {why}"));
        println!("written: {}, the same as study.html, and two pictures beside it", page.display());
    }
    if *check && outcome.checks.iter().any(|check| check.missed()) {
        anyhow::bail!("a check missed its target");
    }
    Ok(())
}
