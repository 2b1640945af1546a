//! Second stage of a run: the recordings of the three sets.

use super::{Run, SimulatedLiquid, estimates, said_of};
use crate::error::RelearnError;
use crate::motions::{SetName, SimulatedRecording, measured, scripted, strength};
use crate::plan::Plan;
use crate::simulate::{FailedSimulation, Pass, Simulations};
use crate::stage::Stage;
use crate::train::keeps_its_fill;
use meniscus_data::effects::Effects;
use meniscus_data::liquids::Liquid;
use meniscus_data::recording::Recording;
use meniscus_discover::recordings::record::Drive;
use meniscus_sph::Setup;

impl Run<'_> {
    /// Recordings that are to be simulated, set after set.
    pub(super) fn planned(&self, liquid: &Liquid) -> Result<Vec<SimulatedRecording>, RelearnError> {
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
    pub(super) fn simulate(
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
    pub(super) fn sets(
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
}
