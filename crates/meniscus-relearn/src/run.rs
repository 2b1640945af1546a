//! Stages of a run in their order.

use crate::correct::correct;
use crate::error::RelearnError;
use crate::folder::Folder;
use crate::identify::{Identified, MeasuredRecording, NUMERICAL_VISCOSITY_M2_S, identify};
use crate::judge::judge;
use crate::liquid_file::{Sources, liquid_text};
use crate::motions::{SetName, SimulatedRecording, measured, scripted, strength};
use crate::plan::{LiquidSource, Plan};
use crate::progress::Progress;
use crate::report::{Content, write};
use crate::simulate::{FailedSimulation, Pass, Shard, Simulations, Workers};
use crate::train::{Recordings, is_trained, keeps_its_fill, train};
use meniscus::blob::{CRC, Model};
use meniscus_data::effects::Effects;
use meniscus_data::liquids::Liquid;
use meniscus_data::recording::Recording;
use meniscus_data::validity::Validity;
use meniscus_discover::recordings::record::Drive;
use meniscus_platform::files::{AlignedBytes, write_whole};
use meniscus_report::checks::Check;
use meniscus_sph::Setup;
use std::sync::atomic::AtomicBool;

mod estimates;

/// Stage of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// The liquid from recordings, or as stated.
    Identify,
    /// Recordings of the inside by the simulator.
    Simulate,
    /// Model from these recordings.
    Train,
    /// Correction on the measured recordings.
    Correct,
    /// Judgement on recordings that no stage saw, and the report.
    Report,
}

impl Stage {
    /// All stages in their order.
    pub const ALL: [Self; 5] = [Self::Identify, Self::Simulate, Self::Train, Self::Correct, Self::Report];

