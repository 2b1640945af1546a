//! `meniscus dump`: what a camera says at its first connection, as a file.

use super::bus;
use anyhow::{Context, bail};
use meniscus_platform::files::write_whole;
use meniscus_usb::camera::{Settings, dump};
use std::path::PathBuf;

/// Write down what the camera says at its first connection.
///
/// The file has the descriptors, every control request with its answer (identity, calibration, probe
/// and commit) and the headers of the first ten frames of each stream, as JSON. A simulated camera can
/// be built from it, so a dump of a camera that does not work is the best bug report. It has the
/// camera's serial numbers in it, and no image.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "Examples:\n  meniscus dump --out camera.json\n  meniscus dump --simulated --out simulated.json"
)]
pub(crate) struct Arguments {
    /// The file; it is replaced.
    #[arg(long)]
    out: PathBuf,
    /// Ask the simulated camera instead, with a trouble by name or number.
    #[arg(long, value_name = "TROUBLE", num_args = 0..=1, default_missing_value = "")]
    simulated: Option<String>,
    /// Only the camera with this serial number (the one that USB shows).
    #[arg(long)]
    serial: Option<String>,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
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
