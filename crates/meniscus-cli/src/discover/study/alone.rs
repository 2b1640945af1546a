//! Parts of the study that are run alone, too: drawn laws, the second laboratory, and verdicts against references by simulation.

use super::super::super::stop::finish_partial;
use super::Arguments;
use indicatif::ProgressBar;
use meniscus_discover::study::against_simulator::{AgainstSimulator, against_simulator, simulator_checks};
use meniscus_discover::study::error::StudyError;
use meniscus_discover::study::laboratory::checks::laboratory_checks;
use meniscus_discover::study::laboratory::judge::{LaboratoryBench, LaboratoryOutcome};
use meniscus_discover::study::laboratory::trials::laboratory_trials;
use meniscus_discover::study::page::{against_report, laboratory_report, law_report};
use meniscus_discover::study::unnamed::checks::law_checks;
use meniscus_discover::study::unnamed::judge::{LawBench, LawOutcome};
use meniscus_discover::study::unnamed::trials::law_trials;
use meniscus_platform::files::write_whole;
use meniscus_report::Report;
use meniscus_report::checks::{Check, table};
use std::sync::atomic::{AtomicBool, Ordering};

/// Judges `trials` one by one until `stop` is set.
fn each<T, O>(
    trials: &[T],
    stop: &AtomicBool,
    bar: &ProgressBar,
    judge: impl Fn(&T) -> Result<O, StudyError>,
) -> anyhow::Result<Vec<O>> {
    let mut out = Vec::new();
    for trial in trials {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        out.push(judge(trial)?);
        bar.inc(1);
    }
    Ok(out)
}

/// Judges the trials of the drawn law until `stop` is set.
pub(super) fn laws(stop: &AtomicBool, bar: &ProgressBar) -> anyhow::Result<Vec<LawOutcome>> {
    let trials = law_trials();
    begin(bar, "drawing laws", trials.len());
    let bench = LawBench::new()?;
    each(&trials, stop, bar, |trial| bench.judge(trial))
}

/// Judges the trials of the second laboratory until `stop` is set.
pub(super) fn laboratory(stop: &AtomicBool, bar: &ProgressBar) -> anyhow::Result<Vec<LaboratoryOutcome>> {
    let trials = laboratory_trials();
    begin(bar, "second laboratory", trials.len());
    let bench = LaboratoryBench::new()?;
    each(&trials, stop, bar, |trial| bench.judge(trial))
}

/// Starts the bar anew for `work` of `count` trials.
fn begin(bar: &ProgressBar, work: &'static str, count: usize) {
    bar.reset();
    bar.set_length(count as u64);
    bar.set_message(work);
}

/// Part of the study that was run alone, and its page.
struct Alone<'a> {
    /// Name of its files, without their ends.
    stem: &'static str,
    checks: Vec<Check>,
    report: Report,
    /// Outcomes of its trials, as JSON.
    outcomes: String,
    arguments: &'a Arguments,
}

impl Alone<'_> {
    /// Writes page and outcomes, and prints the checks.
    fn write(&self) -> anyhow::Result<()> {
        let write = |end: &str, text: &str| {
            write_whole(&self.arguments.out.join(format!("{}.{end}", self.stem)), text.as_bytes())
        };
        write("md", &self.report.markdown())?;
        write("json", &self.outcomes)?;
        if self.arguments.json {
            println!("{:#}", self.report.json());
        } else {
            print!("{}", table(&self.checks));
            println!("written: {}", self.arguments.out.display());
        }
        Ok(())
    }
}

/// Returns whether all trials were judged, and says so where not.
fn is_whole(judged: usize, stop: &AtomicBool) -> bool {
    finish_partial();
    let stopped = stop.load(Ordering::Relaxed);
    if stopped {
        eprintln!(
            "interrupted: nothing is written; {judged} trials were judged, and the same command starts anew"
        );
    }
    !stopped
}

/// Judges the trials of the drawn law and writes their page.
pub(super) fn laws_alone(arguments: &Arguments, stop: &AtomicBool, bar: &ProgressBar) -> anyhow::Result<()> {
    let judged = laws(stop, bar)?;
    bar.finish_and_clear();
    if !is_whole(judged.len(), stop) {
        return Ok(());
    }
    let report = law_report(&judged, "meniscus discover study --laws-only");
    let outcomes = serde_json::to_string_pretty(&judged)?;
    Alone { stem: "laws", checks: law_checks(&judged), report, outcomes, arguments }.write()
}

/// Judges the trials of the second laboratory and writes their page.
pub(super) fn laboratory_alone(
    arguments: &Arguments,
    stop: &AtomicBool,
    bar: &ProgressBar,
) -> anyhow::Result<()> {
    let judged = laboratory(stop, bar)?;
    bar.finish_and_clear();
    if !is_whole(judged.len(), stop) {
        return Ok(());
    }
    let report = laboratory_report(&judged, "meniscus discover study --laboratory-only");
    let outcomes = serde_json::to_string_pretty(&judged)?;
    Alone { stem: "laboratory", checks: laboratory_checks(&judged), report, outcomes, arguments }.write()
}

/// Judges the trials against references by simulation; the simulations are kept in the cache.
pub(super) fn against(
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
pub(super) fn references_alone(
    arguments: &Arguments,
    stop: &AtomicBool,
    bar: &ProgressBar,
) -> anyhow::Result<()> {
    let judged = against(arguments, stop, bar)?;
    bar.finish_and_clear();
    finish_partial();
    let report = against_report(&judged, "meniscus discover study --references-only");
    let outcomes = serde_json::to_string_pretty(&judged)?;
    Alone { stem: "references", checks: simulator_checks(&judged), report, outcomes, arguments }.write()
}
