//! `meniscus people`: what those who watch cost.

mod clean_clone;
mod recognition;

use super::inputs;
use anyhow::ensure;
use meniscus::blob::Model;
use meniscus::surface::{Config, Settings};
use meniscus_data::recording::Recording;
use meniscus_report::checks::{Check, table};
use meniscus_timing::viewers::{ViewerPlan, study};
use meniscus_virtual::render::SceneSettings;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Study viewers, identification and the first start.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(clap::Subcommand)]
enum Verb {
    Study(Study),
}

/// Measure how much viewers of the live page delay the turn.
///
/// `run` goes in real time, round after round of the shipped recording (12 s each), in every second pair of rounds with viewers in
/// this process, which take every frame. The turn's median must not change by more than 2 %, and no viewer may need more than
/// 2 Mbit/s. On a busy machine the first depends on chance; `rounds_change` has each round.
///
/// --recognition measures instead how often `meniscus run --among` identifies the right liquid. --clean-clone measures the time
/// from `git clone` to a moving liquid on the page, with the build and without the download of the crates.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus people study\n  meniscus people study --rounds 16 --json\n  meniscus people study --recognition unseen --json\n  meniscus people study --clean-clone ."
)]
struct Study {
    /// Rounds, half of them with viewers, 2 to 200.
    #[arg(
        long,
        default_value_t = 8,
        value_parser = clap::value_parser!(u16).range(2..=200),
        help_heading = "Method"
    )]
    rounds: u16,
    /// Viewers at a time, 1 to 16.
    #[arg(
        long,
        default_value_t = 4,
        value_parser = clap::value_parser!(u16).range(1..=16),
        help_heading = "Method"
    )]
    viewers: u16,
    /// Measure identification alone, over DIR/LIQUID/*.safetensors.
    ///
    /// Recordings of liquids that are not known are to be refused.
    #[arg(long, value_name = "DIR", help_heading = "Method")]
    recognition: Option<PathBuf>,
    /// Measure the time from a clone of this repository to a moving liquid.
    ///
    /// A folder or an address. Needs about 1 GB in the temporary folder, and some minutes of all cores.
    #[arg(long, value_name = "REPOSITORY", conflicts_with = "recognition", help_heading = "Method")]
    clean_clone: Option<PathBuf>,
    /// Known liquids, with --recognition: shipped, a note, or a folder of notes; may be repeated.
    #[arg(
        long,
        default_value = "shipped",
        value_name = "shipped|FILE|DIR",
        requires = "recognition",
        help_heading = "Method"
    )]
    among: Vec<String>,
    /// Print one JSON object instead of the table.
    #[arg(long, help_heading = "Output")]
    json: bool,
    /// Exit with status 1 if a check misses its target.
    #[arg(long, help_heading = "Output")]
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
        return print_report(&report, &checks, *json, *check);
    }
    if let Some(folder) = recognition {
        let study = recognition::measure(folder, among, *json)?;
        if !json {
            print!("{}", recognition::text(&study));
        }
        return print_report(&recognition::json(&study), &study.checks(), *json, *check);
    }
    let bytes = inputs::file("shipped")?;
    let model = Model::load(&bytes)?;
    let recording = Recording::from_bytes(Path::new("the shipped recording"), meniscus_shipped::RECORDING)?;
    let header = &model.header;
    let settings = Settings::for_glass(header.radius_m, header.fill_m, header.rim_m);
    let scene = SceneSettings { camera: settings, ..SceneSettings::default() };
    let pairs = usize::from(rounds.div_ceil(2));
    let bar = crate::bars::bar(2 * pairs as u64);
    bar.set_style(crate::bars::style("rounds {wide_bar} {pos}/{len}, {left}")?);
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
    print_report(&report, &checks, *json, *check)
}

/// Prints a study, and fails if that is wanted and a check missed its target.
fn print_report(report: &Value, checks: &[Check], json: bool, check: bool) -> anyhow::Result<()> {
    if json {
        println!("{report:#}");
    } else {
        print!("{}", table(checks));
    }
    ensure!(!check || checks.iter().all(|check| !check.missed()), "a check missed its target");
    Ok(())
}
