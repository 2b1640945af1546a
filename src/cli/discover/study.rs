//! `meniscus discover study`: hidden effects, clean glasses, measured water.

use anyhow::{Context, anyhow};
use indicatif::{ProgressBar, ProgressStyle};
use meniscus::offline::discover::study::simulate;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

/// Hide effects in simulated recordings and see whether discovery finds them.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Folder in which simulated glasses are kept; what is missing is simulated.
    #[arg(long, default_value = "out/discover-cache", value_name = "DIR")]
    cache: PathBuf,
    /// Only simulate what is missing.
    #[arg(long)]
    simulate_only: bool,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    static STOP: AtomicBool = AtomicBool::new(false);
    ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    })
    .context("Ctrl-C cannot be watched")?;
    let bar = ProgressBar::new(0);
    bar.set_style(ProgressStyle::with_template("simulating {wide_bar} {pos}/{len} glasses, {eta} left")?);
    let told = |done: usize, all: usize| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    };
    simulate(&arguments.cache, &STOP, told).map_err(|why| anyhow!(why))?;
    bar.finish_and_clear();
    Ok(())
}
