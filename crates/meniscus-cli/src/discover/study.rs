//! `meniscus discover study`: hidden effects, clean glasses, measured water.

use super::super::stop::watched;
use indicatif::{ProgressBar, ProgressStyle};
use meniscus_discover::decision::settings::Settings;
use meniscus_discover::study::bench::StudyFolders;
use meniscus_discover::study::coverage::reference_coverage;
use meniscus_discover::study::duration::long_discovery_s;
use meniscus_discover::study::measured::judge_measured;
use meniscus_discover::study::page::report;
use meniscus_discover::study::pictures::{confusion_png, detection_png};
use meniscus_discover::study::run::{RunOptions, judge_all};
use meniscus_discover::study::simulate::simulate;
use meniscus_discover::study::tally::{Beside, StudyTally, checks};
use meniscus_platform::files::write_whole;
use meniscus_report::Report;
use meniscus_report::checks::table;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// Hide effects in simulated recordings and see whether discovery finds them.
///
/// Glasses of liquid are simulated by smoothed particles with an effect switched on, seen through the simulated
/// camera (2 mm depth noise, holes), and given to discovery under neutral names; the answers lie in a file that
/// it never opens. Then: clean glasses, effects that the library lacks, two effects at once, a noise that is
/// misjudged, intervals, and measured water where its data are there.
///
/// About 55 s of processor time for each glass that is not in --cache yet (86 in all), some seconds for each of
/// about 240 trials. Both are kept: the command goes on where it was interrupted. Ctrl-C writes the page of what
/// is judged by then, with how many trials are not; --report-only does the same without judging any.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus discover study --json\n  meniscus discover study --clean 30 --simulated\n  meniscus discover study --report-only"
)]
pub(crate) struct Arguments {
    /// Folder in which simulated glasses are kept; what is missing is simulated.
    #[arg(long, default_value = "out/discover-cache", value_name = "DIR")]
    cache: PathBuf,
    /// Folder for the page, the pictures and the trials.
    #[arg(long, default_value = "out/discover", value_name = "DIR")]
    out: PathBuf,
    /// Folder of measured water: heights/ and motions/ as in tests/fixtures/antisloshing; left out without it.
    #[arg(long, value_name = "DIR")]
    measured: Option<PathBuf>,
    /// Clean trials.
    #[arg(long, default_value_t = 118)]
    clean: usize,
    /// Seed of the camera's noise and of everything that is drawn.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only simulate what is missing.
    #[arg(long)]
    simulate_only: bool,
    /// Judge only what is simulated already.
    #[arg(long, conflicts_with = "simulate_only")]
    simulated: bool,
    /// Only write the page of what was judged before.
    #[arg(long, conflicts_with_all = ["simulate_only", "simulated"])]
    report_only: bool,
    /// Only the trials: leave out measured water, intervals and long recordings.
    #[arg(long)]
    trials_only: bool,
    /// One JSON object on standard output.
    #[arg(long)]
    json: bool,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let stop = watched()?;
    let bar = if arguments.json { ProgressBar::hidden() } else { ProgressBar::new(0) };
    bar.set_style(ProgressStyle::with_template("{msg:24} {wide_bar} {pos}/{len}, {eta} left")?);
    if !arguments.simulated && !arguments.report_only {
        bar.set_message("simulating glasses");
        let simulated = |done: usize, all: usize| {
            bar.set_length(all as u64);
            bar.set_position(done as u64);
        };
        simulate(&arguments.cache, stop, simulated)?;
        bar.reset();
    }
    if arguments.simulate_only {
        bar.finish_and_clear();
        return Ok(());
    }
    let places = StudyFolders { cache: arguments.cache.clone(), out: arguments.out.clone() };
    let progress = |work: &str, done: usize, all: usize| {
        bar.set_message(String::from(work));
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    };
    let options =
        RunOptions { cleans: arguments.clean, seed: arguments.seed, judges: !arguments.report_only };
    let (lines, planned) = judge_all(&places, options, stop, &progress)?;
    let mut study = StudyTally { lines, planned, beside: beside_before(&arguments.out) };
    if !arguments.report_only && !arguments.trials_only {
        // Kept after each part, so that an interruption leaves what there is.
        write(arguments, &study)?;
        beside(arguments, &places, &mut study, stop, &bar)?;
    }
    bar.finish_and_clear();
    if stop.load(Ordering::Relaxed) {
        eprintln!("interrupted: the page holds what is judged; the same command goes on from there");
    }
    let report = write(arguments, &study)?;
    if arguments.json {
        println!("{:#}", report.json());
    } else {
        print!("{}", table(&checks(&study)));
        println!("written: {}", arguments.out.display());
    }
    Ok(())
}

/// What an earlier run measured beside the trials.
fn beside_before(out: &Path) -> Beside {
    let bytes = std::fs::read(out.join("beside.json")).ok();
    bytes.and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default()
}

/// Measured water, intervals and long recordings, each kept when it is there.
fn beside(
    arguments: &Arguments,
    places: &StudyFolders,
    study: &mut StudyTally,
    stop: &AtomicBool,
    bar: &ProgressBar,
) -> anyhow::Result<()> {
    let keep = |beside: &Beside| -> anyhow::Result<()> {
        let text = serde_json::to_string_pretty(beside)?;
        Ok(write_whole(&arguments.out.join("beside.json"), text.as_bytes())?)
    };
    if stop.load(Ordering::Relaxed) {
        return Ok(());
    }
    bar.set_message("recordings of 10 s");
    study.beside.long_s = long_discovery_s()?.into();
    keep(&study.beside)?;
    if stop.load(Ordering::Relaxed) {
        return Ok(());
    }
    bar.set_message("intervals");
    study.beside.coverage = reference_coverage(&places.out, arguments.seed)?;
    keep(&study.beside)?;
    if stop.load(Ordering::Relaxed) {
        return Ok(());
    }
    if let Some(folder) = &arguments.measured {
        bar.set_message("measured water");
        let cases = judge_measured(folder, &Settings::default(), 14.0, 4)?;
        study.beside.measured = Some(cases.into_iter().map(|case| case.result).collect());
        keep(&study.beside)?;
    } else {
        bar.suspend(|| eprintln!("measured water is left out: --measured names no folder"));
    }
    Ok(())
}

/// Writes page and pictures; returns the report.
fn write(arguments: &Arguments, study: &StudyTally) -> anyhow::Result<Report> {
    let command = format!("meniscus discover study --clean {} --seed {}", arguments.clean, arguments.seed);
    let report = report(study, &command);
    write_whole(&arguments.out.join("study.md"), report.markdown().as_bytes())?;
    confusion_png(study, &arguments.out.join("confusion.png"))?;
    detection_png(study, &arguments.out.join("detection.png"))?;
    Ok(report)
}
