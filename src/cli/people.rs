//! `meniscus people`: what those who watch cost.

mod recognition;

use super::{inputs, shipped};
use indicatif::{ProgressBar, ProgressStyle};
use meniscus::host::checks::table;
use meniscus::model::Model;
use meniscus::offline::recording::Recording;
use meniscus::offline::scene::SceneSettings;
use meniscus::offline::viewers::study;
use meniscus::surface::{Config, Settings};
use serde_json::json;
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
/// recordings that nothing was learnt from.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "Examples:\n  meniscus people study\n  meniscus people study --rounds 16 --json\n  meniscus people study --recognition unseen --json"
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
    let Verb::Study(Study { rounds, viewers, recognition, among, json, check }) = &arguments.verb;
    if let Some(folder) = recognition {
        let study = recognition::measure(folder, among, *json)?;
        if *json {
            println!("{:#}", recognition::json(&study));
        } else {
            print!("{}", recognition::text(&study));
        }
        if *check && !study.checks().iter().all(|check| check.ok) {
            anyhow::bail!("a check missed its target");
        }
        return Ok(());
    }
    let bytes = inputs::file("shipped")?;
    let model = Model::load(&bytes)?;
    let recording = Recording::from_bytes(Path::new("the shipped recording"), shipped::RECORDING)?;
    let header = &model.header;
    let settings = Settings::for_glass(header.radius_m, header.fill_m, header.rim_m);
    let scene = SceneSettings { camera: settings, ..SceneSettings::default() };
    let pairs = usize::from(rounds.div_ceil(2));
    let bar = ProgressBar::new(2 * pairs as u64);
    bar.set_style(ProgressStyle::with_template("rounds {wide_bar} {pos}/{len}, {eta} left")?);
    let sizes = (pairs, usize::from(*viewers));
    let measured = study(&model, &recording, scene, Config::new(settings)?, sizes, || bar.inc(1))?;
    bar.finish_and_clear();
    let checks = measured.checks();
    if *json {
        let report = json!({
            "command": "meniscus people study",
            "version": env!("CARGO_PKG_VERSION"),
            "viewers": viewers,
            "rounds": 2 * pairs,
            "rounds_change": measured.changes,
            "checks": checks,
        });
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        print!("{}", table(&checks));
    }
    if *check && !checks.iter().all(|check| check.ok) {
        anyhow::bail!("a check missed its target");
    }
    Ok(())
}
