//! `meniscus sweep`: one command for many values, on one machine or on a cluster.

mod design;
mod manifest;
mod merge;
mod part;
mod share;

use crate::bars::{bar, style};
use crate::stop::watched_until;
use anyhow::{bail, ensure};
use design::Design;
use indicatif::ProgressStyle;
use manifest::Manifest;
use part::{Done, State};
use std::path::PathBuf;
use std::sync::atomic::Ordering;

/// Run one command for many values, on one machine or on a cluster.
///
/// A design names the command and the values. `make` writes a manifest of its parts, `run` runs those that are missing, and
/// `merge` makes one report of them. Tasks that share the folder of the sweep divide the parts: `run --part 3/8`, or `run` in a
/// job array of Slurm or an indexed job of Kubernetes. A task that was lost or killed is run again; what is done is not done
/// twice. The report of many tasks is that of one, to the byte.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus sweep make design.toml --out viscosities\n  meniscus sweep run viscosities --part 3/8\n  meniscus sweep status viscosities\n  meniscus sweep merge viscosities"
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(clap::Subcommand)]
enum Verb {
    Make(Make),
    Run(Run),
    Status(Status),
    Merge(Merge),
}

/// Write the manifest of a design.
///
/// A design is a TOML file. `command = "simulate --liquid {liquid} --out {out}/slosh.safetensors"` is the command, without
/// `meniscus`; {out} is the folder of a part. A table [vary] has a list of values for each other name in braces, as
/// `liquid = ["water", "honey"]`. Every combination is a part; tables [[part]] name the parts one by one instead. The command may be
/// a list of words, for words with spaces.
///
/// Every part is checked as its command would check it. Files are named from the folder of the design, or with whole paths.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  meniscus sweep make design.toml --out viscosities")]
struct Make {
    /// Design, a TOML file.
    design: PathBuf,
    /// Folder of the sweep; made if it is not there.
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    out: PathBuf,
}

/// Run the parts that are missing.
///
/// Without --part the task takes its place from Slurm (SLURM_ARRAY_TASK_ID) or Kubernetes (JOB_COMPLETION_INDEX, with --parts);
/// elsewhere it runs all. A part that another task is at is left to it. A part that failed is tried again.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus sweep run viscosities\n  meniscus sweep run viscosities --part 3/8\n  sbatch --array=1-8 examples/sweep/slurm.sh viscosities"
)]
struct Run {
    /// Folder of the sweep.
    folder: PathBuf,
    /// Place of this task among all, as I/N with I from 1.
    #[arg(long, value_name = "I/N", help_heading = "Method")]
    part: Option<String>,
    /// Number of tasks, where the place of this one is in the environment.
    #[arg(long, value_name = "N", conflicts_with = "part", help_heading = "Method")]
    parts: Option<usize>,
}

/// Say how many parts are done, running, failed and missing.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  meniscus sweep status viscosities")]
struct Status {
    /// Folder of the sweep.
    folder: PathBuf,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Make one report of all parts: report.json and report.csv.
///
/// The report has the values, checks and files of each part, and mean, least, median and largest of each check. It is the
/// same to the byte whoever ran the parts, if the command answers the same. Name checks that measure time under `leave_out` in
/// the design: they differ from run to run.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus sweep merge viscosities\n  meniscus sweep merge viscosities --partial --json"
)]
struct Merge {
    /// Folder of the sweep.
    folder: PathBuf,
    /// Merge the parts that are done; the report names the others.
    #[arg(long, help_heading = "Method")]
    partial: bool,
    /// Print the report as one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    match &arguments.verb {
        Verb::Make(make) => write(make),
        Verb::Run(run) => run_parts(run),
        Verb::Status(status) => tell(status),
        Verb::Merge(wanted) => merge::merge(&wanted.folder, wanted.partial, wanted.json),
    }
}

/// Writes the manifest.
fn write(arguments: &Make) -> anyhow::Result<()> {
    let design = Design::read(&arguments.design)?;
    let manifest = Manifest::of(&design)?;
    manifest.write(&arguments.out)?;
    let folder = arguments.out.display();
    println!("{} parts in {folder}: meniscus sweep run {folder}", manifest.parts.len());
    Ok(())
}

/// Runs the parts of this task.
fn run_parts(arguments: &Run) -> anyhow::Result<()> {
    let manifest = Manifest::read(&arguments.folder)?;
    let share = share::of(arguments.part.as_deref(), arguments.parts, |name| std::env::var(name).ok())?;
    let stop = watched_until(format!(
        "finished parts are kept in {}, and the same command continues from there",
        arguments.folder.display()
    ))?;
    let mine: Vec<usize> = (0..manifest.parts.len()).filter(|part| share.has(*part)).collect();
    let bar = bar(mine.len() as u64);
    bar.set_style(
        style("{pos} of {len} parts {wide_bar} {left}").unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let (mut ran, mut failed, mut elsewhere) = (0, Vec::new(), 0);
    for part in mine {
        match part::run(&manifest, &arguments.folder, part)? {
            Done::Before => {}
            Done::Now => ran += 1,
            Done::Elsewhere => elsewhere += 1,
            Done::Failed(why) => {
                bar.suspend(|| eprintln!("part {} failed: {why}", part + 1));
                failed.push(part + 1);
            }
        }
        if stop.load(Ordering::Relaxed) {
            // The status of the program says that it was interrupted.
            bar.finish_and_clear();
            return Ok(());
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    let folder = arguments.folder.display();
    println!("{ran} parts were run, {elsewhere} are run by other tasks; meniscus sweep status {folder}");
    ensure!(
        failed.is_empty(),
        "{} parts failed, the first is {}: see {} for its messages, and run again",
        failed.len(),
        failed[0],
        part::log(&arguments.folder, failed[0] - 1).display()
    );
    Ok(())
}

/// Prints how far the sweep is.
fn tell(arguments: &Status) -> anyhow::Result<()> {
    let manifest = Manifest::read(&arguments.folder)?;
    let states: Vec<State> =
        (0..manifest.parts.len()).map(|part| part::state(&arguments.folder, part)).collect();
    let count = |wanted: State| states.iter().filter(|state| **state == wanted).count();
    let [done, running, failed, missing] = State::ALL.map(count);
    if arguments.json {
        println!(
            "{:#}",
            serde_json::json!({
                "parts": states.len(), "done": done, "running": running, "failed": failed, "missing": missing,
            })
        );
        return Ok(());
    }
    println!("{} parts: {done} done, {running} running, {failed} failed, {missing} missing", states.len());
    if let Some(first) = states.iter().position(|state| *state == State::Failed) {
        println!("the first that failed is {}: {}", first + 1, part::log(&arguments.folder, first).display());
    }
    if states.is_empty() {
        bail!("a sweep without parts has nothing to run");
    }
    Ok(())
}
