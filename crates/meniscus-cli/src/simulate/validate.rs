//! `meniscus simulate validate`: the simulator against theory.

use anyhow::Context;
use indicatif::{ProgressBar, ProgressStyle};
use meniscus_platform::files::write_whole;
use meniscus_report::checks::table;
use meniscus_sph::validate::{decay_png, report, validate, work};
use std::path::PathBuf;

/// Hold the simulator against theory: frequencies, decays, noise, energy, escapes, cost.
///
/// The whole table takes about 12 minutes on two processors, the quick part of it about two. A missed
/// target is reported, and is no error of the command.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  meniscus simulate validate --quick --out validation")]
pub(crate) struct Arguments {
    /// Only the first mode, glycerine, energy and cost.
    #[arg(long)]
    quick: bool,
    /// Report on standard output as one JSON object with an array of checks.
    #[arg(long)]
    json: bool,
    /// The directory to write validate.html (the report, one file), validate.md and the pictures into.
    #[arg(long, value_name = "DIR", default_value = "validation")]
    out: PathBuf,
}

/// Runs the verb.
pub(super) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let Arguments { quick, json, out } = arguments;
    std::fs::create_dir_all(out).with_context(|| format!("cannot make the directory {}", out.display()))?;
    // The bar counts hundredths of the estimated work, so that its time left is smooth.
    let bar = ProgressBar::new((100.0 * work(*quick)) as u64);
    bar.set_style(ProgressStyle::with_template("{msg:22} {wide_bar} {percent} %, {eta} left")?);
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
    std::fs::write(&page, report.markdown()).with_context(|| format!("cannot write {}", page.display()))?;
    if *json {
        println!("{}", report.json());
    } else {
        print!("{}", table(&outcome.checks));
        println!("written: {} and {} pictures beside it", page.display(), outcome.ringings.len());
    }
    Ok(())
}
