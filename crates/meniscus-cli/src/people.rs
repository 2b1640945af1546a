//! `meniscus people`: what those who watch cost.

mod clean_clone;
mod recognition;

use super::inputs;
use anyhow::ensure;
use indicatif::{ProgressBar, ProgressStyle};
use meniscus::blob::Model;
use meniscus::surface::{Config, Settings};
use meniscus_data::recording::Recording;
use meniscus_report::checks::{Check, table};
use meniscus_timing::viewers::{ViewerPlan, study};
use meniscus_virtual::render::SceneSettings;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Look into what people see of a run.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(clap::Subcommand)]
enum Verb {
    Study(Study),
}

/// Measure what viewers of the live page cost the turn, and what travels to each.
///
/// The main job runs in real time, round after round of the shipped recording (12 s each), in every second pair of
/// rounds with viewers in this same process, which take every frame that they can get. The turn's median must
/// not change by more than 2 %, and no viewer may need more than 2 Mbit/s. A busy machine makes the first a
/// matter of chance: the rounds are in `rounds_change`.
///
/// With --recognition the question is another one: how often `meniscus run --among` names the right liquid, over
/// recordings that nothing was learnt from. With --clean-clone it is how long a newcomer waits from `git clone` to a liquid
/// that moves on the page, the build included; crates are fetched before, which is not counted.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "Examples:\n  meniscus people study\n  meniscus people study --rounds 16 --json\n  meniscus people study --recognition unseen --json\n  meniscus people study --clean-clone ."
)]
struct Study {
    /// Rounds, half of them with viewers.
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u16).range(2..=200))]
    rounds: u16,
    /// Viewers at a time.
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u16).range(1..=16))]
    viewers: u16,
    /// Measure instead how often the right liquid is named, over the recordings DIR/LIQUID/*.safetensors; those of liquids
    /// that are not known are to be refused.
    #[arg(long, value_name = "DIR")]
    recognition: Option<PathBuf>,
    /// Measure instead the time from a clean clone of this repository (a folder or an address) to a moving liquid: about
    /// 1 GB in the temporary folder, and some minutes of all cores.
    #[arg(long, value_name = "REPOSITORY", conflicts_with = "recognition")]
    clean_clone: Option<PathBuf>,
    /// Known liquids, with --recognition: those in the program (shipped), a note, or a folder of notes; may be repeated.
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE|DIR", requires = "recognition")]
    among: Vec<String>,
    /// One JSON object on standard output instead of the table.
    #[arg(long)]
    json: bool,
    /// Fail (exit status 1) if any check misses its target.
    #[arg(long)]
    check: bool,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let Verb::Study(Study { rounds, viewers, recognition, clean_clone, among, json, check }) =
        &arguments.verb;
    if let Some(from) = clean_clone {
        let checks = clean_clone::measure(from)?.checks();
        let report = json!({
            "command": "meniscus people study --clean-clone",
            "version": env!("CARGO_PKG_VERSION"),
            "checks": checks,
        });
        return told(&report, &checks, *json, *check);
    }
    if let Some(folder) = recognition {
        let study = recognition::measure(folder, among, *json)?;
        if !json {
            print!("{}", recognition::text(&study));
        }
        return told(&recognition::json(&study), &study.checks(), *json, *check);
    }
    let bytes = inputs::file("shipped")?;
    let model = Model::load(&bytes)?;
    let recording = Recording::from_bytes(Path::new("the shipped recording"), meniscus_shipped::RECORDING)?;
    let header = &model.header;
    let settings = Settings::for_glass(header.radius_m, header.fill_m, header.rim_m);
    let scene = SceneSettings { camera: settings, ..SceneSettings::default() };
    let pairs = usize::from(rounds.div_ceil(2));
    let bar = ProgressBar::new(2 * pairs as u64);
    bar.set_style(ProgressStyle::with_template("rounds {wide_bar} {pos}/{len}, {eta} left")?);
    let plan = ViewerPlan { pairs, viewers: usize::from(*viewers) };
    let measured = study(&model, &recording, scene, Config::new(settings)?, plan, || bar.inc(1))?;
    bar.finish_and_clear();
    let checks = measured.checks();
    let report = json!({
        "command": "meniscus people study",
        "version": env!("CARGO_PKG_VERSION"),
        "viewers": viewers,
        "rounds": 2 * pairs,
        "rounds_change": measured.changes,
        "checks": checks,
    });
    told(&report, &checks, *json, *check)
}

/// Prints a study, and fails if that is wanted and a check missed its target.
fn told(report: &Value, checks: &[Check], json: bool, check: bool) -> anyhow::Result<()> {
    if json {
        println!("{report:#}");
    } else {
        print!("{}", table(checks));
    }
    ensure!(!check || checks.iter().all(|check| check.ok), "a check missed its target");
    Ok(())
}
