//! `meniscus discover study`: hidden effects, clean glasses, measured water.

mod alone;

use super::super::outputs::check_folder;
use super::super::stop::{finish_partial, watched_until};
use alone::{against, laboratory, laboratory_alone, laws, laws_alone, references_alone};
use indicatif::ProgressBar;
use meniscus_discover::decision::settings::Settings;
use meniscus_discover::sizing::simulations::Shard;
use meniscus_discover::study::bench::StudyFolders;
use meniscus_discover::study::checks::checks;
use meniscus_discover::study::coverage::reference_coverage;
use meniscus_discover::study::duration::long_discovery_s;
use meniscus_discover::study::measured::judge_measured;
use meniscus_discover::study::page::report;
use meniscus_discover::study::pictures::{confusion_png, detection_png};
use meniscus_discover::study::run::{RunOptions, judge_all};
use meniscus_discover::study::simulate::simulate;
use meniscus_discover::study::sizes::run::{SPACING_M, size_all};
use meniscus_discover::study::tally::{Beside, StudyTally};
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
/// does that alone, in a few minutes, and writes laws.md and laws.json. --laboratory-only hides effects of the library in the liquid of
/// a solver that shares no formula with the reduced model, and writes laboratory.md and laboratory.json. --references-only
/// judges clean glasses and hidden effects against references by simulation, in other packings and spacings, and writes
/// references.md and references.json.
///
/// Each of about 120 glasses takes about 30 s of processor time if it is not in --cache, each of about 280 trials some seconds. About
/// 35 trials are sized by simulation, in some minutes each. All are kept, and the same command continues. Ctrl-C ends it, and
/// --report-only writes the page of what is judged by then.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus discover study --json\n  meniscus discover study --clean 30 --simulated\n  meniscus discover study --report-only\n  meniscus discover study --laws-only --json\n  meniscus discover study --laboratory-only"
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
    /// Only the trials, without sizes, measured water and intervals.
    #[arg(long, help_heading = "Method")]
    trials_only: bool,
    /// Only the trials and their sizes by simulation.
    #[arg(long, conflicts_with_all = ["simulate_only", "report_only", "trials_only", "measured"], help_heading = "Method")]
    sizes_only: bool,
    /// Spacing of the particles at which sizes end, mm: 4 to 8; the search begins at 7 mm.
    ///
    /// 7 leaves out the search at a finer spacing, and the spacing's error. Names are decided at 7 mm anyway.
    #[arg(long, default_value_t = 1e3 * SPACING_M, value_name = "MM", value_parser = spacing_mm, help_heading = "Method")]
    spacing_mm: f64,
    /// Only the laws that no library holds: no glass is simulated.
    #[arg(long, conflicts_with_all = ["simulate_only", "simulated", "report_only", "trials_only", "sizes_only", "measured"], help_heading = "Method")]
    laws_only: bool,
    /// Only the trials of the second laboratory: no glass is simulated.
    #[arg(long, conflicts_with_all = ["simulate_only", "simulated", "report_only", "trials_only", "sizes_only", "measured", "laws_only"], help_heading = "Method")]
    laboratory_only: bool,
    /// Only the verdicts against references by simulation, of 27 glasses.
    #[arg(long, conflicts_with_all = ["simulate_only", "simulated", "report_only", "trials_only", "sizes_only", "measured", "laws_only", "laboratory_only"], help_heading = "Method")]
    references_only: bool,
    /// Simulate and judge one part, as 2/8.
    ///
    /// The machines share --cache and --out. A trial whose glasses another part makes is left out: run the same command again when
    /// all parts are done. The command without --part writes the page.
    #[arg(long, value_name = "INDEX/COUNT", value_parser = Shard::parse, conflicts_with_all = ["report_only", "measured", "laws_only", "laboratory_only", "references_only"], help_heading = "Method")]
    part: Option<Shard>,
    /// Folder for the page, the pictures and the trials.
    #[arg(long, default_value = "out/discover", value_name = "DIR", help_heading = "Output")]
    out: PathBuf,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Reads the spacing of the particles, mm.
