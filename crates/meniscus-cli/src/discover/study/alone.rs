//! Parts of the study that are run alone, too: drawn laws, and verdicts against references by simulation.

use super::super::super::stop::finish_partial;
use super::Arguments;
use indicatif::ProgressBar;
use meniscus_discover::study::against_simulator::{AgainstSimulator, against_simulator, simulator_checks};
use meniscus_discover::study::page::{against_report, law_report};
use meniscus_discover::study::unnamed::checks::law_checks;
use meniscus_discover::study::unnamed::judge::{LawBench, LawOutcome};
use meniscus_discover::study::unnamed::trials::law_trials;
use meniscus_platform::files::write_whole;
use meniscus_report::checks::table;
use std::sync::atomic::{AtomicBool, Ordering};

/// Judges the trials of the drawn law until `stop` is set.
pub(super) fn laws(stop: &AtomicBool, bar: &ProgressBar) -> anyhow::Result<Vec<LawOutcome>> {
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
pub(super) fn laws_alone(arguments: &Arguments, stop: &AtomicBool, bar: &ProgressBar) -> anyhow::Result<()> {
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
