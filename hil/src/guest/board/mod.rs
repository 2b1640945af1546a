//! The edge board: Debian under systemd, and what a person does at it, step by step.
//!
//! ```text
//! install    dpkg -i, the first start, a re-plug, a kill, a hang, a full journal, an upgrade
//! power-on   nothing: the service has to start by itself; then the package goes
//! ```
//! This program stands for the plug of the camera and for the person's hands; it is no part of the board, and is
//! started beside systemd by the guest's first process.

mod install;
mod power_on;
mod service;
mod system;

use super::MARK;
use meniscus_hil::FaultList;
use meniscus_hil::device::{Device, Film};
use meniscus_hil::vhci::Plugged;
use serde_json::{Value, json};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

type Facts = Result<Value, Box<dyn Error>>;

/// A step: its name, and what is done.
type Step = (&'static str, fn(&mut Board) -> Facts);

/// The board with its camera.
struct Board {
    film: PathBuf,
    camera: Option<Plugged>,
}

impl Board {
    fn plug(&mut self) -> Result<(), Box<dyn Error>> {
        let film = Film::open(&self.film).map_err(|error| format!("{}: {error}", self.film.display()))?;
        let device = Device::new(Box::new(film), None, FaultList::default(), 1);
        self.camera = Some(Plugged::new(device)?);
        Ok(())
    }

    fn unplug(&mut self) -> Result<(), Box<dyn Error>> {
        if let Some(camera) = self.camera.take() {
            camera.unplug()?;
        }
        Ok(())
    }
}

/// Runs the steps of a phase, a line of facts each. A step that cannot be done is reported, and the next one is tried.
pub(crate) fn run(phase: &str, film: &Path) -> ExitCode {
    let steps: &[Step] = match phase {
        "install" => install::STEPS,
        "power-on" => power_on::STEPS,
        other => {
            eprintln!("no phase is called `{other}`; there are install and power-on");
            return ExitCode::FAILURE;
        }
    };
    let mut board = Board { film: film.into(), camera: None };
    // Plugged in before the power came.
    if let Err(error) = board.plug() {
        eprintln!("{error}");
        return ExitCode::FAILURE;
    }
    for (name, step) in steps {
        let begun = Instant::now();
        let facts = step(&mut board).unwrap_or_else(|error| json!({ "error": error.to_string() }));
        let guest_s = begun.elapsed().as_secs_f64();
        println!("{MARK}{}", json!({ "scenario": name, "facts": facts, "guest_s": guest_s }));
    }
    ExitCode::SUCCESS
}
