//! Stages of a run in their order.

mod estimates;
mod judgement;
mod liquid;
mod sets;

use crate::correct::correct;
use crate::error::RelearnError;
use crate::folder::Folder;
use crate::identify::MeasuredRecording;
use crate::plan::Plan;
use crate::progress::Progress;
use crate::simulate::{Pass, Shard, Workers};
use crate::stage::Stage;
use crate::train::{Recordings, is_trained, train};
use meniscus_data::liquids::Liquid;
use meniscus_report::checks::Check;
use std::sync::atomic::AtomicBool;

/// Run of a plan in a folder.
pub struct Run<'a> {
    /// Settings that determine the result.
    pub plan: &'a Plan,
    /// Folder of all files.
    pub folder: &'a Folder,
    /// Measured recordings, in the order of the plan.
    pub measured: &'a [MeasuredRecording],
    /// Base model.
    pub base: &'a [u8],
    /// Command, for provenance and report.
    pub command: &'a str,
    /// Processors, and the part of the simulations that is done here.
    pub workers: Workers,
    /// Raised by whoever wants the run to end; it then ends where it can be continued.
    pub stop: &'a AtomicBool,
    /// Observer.
    pub progress: &'a dyn Progress,
}

/// Result of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Last stage that is finished.
    pub finished: Stage,
    /// Results in sentences.
    pub sentences: Vec<String>,
    /// Figures, empty before the last stage.
    pub checks: Vec<Check>,
}

/// Liquid of the simulations, with its label in commands.
struct SimulatedLiquid {
    liquid: Liquid,
    label: String,
}

impl Run<'_> {
    /// Goes through the stages up to `until`; finished ones are not run again.
    ///
    /// # Errors
    /// [`RelearnError`]; what is finished stays, and the same run continues from there.
    pub fn go(&self, until: Stage) -> Result<Outcome, RelearnError> {
        self.plan.check()?;
        self.plan.bind(self.folder)?;
        let mut outcome = Outcome { finished: Stage::Identify, sentences: Vec::new(), checks: Vec::new() };
        outcome.sentences.push(self.identify()?);
        if until == Stage::Identify {
            return Ok(outcome);
        }
        let liquid = self.liquid()?;
        let planned = self.planned(&liquid.liquid)?;
        let pass = self.simulate(&liquid, &planned)?;
        outcome.finished = Stage::Simulate;
        outcome.sentences.push(said_of(&pass, planned.len()));
        if until == Stage::Simulate || self.workers.shard != Shard::WHOLE {
            return Ok(outcome);
        }
        let [training, validation, held_out] = self.sets(&liquid, &planned, &pass.failed)?;
        if !is_trained(self.folder, &liquid.label) {
            self.folder.forget_models()?;
            let about = estimates::training(&self.plan.hyperparameters.schedule, &training);
            self.progress.begins(Stage::Train, &about);
            let recordings = Recordings {
                training: &training,
                validation: &validation,
                liquid: &liquid.label,
                rheology: liquid.liquid.rheology,
            };
            train(self.plan, &recordings, self.base, self.folder, self.command, self.stop, self.progress)?;
            self.progress.ends(&format!("{}", self.folder.trained().display()));
        }
        outcome.finished = Stage::Train;
        if until == Stage::Train {
            return Ok(outcome);
        }
        if !self.folder.model().exists() {
            let about = format!("correction by {} measured recordings", self.measured.len());
            self.progress.begins(Stage::Correct, &about);
            let (seed, quiet) = (self.plan.seed, self.progress.quiet());
            correct(self.measured, &validation, self.folder, seed, quiet, self.stop)?;
            self.progress.ends(&format!("{}", self.folder.model().display()));
        }
        outcome.finished = Stage::Correct;
        if until == Stage::Correct {
            return Ok(outcome);
        }
        self.report(&liquid, &held_out, &training, outcome)
    }
}

/// Returns what a pass over the simulations did.
fn said_of(pass: &Pass, planned: usize) -> String {
    let finished = pass.simulated + pass.reused;
    let mut text = format!("{finished} of {planned} recordings are simulated");
    if let Some(first) = pass.failed.first() {
        text += &format!("; {} failed, the first: {}", pass.failed.len(), first.why);
    }
    text
}
