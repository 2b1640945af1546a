//! `meniscus simulate validate`: the simulator against theory.

use crate::outputs::check_folder;
use meniscus_platform::files::write_whole;
use meniscus_report::checks::table;
use meniscus_sph::validate::{convergence, convergence_report, decay_png, report, validate, work};
use std::path::{Path, PathBuf};

/// Compare the simulator with theory.
///
/// Frequencies, decays, noise, energy, escapes and cost are compared. The whole table takes about 12 minutes on two processors,
/// --quick about two. A missed target is reported and does not fail the command.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  meniscus simulate validate --quick --out validation")]
pub(crate) struct Arguments {
    /// Only the first mode, glycerine, energy and cost.
    #[arg(long, help_heading = "Method")]
    quick: bool,
    /// Only the effects, at spacings of 7, 5 and 3.5 mm; about 20 minutes.
    #[arg(long, help_heading = "Method", conflicts_with = "quick")]
    convergence: bool,
    /// Folder for validate.html or convergence.html, the same as .md, and the pictures; it is made.
    #[arg(long, value_name = "DIR", default_value = "validation", help_heading = "Output")]
    out: PathBuf,
    /// Print one JSON object with an array of checks.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Runs the verb.
pub(super) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let Arguments { quick, convergence, json, out } = arguments;
    check_folder(out)?;
    if *convergence {
        return over_the_spacing(out, *json);
    }
    // The bar counts hundredths of the estimated work, so that its time left is smooth.
    let bar = crate::bars::bar((100.0 * work(*quick)) as u64);
    bar.set_style(crate::bars::style("{msg:22} {wide_bar} {percent} %, {left}")?);
    // As one of the threads that share the work, as in `simulate`.
    let outcome = rayon::scope(|_| {
        validate(*quick, |done, case| {
            bar.set_message(String::from(case));
            bar.set_position((100.0 * done) as u64);
        })
    })?;
    bar.finish_and_clear();
    let picture = |index: usize| format!("decay-{index}.png");
    for (index, ringing) in outcome.ringings.iter().enumerate() {
        decay_png(ringing, &out.join(picture(index)))?;
    }
    let command = if *quick { "meniscus simulate validate --quick" } else { "meniscus simulate validate" };
    let report = report(&outcome, command, picture)?;
    write_whole(&out.join("validate.html"), report.html().as_bytes())?;
    let page = out.join("validate.md");
    write_whole(&page, report.markdown().as_bytes())?;
    if *json {
        println!("{}", report.json());
    } else {
        print!("{}", table(&outcome.checks));
        println!("written: {} and {} pictures beside it", page.display(), outcome.ringings.len());
    }
    Ok(())
}

/// Runs `--convergence`.
fn over_the_spacing(out: &Path, json: bool) -> anyhow::Result<()> {
    let bar = crate::bars::bar(10_000);
    bar.set_style(crate::bars::style("{msg:32} {wide_bar} {percent} %, {left}")?);
    let rows = rayon::scope(|_| {
        convergence(|done, case| {
            bar.set_message(String::from(case));
            bar.set_position((1e4 * done) as u64);
        })
    })?;
    bar.finish_and_clear();
    let report = convergence_report(&rows, "meniscus simulate validate --convergence");
    write_whole(&out.join("convergence.html"), report.html().as_bytes())?;
    let page = out.join("convergence.md");
    write_whole(&page, report.markdown().as_bytes())?;
    if json {
        println!("{}", report.json());
    } else {
        print!("{}", report.markdown());
        println!("written: {}", page.display());
    }
    Ok(())
}
