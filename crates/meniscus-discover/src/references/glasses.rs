//! Glasses that are simulated as references, and the work that they are.

use super::ReferenceSettings;
use crate::insert::simulated::{Resolution, SimulatedGlass};
use crate::insert::simulator::GlassSimulator;
use crate::recordings::record::Record;
use crate::recordings::stated::Known;
use crate::sizing::error::SizingError;
use crate::sizing::simulations::{Simulations, Wanted};
use crate::sizing::workload::SimulationProgress;
use std::sync::PoisonError;

/// One glass in units of the stated liquid and of the spacing; each has a packing of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlassFactors {
    /// Factor on the viscosity.
    pub viscosity: f64,
    /// Factor on the spacing.
    pub spacing: f64,
}

/// Glasses of the references: the stated liquid and one that is a fifth more viscous, at two spacings. The finer one
/// costs about twice as much.
pub const GLASSES: [GlassFactors; 6] = [
    GlassFactors { viscosity: 1.0, spacing: 1.0 },
    GlassFactors { viscosity: 1.0, spacing: 1.0 },
    GlassFactors { viscosity: 1.0, spacing: 0.85 },
    GlassFactors { viscosity: 1.2, spacing: 1.0 },
    GlassFactors { viscosity: 1.2, spacing: 0.85 },
    GlassFactors { viscosity: 1.0, spacing: 0.92 },
];

/// Glass of a reference.
#[derive(Clone, Debug)]
pub struct ReferenceGlass {
    /// Facts that are known of it.
    pub known: Known,
    /// Glass in the simulator, and how a camera without faults sees it.
    pub seen: SimulatedGlass,
}

/// Simulations that the references need.
#[derive(Clone, Debug)]
pub struct ReferencePlan {
    /// Glasses.
    pub glasses: Vec<ReferenceGlass>,
    /// Simulations of each glass, recording by recording.
    pub wanted: Vec<Vec<Wanted>>,
}

impl ReferencePlan {
    /// Plans the references of `records` of the liquid `known`.
    ///
    /// # Errors
    /// [`SizingError::NotSimulated`], when a motion or the glass cannot be simulated.
    pub fn new(
        records: &[Record],
        known: &Known,
        settings: &ReferenceSettings,
        simulator: &dyn GlassSimulator,
    ) -> Result<Self, SizingError> {
        let refused = |reason| SizingError::NotSimulated { reason };
        let mut plan = Self { glasses: Vec::new(), wanted: Vec::new() };
        for (packing, factors) in GLASSES.iter().enumerate() {
            let known = Known { viscosity_pa_s: factors.viscosity * known.viscosity_pa_s, ..*known };
            let resolution = Resolution {
                spacing_m: factors.spacing * settings.spacing_m,
                seed: settings.seed + packing as u64,
            };
            let seen = SimulatedGlass::of(simulator, &known, &[], resolution).map_err(refused)?;
            let one =
                |record: &Record| Ok(Wanted { setup: seen.setup.clone(), course: seen.course(record)? });
            let wanted = records.iter().map(one).collect::<Result<Vec<_>, String>>().map_err(refused)?;
            plan.wanted.push(wanted);
            plan.glasses.push(ReferenceGlass { known, seen });
        }
        Ok(plan)
    }

    /// Books the work of the plan and tells the observer of `simulations` of it, before the first one begins.
    pub(super) fn announce(&self, simulations: &Simulations<'_>) {
        let mut workload = simulations.workload.lock().unwrap_or_else(PoisonError::into_inner);
        for wanted in &self.wanted {
            let frames = wanted.iter().map(|one| one.course.frames).sum();
            if let Some(first) = wanted.first() {
                workload.expect(&first.setup, frames, wanted.len(), 1);
            }
        }
        let left_s = workload.estimate_s(simulations.simulator, rayon::current_num_threads());
        let progress = SimulationProgress { done: 0, expected: workload.simulations(), left_s };
        drop(workload);
        (simulations.watch)(progress);
    }
}
