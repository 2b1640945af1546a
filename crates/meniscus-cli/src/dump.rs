//! `meniscus dump`: what a camera says at its first connection, as a file.

use super::bus;
use anyhow::{Context, bail};
use meniscus_platform::files::{check_writable, write_whole};
use meniscus_usb::camera::{Settings, dump};
use std::path::PathBuf;

/// Write a camera's answers at its first connection, for a bug report.
///
/// The JSON file has the descriptors, every control request with its answer (identity, calibration, probe and commit) and the
/// headers of the first ten frames of each stream. It has the camera's serial numbers, and no image. A simulated camera can be
/// built from it.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus dump --out camera.json\n  meniscus dump --simulated --out simulated.json"
)]
pub(crate) struct Arguments {
    /// Ask a simulated camera instead, with a trouble by name or number.
    #[arg(
        long,
        value_name = "TROUBLE",
        num_args = 0..=1,
        default_missing_value = "",
        help_heading = "Camera"
    )]
    simulated: Option<String>,
    /// Serial number of the only camera that is taken, as USB shows it.
    #[arg(long, help_heading = "Camera")]
    serial: Option<String>,
    /// File to write; an old one is replaced.
    #[arg(long, help_heading = "Output")]
    out: PathBuf,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    check_writable(&arguments.out)?;
    let settings = Settings { serial: arguments.serial.clone(), ..Settings::default() };
    let (dump, ended) = match &arguments.simulated {
        Some(trouble) => dump(bus::simulated(trouble)?, settings),
        None => dump(bus::machine()?, settings),
    };
    if !dump.controls.is_empty() {
        let text = serde_json::to_string_pretty(&dump)?;
        write_whole(&arguments.out, format!("{text}\n").as_bytes())
            .context("the --out file cannot be used")?;
        let (controls, headers) = (dump.controls.len(), dump.depth.len() + dump.infrared.len());
        println!("{}: {controls} control requests, {headers} headers", arguments.out.display());
    }
    match ended {
        Some(error) if dump.controls.is_empty() => Err(error.into()),
        Some(error) => bail!("the dump ends early: {error}"),
        None => Ok(()),
    }
}