    /// Name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Identify => "identify",
            Self::Simulate => "simulate",
            Self::Train => "train",
            Self::Correct => "correct",
            Self::Report => "report",
        }
    }
}

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
            let recordings =
                Recordings { training: &training, validation: &validation, liquid: &liquid.label };
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

    /// Writes the liquid file, if it is not there, and returns the result in a sentence.
    fn identify(&self) -> Result<String, RelearnError> {
        let path = self.folder.liquid();
        let (liquid, sources, sentence) = match &self.plan.liquid {
            LiquidSource::Stated(name) => {
                let liquid = Liquid::load(name)?;
                let sentence = format!("The liquid is {} as stated", liquid.name);
                (liquid, Sources::one(&format!("as stated in {name}")), sentence)
            }
            source @ LiquidSource::Identified { name, density_kg_m3, law, .. } => {
                let identified = self.fitted(*density_kg_m3, *law)?;
                let sentence = format!("{name}: {}", identified.sentence());
                let (liquid, sources) = identified.liquid(source).ok_or_else(|| RelearnError::Malformed {
                    path: self.folder.identified(),
                    fault: "it is of a stated liquid".into(),
                })?;
                (liquid, sources, sentence)
            }
        };
        // A liquid file that is there may have been edited by a person, who has the last word.
        if !path.exists() {
            write_whole(&path, liquid_text(&liquid, &sources).as_bytes())?;
        }
        Ok(sentence)
    }

    /// The fit of the liquid: that of an earlier run, or a new one.
    fn fitted(&self, density_kg_m3: f64, law: crate::identify::Law) -> Result<Identified, RelearnError> {
        let path = self.folder.identified();
        let malformed = |fault: String| RelearnError::Malformed { path: path.clone(), fault };
        if let Ok(text) = std::fs::read_to_string(&path) {
            return serde_json::from_str(&text).map_err(|error| malformed(error.to_string()));
        }
        let about = format!("fit of the liquid to {} recordings", self.measured.len());
        self.progress.begins(Stage::Identify, &about);
        let identified = identify(self.measured, &self.plan.glass, density_kg_m3, law)?;
        let text = serde_json::to_string_pretty(&identified).map_err(|error| malformed(error.to_string()))?;
        write_whole(&path, text.as_bytes())?;
        self.progress.ends(&identified.sentence());
        Ok(identified)
    }

    /// The liquid in the folder.
    fn liquid(&self) -> Result<SimulatedLiquid, RelearnError> {
        let path = self.folder.liquid();
        let text = std::fs::read_to_string(&path).map_err(|cause| meniscus_platform::files::FileError {
            path: path.clone(),
            doing: "read",
            cause,
        })?;
        let liquid = Liquid::parse(&path.to_string_lossy(), &text)?;
        let label = match &self.plan.liquid {
            LiquidSource::Stated(name) if Liquid::load(name).is_ok_and(|stated| stated == liquid) => {
                name.clone()
            }
            // Another liquid of the same name must not pass for this one.
            _ => format!("liquid.toml (checksum {:08x})", CRC.checksum(text.as_bytes())),
        };
        Ok(SimulatedLiquid { liquid, label })
    }

    /// Recordings that are to be simulated, set after set.
    fn planned(&self, liquid: &Liquid) -> Result<Vec<SimulatedRecording>, RelearnError> {
        let Plan { seconds, sizes, glass, .. } = self.plan;
        let drives: Vec<(String, &Drive)> =
            self.measured.iter().map(|one| (one.record.name.clone(), &one.record.drive)).collect();
        let scale = match self.plan.strength {
            Some(scale) => scale,
            None => strength(liquid, glass, *seconds, &drives)?,
        };
        let mut planned = measured(&drives, *seconds, &self.folder.motions(), sizes.training / 3)?;
        planned.extend(scripted(SetName::Training, sizes.training - planned.len(), scale));
        planned.extend(scripted(SetName::Validation, sizes.validation, scale));
        planned.extend(scripted(SetName::HeldOut, sizes.held_out, scale));
        Ok(planned)
    }

    /// Set-up of the simulator.
    fn setup(&self, liquid: &Liquid) -> Result<Setup, RelearnError> {
        let setup = Setup {
            glass: self.plan.glass,
            liquid: liquid.clone(),
            spacing_m: self.plan.spacing_m,
            seed: 0,
            no_slip: true,
            effects: Effects::default(),
            step_s: None,
        };
        let refused = |fault: String| RelearnError::Simulator { liquid: liquid.name.clone(), fault };
        let step_s = setup.longest_step_s().map_err(|error| refused(error.to_string()))?;
        if step_s < estimates::SHORTEST_STEP_S {
            return Err(refused(format!(
                "it needs steps of {:.2} us, and {:.2} us is the shortest that ends within a day: choose a larger \
                 --spacing-mm, or lower largest_viscosity_pa_s in {}",
                1e6 * step_s,
                1e6 * estimates::SHORTEST_STEP_S,
                self.folder.liquid().display()
            )));
        }
        Ok(setup)
    }

    /// Simulates what is missing.
    fn simulate(
        &self,
        liquid: &SimulatedLiquid,
        planned: &[SimulatedRecording],
    ) -> Result<Pass, RelearnError> {
        let setup = self.setup(&liquid.liquid)?;
        let simulations = self.simulations(&setup, liquid);
        let missing = planned.iter().filter(|one| simulations.finished(one).is_none()).count();
        if missing > 0 {
            let about = estimates::simulations(self.plan, missing, planned.len(), self.workers);
            self.progress.begins(Stage::Simulate, &about);
        }
        let pass = simulations.run(planned, self.workers, self.stop, self.progress)?;
        if missing > 0 {
            self.progress.ends(&said_of(&pass, planned.len()));
        }
        Ok(pass)
    }

    /// Simulations of `liquid` by `setup` in the folder.
    fn simulations<'s>(&'s self, setup: &'s Setup, liquid: &'s SimulatedLiquid) -> Simulations<'s> {
        let folder = self.folder.recordings();
        Simulations { setup, seconds: self.plan.seconds, liquid: &liquid.label, folder }
    }

    /// Finished recordings of the three sets, without those that spilled so much that their fill is another.
    fn sets(
        &self,
        liquid: &SimulatedLiquid,
        planned: &[SimulatedRecording],
        failed: &[FailedSimulation],
    ) -> Result<[Vec<Recording>; 3], RelearnError> {
        let setup = self.setup(&liquid.liquid)?;
        let simulations = self.simulations(&setup, liquid);
        let mut sets: [Vec<Recording>; 3] = Default::default();
        for (set, name) in sets.iter_mut().zip(SetName::ALL) {
            let of_set = planned.iter().filter(|one| one.set == name);
            let wanted = of_set.clone().count();
            set.extend(of_set.filter_map(|one| simulations.finished(one)).filter(keeps_its_fill));
            // Three quarters of a set still are that set.
            if set.len() < (3 * wanted).div_ceil(4).max(1) {
                let first = failed.first().map_or_else(
                    || {
                        format!(
                            "{} of {wanted} recordings spilled too much or are missing",
                            wanted - set.len()
                        )
                    },
                    |one| format!("{}: {}", one.recording, one.why),
                );
                return Err(RelearnError::Failed {
                    failed: wanted - set.len(),
                    planned: planned.len(),
                    set: name.name(),
                    first,
                });
            }
        }
        Ok(sets)
    }

    /// Judges the finished model, beside the oracle's where one is asked for, and writes the report.
    fn report(
        &self,
        liquid: &SimulatedLiquid,
        held_out: &[Recording],
        training: &[Recording],
        mut outcome: Outcome,
    ) -> Result<Outcome, RelearnError> {
        let blob = AlignedBytes::read(&self.folder.model())?;
        let mut judged_on = held_out.to_vec();
        let mut beside = Vec::new();
        if let Some(name) = &self.plan.oracle {
            let (oracle, recordings) = self.oracle(name, &liquid.liquid)?;
            let own = judge(&oracle, &recordings, self.plan.seed)?;
            beside.extend(own.checks.iter().map(|check| {
                Check::informational(
                    format!("oracle_{}", check.name),
                    check.value.unwrap_or(f64::NAN),
                    check.unit,
                )
            }));
            // Both are judged on the true liquid.
            judged_on = recordings;
        }
        self.progress.begins(Stage::Report, &format!("{} held-out recordings", judged_on.len()));
        let judged = judge(&blob, &judged_on, self.plan.seed)?;
        let spilled_ml = |recording: &Recording| 1e6 * recording.spilled_m3.last().copied().unwrap_or(0.0);
        let most = training.iter().chain(held_out).map(spilled_ml).fold(0.0, f64::max);
        beside.push(Check::informational("largest_spill", most, "ml"));
        let header = Model::load(&blob)?.header;
        outcome.sentences.extend(Validity::of(&header).sentence);
        let nu = liquid.liquid.rheology.consistency / liquid.liquid.density_kg_m3;
        if liquid.liquid.rheology.is_newtonian() && nu < NUMERICAL_VISCOSITY_M2_S {
            outcome.sentences.push(format!(
                "The kinematic viscosity {nu:.1e} m2/s is below the simulator's own {NUMERICAL_VISCOSITY_M2_S:.1e} m2/s: the damping \
                 at the wall is that of the liquid, the damping inside is the simulator's"
            ));
        }
        let content = Content {
            liquid: &liquid.liquid.name,
            command: self.command,
            sentences: &outcome.sentences,
            judged: &judged,
            beside: &beside,
        };
        write(self.folder, &content)?;
        self.progress.ends(&format!("{}", self.folder.page().display()));
        outcome.finished = Stage::Report;
        outcome.checks = judged.checks.into_iter().chain(beside).collect();
        Ok(outcome)
    }

    /// Model of the true liquid `name`, learned with the same settings, and its held-out recordings.
    fn oracle(&self, name: &str, learned: &Liquid) -> Result<(AlignedBytes, Vec<Recording>), RelearnError> {
        let scale = match self.plan.strength {
            Some(scale) => scale,
            None => {
                let drives: Vec<(String, &Drive)> =
                    self.measured.iter().map(|one| (one.record.name.clone(), &one.record.drive)).collect();
                strength(learned, &self.plan.glass, self.plan.seconds, &drives)?
            }
        };
        let plan = Plan {
            liquid: LiquidSource::Stated(name.into()),
            strength: Some(scale),
            recordings: Vec::new(),
            oracle: None,
            ..self.plan.clone()
        };
        let folder = self.folder.oracle();
        let run = Run { plan: &plan, folder: &folder, measured: &[], ..*self };
        run.go(Stage::Correct)?;
        let liquid = run.liquid()?;
        let planned = run.planned(&liquid.liquid)?;
        let [_, _, held_out] = run.sets(&liquid, &planned, &[])?;
        Ok((AlignedBytes::read(&folder.model())?, held_out))
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
