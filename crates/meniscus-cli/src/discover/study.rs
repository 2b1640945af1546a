//! `meniscus discover study`: hidden effects, clean glasses, measured water.

use super::super::outputs::check_folder;
use super::super::stop::{finish_partial, watched_until};
use indicatif::ProgressBar;
use meniscus_discover::decision::settings::Settings;
use meniscus_discover::study::against_simulator::{AgainstSimulator, against_simulator, simulator_checks};
use meniscus_discover::study::bench::StudyFolders;
use meniscus_discover::study::coverage::reference_coverage;
use meniscus_discover::study::duration::long_discovery_s;
use meniscus_discover::study::measured::judge_measured;
use meniscus_discover::study::page::{against_report, law_report, report};
use meniscus_discover::study::pictures::{confusion_png, detection_png};
use meniscus_discover::study::run::{RunOptions, judge_all};
use meniscus_discover::study::simulate::simulate;
use meniscus_discover::study::tally::{Beside, StudyTally, checks};
use meniscus_discover::study::unnamed::checks::law_checks;
use meniscus_discover::study::unnamed::judge::{LawBench, LawOutcome};
use meniscus_discover::study::unnamed::trials::law_trials;
use meniscus_platform::files::write_whole;
use meniscus_report::Report;
use meniscus_report::checks::table;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// Hide effects in simulations and count what discovery finds.
///
/// Glasses of liquid are simulated with an effect switched on, seen through the simulated camera (2 mm depth noise, holes), and
/// given to discovery under neutral names. The answers are in a file that it never opens. Clean glasses, effects that the library
/// lacks, two effects at once, a misjudged noise, intervals, and measured water follow.
///
/// Laws that no library holds are hidden in the liquid of another solver, and the drawn laws are compared with them. --laws-only
/// does that alone, in a few minutes, and writes laws.md and laws.json. --references-only judges clean glasses and hidden effects
/// against references by simulation, in other packings and spacings, and writes references.md and references.json.
///
/// Each of the 86 glasses takes about 55 s of processor time if it is not in --cache, each of about 240 trials some seconds. Both
/// are kept, and the same command continues. Ctrl-C writes the page of what is judged by then, with the number of missing trials.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus discover study --json\n  meniscus discover study --clean 30 --simulated\n  meniscus discover study --report-only\n  meniscus discover study --laws-only --json"
)]
pub(crate) struct Arguments {
    /// Folder of simulated glasses; missing ones are simulated.
    #[arg(long, default_value = "out/discover-cache", value_name = "DIR", help_heading = "Input")]
    cache: PathBuf,
    /// Folder of measured water: heights/ and motions/ as in tests/fixtures/antisloshing.
    #[arg(long, value_name = "DIR", help_heading = "Input")]
    measured: Option<PathBuf>,
    /// Number of clean trials.
    #[arg(long, default_value_t = 118, help_heading = "Method")]
    clean: usize,
    /// Seed of the camera's noise and of all random draws.
    #[arg(long, default_value_t = 1, help_heading = "Method")]
    seed: u64,
    /// Only simulate what is missing.
    #[arg(long, help_heading = "Method")]
    simulate_only: bool,
    /// Judge only what is simulated already.
    #[arg(long, conflicts_with = "simulate_only", help_heading = "Method")]
    simulated: bool,
    /// Only write the page of what was judged before.
    #[arg(long, conflicts_with_all = ["simulate_only", "simulated"], help_heading = "Method")]
    report_only: bool,
    /// Only the trials: no measured water, intervals or long recordings.
    #[arg(long, help_heading = "Method")]
    trials_only: bool,
    /// Only the laws that no library holds: no glass is simulated.
    #[arg(long, conflicts_with_all = ["simulate_only", "simulated", "report_only", "trials_only", "measured"], help_heading = "Method")]
    laws_only: bool,
    /// Only the verdicts against references by simulation: 27 half-filled glasses are simulated.
    #[arg(long, conflicts_with_all = ["simulate_only", "simulated", "report_only", "trials_only", "measured", "laws_only"], help_heading = "Method")]
    references_only: bool,
    /// Folder for the page, the pictures and the trials.
    #[arg(long, default_value = "out/discover", value_name = "DIR", help_heading = "Output")]
    out: PathBuf,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    check_folder(&arguments.out)?;
    let stop = watched_until(format!(
        "the page is not written anew; what was simulated and judged is kept in {} and {}, --report-only writes the page of \
         it, and the same command continues",
        arguments.cache.display(),
        arguments.out.display()
    ))?;
    let bar = if arguments.json { ProgressBar::hidden() } else { crate::bars::bar(0) };
    bar.set_style(crate::bars::style("{msg:24} {wide_bar} {pos}/{len}, {left}")?);
    if arguments.laws_only {
        return laws_alone(arguments, stop, &bar);
    }
    if arguments.references_only {
        return references_alone(arguments, stop, &bar);
    }
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
    finish_partial();
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

/// Judges the trials of the drawn law until `stop` is set.
fn laws(stop: &AtomicBool, bar: &ProgressBar) -> anyhow::Result<Vec<LawOutcome>> {
    let trials = law_trials();
    bar.reset();
    bar.set_length(trials.len() as u64);
    bar.set_message("drawing laws");
    let bench = LawBench::new()?;
    let mut out = Vec::new();
    for trial in &trials {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        out.push(bench.judge(trial)?);
        bar.inc(1);
    }
    Ok(out)
}

/// Judges the trials of the drawn law and writes their page.
fn laws_alone(arguments: &Arguments, stop: &AtomicBool, bar: &ProgressBar) -> anyhow::Result<()> {
    let outcomes = laws(stop, bar)?;
    bar.finish_and_clear();
    finish_partial();
    if stop.load(Ordering::Relaxed) {
        eprintln!(
            "interrupted: nothing is written; {} trials were judged, and the same command starts anew",
            outcomes.len()
        );
        return Ok(());
    }
    let report = law_report(&outcomes, "meniscus discover study --laws-only");
    let write = |name: &str, bytes: &[u8]| write_whole(&arguments.out.join(name), bytes);
    write("laws.md", report.markdown().as_bytes())?;
    write("laws.json", serde_json::to_string_pretty(&outcomes)?.as_bytes())?;
    if arguments.json {
        println!("{:#}", report.json());
    } else {
        print!("{}", table(&law_checks(&outcomes)));
        println!("written: {}", arguments.out.display());
    }
    Ok(())
}

/// Judges the trials against references by simulation; the simulations are kept in the cache.
fn against(
    arguments: &Arguments,
    stop: &AtomicBool,
    bar: &ProgressBar,
) -> anyhow::Result<Vec<AgainstSimulator>> {
    bar.reset();
    bar.set_message("references by simulation");
    let progress = |done: usize, all: usize| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    };
    Ok(against_simulator(&arguments.cache.join("references"), Some(stop), &progress)?)
}

/// Judges the trials against references by simulation and writes their page.
fn references_alone(arguments: &Arguments, stop: &AtomicBool, bar: &ProgressBar) -> anyhow::Result<()> {
    let outcomes = against(arguments, stop, bar)?;
    bar.finish_and_clear();
    finish_partial();
    let report = against_report(&outcomes, "meniscus discover study --references-only");
    write_whole(&arguments.out.join("references.md"), report.markdown().as_bytes())?;
    write_whole(&arguments.out.join("references.json"), serde_json::to_string_pretty(&outcomes)?.as_bytes())?;
    if arguments.json {
        println!("{:#}", report.json());
    } else {
        print!("{}", table(&simulator_checks(&outcomes)));
        println!("written: {}", arguments.out.display());
    }
    Ok(())
}

/// Measurements of an earlier run beside the trials.
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
    let judged = laws(stop, bar)?;
    if stop.load(Ordering::Relaxed) {
        return Ok(());
    }
    study.beside.laws = judged;
    keep(&study.beside)?;
    study.beside.against = against(arguments, stop, bar)?;
    keep(&study.beside)?;
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
