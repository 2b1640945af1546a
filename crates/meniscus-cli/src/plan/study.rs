//! `meniscus plan study`: random moves in the simulator, with the estimator in the loop.

use crate::inputs::file;
use crate::outputs::check_folder;
use crate::stop::{finish_partial, watched_until};
use anyhow::{Context, anyhow, ensure};
use indicatif::ProgressBar;
use meniscus::blob::Model;
use meniscus_plan::study::{
    Outcome, Planner, Progress, StudyModels, StudyOptions, checks, move_png, read, report, run as carry_out,
    study_png,
};
use meniscus_platform::files::write_whole;
use meniscus_report::checks::table;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

/// Carry out random planned moves in the simulator and compare crests.
///
/// Glycerine is planned by its learned model; water by the reduced model, or by a learned one (--water). The simulator moves the
/// glass as the plan says. The estimator sees its surface with the noise of the camera. Ten times a second the plan is checked, and the
/// rest of the move is planned anew where it no longer keeps the limit. Crests are those of the simulator, and minimum jerk goes the
/// same distance beside it.
///
/// A move takes about 40 s of processor time. Each is kept in --out when it is done, and the same command continues. Ctrl-C
/// writes the page of what is done, which says that it is partial.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus plan study --json\n  meniscus plan study --water models/water.blob\n  meniscus plan study --moves 20 --out mine\n  meniscus plan study --moves 20 --out mine --report-only"
)]
pub(crate) struct Arguments {
    /// Number of moves; glycerine and water in turn.
    #[arg(long, default_value_t = 100, help_heading = "Method")]
    moves: usize,
    /// Seed of the first move; each further one has the next.
    #[arg(long, default_value_t = 1, help_heading = "Method")]
    first_seed: u64,
    /// Learned model of glycerine: the one in the program (shipped) or a blob.
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE", help_heading = "Method")]
    model: PathBuf,
    /// Model that plans water: the reduced one or a blob.
    #[arg(long, default_value = "reduced", value_name = "reduced|FILE", help_heading = "Method")]
    water: PathBuf,
    /// Only write the page of what was carried out before.
    #[arg(long, help_heading = "Method")]
    report_only: bool,
    /// Folder of the moves, the page and the pictures.
    #[arg(long, default_value = "out/plan", value_name = "DIR", help_heading = "Output")]
    out: PathBuf,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    ensure!(
        (1..=10_000).contains(&arguments.moves),
        "--moves {} is out of range: 1 to 10000",
        arguments.moves
    );
    let folder = arguments.out.join("moves");
    check_folder(&folder)?;
    let water = if arguments.water.as_os_str() == "reduced" { Planner::Reduced } else { Planner::Learned };
    let options = StudyOptions { count: arguments.moves, first_seed: arguments.first_seed, folder, water };
    if !arguments.report_only {
        simulate(arguments, &options)?;
    }
    let outcomes = read(&options);
    ensure!(
        !outcomes.is_empty(),
        "no move is done yet: {} holds none; the same command continues",
        options.folder.display()
    );
    let command = format!(
        "meniscus plan study --moves {} --first-seed {} --water {}",
        arguments.moves,
        arguments.first_seed,
        arguments.water.display()
    );
    let mut report = report(&outcomes, arguments.moves, &command);
    study_png(&outcomes, &arguments.out.join("study.png"))?;
    report.picture("study.png", "all moves: crest over the limit, and over minimum jerk in the same time");
    shown(&outcomes, arguments)?;
    report.picture("move.png", "one move, planned and by minimum jerk");
    write_whole(&arguments.out.join("study.md"), report.markdown().as_bytes())?;
    if arguments.json {
        println!("{:#}", report.json());
    } else {
        print!("{}", table(&checks(&outcomes, arguments.moves)));
        println!("written: {}", arguments.out.display());
    }
    Ok(())
}

/// Draws the move in the middle of those done, by the crest over that of minimum jerk.
fn shown(outcomes: &[Outcome], arguments: &Arguments) -> anyhow::Result<()> {
    let ratio = |one: &Outcome| one.crest_m / one.minimum_jerk_m;
    let mut by_ratio: Vec<&Outcome> = outcomes.iter().collect();
    by_ratio.sort_by(|a, b| ratio(a).total_cmp(&ratio(b)));
    let one = by_ratio[by_ratio.len() / 2];
    let title = format!(
        "{} moved by {:.2} m in {:.2} s (seed {}): a crest of {:.1} mm planned, {:.1} mm by minimum jerk",
        one.of.liquid.name(),
        one.of.request.to_m,
        one.arrival_s,
        one.of.seed,
        1e3 * one.crest_m,
        1e3 * one.minimum_jerk_m
    );
    let traces = [("planned", &one.planned), ("minimum jerk in the same time", &one.minimum_jerk)];
    Ok(move_png(&title, one.of.request.limit_m, &traces, &arguments.out.join("move.png"))?)
}

/// Loads the model in `blob`, of the file at `path`.
fn load<'a>(blob: &'a [u8], path: &Path) -> anyhow::Result<Model<'a>> {
    Model::load(blob).with_context(|| format!("the model {} is refused", path.display()))
}

/// Carries out what is missing.
fn simulate(arguments: &Arguments, options: &StudyOptions) -> anyhow::Result<()> {
    let stop = watched_until(format!(
        "the page is not written anew; the moves that were done are kept in {}, and the same command continues",
        options.folder.display()
    ))?;
    let blob = file(&arguments.model)?;
    let glycerine = load(&blob, &arguments.model)?;
    let water_blob = match options.water {
        Planner::Learned => Some(file(&arguments.water)?),
        Planner::Reduced => None,
    };
    let water = water_blob.as_ref().map(|blob| load(blob, &arguments.water)).transpose()?;
    let models = StudyModels { glycerine: &glycerine, water: water.as_ref() };
    let bar = if arguments.json { ProgressBar::hidden() } else { crate::bars::bar(arguments.moves as u64) };
    bar.set_style(crate::bars::style("{msg:24} {wide_bar} {pos}/{len} moves, {left}")?);
    let show = |progress: Progress<'_>| match progress {
        Progress::Settling(liquid) => bar.set_message(format!("{liquid} settles")),
        Progress::Done(done, _) => {
            bar.set_message("moves");
            bar.set_position(done as u64);
        }
        Progress::Failed(one, failure) => {
            bar.suspend(|| eprintln!("{} is left out: {failure}", one.name()));
        }
    };
    carry_out(options, models, stop, show).map_err(|error| anyhow!("{error}"))?;
    bar.finish_and_clear();
    finish_partial();
    if stop.load(Ordering::Relaxed) {
        eprintln!("interrupted: the moves that are done are kept");
    }
    Ok(())
}
