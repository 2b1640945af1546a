//! Report of a run on standard output and in the --out folder.

use super::config::{Output, RunConfig, Targets};
use anyhow::{Context, ensure};
use meniscus_platform::files::{FolderLock, check_writable, write_whole};
use meniscus_report::checks::Check;
use serde_json::Value;

/// Name of the report in the --out folder.
const REPORT: &str = "run.json";

/// Makes the --out folder before the run: one that cannot be written would lose the report after it. An earlier report stays
/// until this one is whole. Nobody else writes into the folder until the lock is dropped.
pub(super) fn announce(config: &RunConfig) -> anyhow::Result<FolderLock> {
    let lock = FolderLock::take(&config.out).context("the --out folder cannot be used")?;
    check_writable(&config.out.join(REPORT)).context("the --out folder cannot be used")?;
    Ok(lock)
}

/// Says which position of the camera is assumed where no setup has it.
pub(super) fn say_position(config: &RunConfig) {
    if config.setup.is_none() {
        eprintln!(
            "without --setup the camera is assumed level, 400 mm before the model's glass and 30 mm above its foot; \
             `meniscus setup` measures its position"
        );
    }
}

/// Prints the report as text or JSON, then writes it into the --out folder: a disk that has become full
/// does not take the summary.
pub(super) fn print(config: &RunConfig, json: &Value, text: &str) -> anyhow::Result<()> {
    let json = serde_json::to_string_pretty(json)?;
    match config.output {
        Output::Json => println!("{json}"),
        Output::Text => print!("{text}"),
    }
    Ok(write_whole(&config.out.join(REPORT), format!("{json}\n").as_bytes())?)
}

impl RunConfig {
    /// Fails if a check missed its target and that is to be enforced.
    pub(super) fn judge(&self, checks: &[Check]) -> anyhow::Result<()> {
        let met = self.targets == Targets::Reported || checks.iter().all(|check| !check.missed());
        ensure!(met, "a check missed its target");
        Ok(())
    }
}