fn spacing_mm(text: &str) -> Result<f64, String> {
    let spacing = text.parse::<f64>().ok().filter(|spacing| (4.0..=8.0).contains(spacing));
    spacing.ok_or_else(|| format!("'{text}' is no spacing from 4 to 8 mm"))
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
    if arguments.laboratory_only {
        return laboratory_alone(arguments, stop, &bar);
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
        simulate(&arguments.cache, arguments.part, stop, simulated)?;
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
    let options = RunOptions {
        cleans: arguments.clean,
        seed: arguments.seed,
        judges: !arguments.report_only,
        part: arguments.part,
        spacing_m: 1e-3 * arguments.spacing_mm,
    };
    let (lines, planned) = judge_all(&places, options, stop, &progress)?;
    let mut study = StudyTally { lines, planned, beside: beside_before(&arguments.out) };
    if !arguments.report_only && !arguments.trials_only {
        if arguments.part.is_none() {
            // Kept after each kind of work, so that an interruption leaves what there is.
            write(arguments, &study)?;
        }
        if !arguments.sizes_only && arguments.part.is_none() {
            beside(arguments, &places, &mut study, stop, &bar)?;
        }
    }
    let sizes = RunOptions { judges: options.judges && !arguments.trials_only, ..options };
    study.beside.sizes = size_all(&places, sizes, stop, &progress)?;
    bar.finish_and_clear();
    finish_partial();
    if let Some(part) = arguments.part {
        println!("part {part} is done: the command without --part writes the page when all parts are");
        return Ok(());
    }
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

/// Measurements of an earlier run beside the trials.
fn beside_before(out: &Path) -> Beside {
    let bytes = std::fs::read(out.join("beside.json")).ok();
    bytes.and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default()
}

/// Keeps the measurements beside the trials.
fn keep(out: &Path, beside: &Beside) -> anyhow::Result<()> {
    let text = serde_json::to_string_pretty(beside)?;
    Ok(write_whole(&out.join("beside.json"), text.as_bytes())?)
}

/// Measured water, intervals and long recordings, each kept when it is there.
fn beside(
    arguments: &Arguments,
    places: &StudyFolders,
    study: &mut StudyTally,
    stop: &AtomicBool,
    bar: &ProgressBar,
) -> anyhow::Result<()> {
    if stop.load(Ordering::Relaxed) {
        return Ok(());
    }
    bar.set_message("recordings of 10 s");
    study.beside.long_s = long_discovery_s()?.into();
    keep(&arguments.out, &study.beside)?;
    if stop.load(Ordering::Relaxed) {
        return Ok(());
    }
    bar.set_message("intervals");
    study.beside.coverage = reference_coverage(&places.out, arguments.seed)?;
    keep(&arguments.out, &study.beside)?;
    if stop.load(Ordering::Relaxed) {
        return Ok(());
    }
    let judged = laws(stop, bar)?;
    if stop.load(Ordering::Relaxed) {
        return Ok(());
    }
    study.beside.laws = judged;
    keep(&arguments.out, &study.beside)?;
    let judged = laboratory(stop, bar)?;
    if stop.load(Ordering::Relaxed) {
        return Ok(());
    }
    study.beside.laboratory = judged;
    keep(&arguments.out, &study.beside)?;
    study.beside.against = against(arguments, stop, bar)?;
    keep(&arguments.out, &study.beside)?;
    if let Some(folder) = &arguments.measured {
        bar.set_message("measured water");
        let cases = judge_measured(folder, &Settings::default(), 14.0, 4)?;
        study.beside.measured = Some(cases.into_iter().map(|case| case.result).collect());
        keep(&arguments.out, &study.beside)?;
    } else {
        bar.suspend(|| eprintln!("measured water is left out: --measured names no folder"));
    }
    Ok(())
}

/// Writes page and pictures; returns the report.
fn write(arguments: &Arguments, study: &StudyTally) -> anyhow::Result<Report> {
    let mut command =
        format!("meniscus discover study --clean {} --seed {}", arguments.clean, arguments.seed);
    if arguments.spacing_mm != 1e3 * SPACING_M {
        command += &format!(" --spacing-mm {}", arguments.spacing_mm);
    }
    let report = report(study, &command);
    write_whole(&arguments.out.join("study.md"), report.markdown().as_bytes())?;
    confusion_png(study, &arguments.out.join("confusion.png"))?;
    detection_png(study, &arguments.out.join("detection.png"))?;
    Ok(report)
}
