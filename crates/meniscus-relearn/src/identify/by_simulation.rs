//! Liquid by simulation: the simulator is fitted to the recordings, from where the reduced model stands.
//!
//! The reduced model is linear. A real slosh is steeper, and what is steep about it is taken for viscosity: of glycerine the
//! reduced model finds 0.6 to 0.75 of the truth, of water ten times and more. The simulator has the steep wave. Each viscosity that is
//! tried is simulated in the recorded motions ([`meniscus_discover::sizing::search::SizeSearch`]): first with coarse particles over a factor of 25, then with those of
//! the training in several packings. A law with more numbers is fitted as a flow curve (`law_by_simulation`).
//!
//! ```text
//! interval: curvature of the misfit, scatter of the packings, errors of spacing and simulator    (meniscus_discover::sizing::interval)
//! ```

use super::identified::{BySimulation, Identified};
use super::measured::MeasuredRecording;
use super::viscosity::calibration;
use crate::error::RelearnError;
use crate::law::Law;
use crate::progress::Progress;
use crate::stage::Stage;
use meniscus::reduced::effects::{Active, find};
use meniscus_discover::fitting::fit::Free;
use meniscus_discover::recordings::record::Record;
use meniscus_discover::recordings::stated::Known;
use meniscus_discover::sizing::candidate::SizingCandidate;
use meniscus_discover::sizing::error::SizingError;
use meniscus_discover::sizing::forward::Point;
use meniscus_discover::sizing::glass::{GlassForward, Matched};
use meniscus_discover::sizing::interval::{Component, spacing_error};
use meniscus_discover::sizing::projection::Observed;
use meniscus_discover::sizing::search::Start;
use meniscus_discover::sizing::simulations::Simulations;
use meniscus_discover::sizing::store::SimulationStore;
use meniscus_discover::sizing::workload::SimulationProgress;
use std::path::Path;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicBool, Ordering};

/// Spacing of the first search, m.
pub(super) const COARSE_M: f64 = 0.007;

/// A spacing nearer to the first one than this is not searched again.
pub(super) const APART: f64 = 0.85;

/// Packings at the end, whose scatter is part of the interval.
pub(super) const PACKINGS: usize = 3;

/// Standard deviation of the simulator's own damping at a spacing of 5 mm, relative; an error of second order in the spacing.
/// Against linear theory the decay of the first mode is off by +0.6 % (1 mPa s), -9 % (0.3 Pa s), -3 and +0.1 % (0.95 Pa s):
/// `docs/validation`.
const OWN_ERROR: f64 = 0.04;
const OWN_ERROR_AT_M: f64 = 0.005;

/// Degrees of freedom of what is known from elsewhere.
const MANY: f64 = 1e3;

/// Seed of the first packing, which no recording of the simulator has by chance.
const SEED: u64 = 907;

/// Means of the simulations.
pub(crate) struct Simulating<'a> {
    /// Spacing of the finest particles, m.
    pub spacing_m: f64,
    /// Folder of what is simulated.
    pub store: &'a Path,
    /// Raised by whoever wants the run to end.
    pub stop: &'a AtomicBool,
    /// Observer.
    pub progress: &'a dyn Progress,
}

/// Returns `rough`, the fit of the reduced model to `measured`, with the numbers that fit best in the simulator.
///
/// # Errors
/// [`RelearnError`], when the simulations end early or none of the viscosities can be simulated.
pub(crate) fn by_simulation(
    rough: &Identified,
    measured: &[MeasuredRecording],
    known: &Known,
    how: &Simulating<'_>,
) -> Result<Identified, RelearnError> {
    let records: Vec<Record> = measured.iter().map(|one| one.record.clone()).collect();
    let store = SimulationStore::new(how.store);
    let watch = |now: SimulationProgress| how.progress.advances(now.done as f64 / now.expected.max(1) as f64);
    let simulations = Simulations { stop: Some(how.stop), ..Simulations::new(&store, &watch) };
    let fit = Fit { rough, records: &records, simulations: &simulations, spacing_m: how.spacing_m };
    let found = if rough.law == Law::Newtonian { fit.viscosity(known) } else { fit.law(known) };
    found.map_err(|error| ended(error, how))
}

/// The error of a run whose sizing ended with `error`.
fn ended(error: SizingError, how: &Simulating<'_>) -> RelearnError {
    match error {
        SizingError::Stopped => RelearnError::Interrupted {
            stage: Stage::Identify.name(),
            kept: format!("the simulations in {} are kept", how.store.display()),
        },
        error => RelearnError::Simulated(error),
    }
}

/// Returns how many sets of simulations a search from `start` is expected to make.
pub(super) fn sets_of(start: &Start, packings: usize) -> usize {
    let derivatives = if start.slopes.is_some() { 0 } else { start.others.len() };
    start.sizes.len() + 1 + derivatives + packings - 1
}

/// Fit of the simulator.
pub(super) struct Fit<'a> {
    pub(super) rough: &'a Identified,
    records: &'a [Record],
    simulations: &'a Simulations<'a>,
    pub(super) spacing_m: f64,
}

impl Fit<'_> {
    /// Viscosity, then flow index and yield stress where the law has them: a viscosity of one is that of `known`.
    pub(super) fn candidate(&self) -> SizingCandidate {
        let numbers = [
            ("viscosity", Some(1.0)),
            ("shear_thinning", self.rough.index.map(|value| value.best)),
            ("yield_stress", self.rough.yield_stress_pa.map(|value| value.best)),
        ];
        let on =
            |(name, value): (&str, Option<f64>)| Some(Active { entry: find(name)?, values: [value?, 0.0] });
        let active: Vec<Active> = numbers.into_iter().filter_map(on).collect();
        SizingCandidate {
            names: active.iter().map(|active| active.entry.name).collect(),
            free: (0..active.len()).map(|effect| -> Free { (effect, 0) }).collect(),
            active,
            viscosity_deviation: None,
        }
    }

    /// Runs `work` with the simulator of `candidate` and the recordings as they are compared.
    pub(super) fn with_forward<T>(
        &self,
        known: &Known,
        spacing_m: f64,
        candidate: &SizingCandidate,
        work: impl FnOnce(&GlassForward<'_>, &[Observed]) -> T,
    ) -> T {
        let calibration = calibration(self.records);
        let matched: Vec<Matched<'_>> =
            self.records.iter().map(|record| Matched::new(record, known, &[])).collect();
        let observed: Vec<Observed> =
            matched.iter().map(|matched| matched.observed(&calibration, self.records.len())).collect();
        let forward = GlassForward {
            simulations: self.simulations,
            candidate,
            known: *known,
            recordings: &matched,
            lag_s: calibration.lag_s,
            spacing_m,
            seed: SEED,
        };
        work(&forward, &observed)
    }

    /// Adds `sets` of simulations of all recordings to what is expected, each as long as those at `parameters`.
    pub(super) fn expect<'p>(
        &self,
        forward: &GlassForward<'_>,
        parameters: impl Iterator<Item = &'p f64>,
        sets: usize,
    ) {
        let parameters = parameters.copied().collect();
        let Some(setup) = forward.setup(&Point { parameters, packing: 0 }) else { return };
        let frames: usize = self.records.iter().map(Record::frames).sum();
        let mut workload = self.simulations.workload.lock().unwrap_or_else(PoisonError::into_inner);
        workload.expect(&setup, sets * frames, sets * self.records.len(), sets);
    }

    /// Error of the spacing: what the change from a `coarse` value leaves, and the simulator's own error, relative to `whole`.
    pub(super) fn spacing(&self, value: f64, coarse: Option<f64>, whole: f64) -> Component {
        let between =
            coarse.map_or(0.0, |coarse| spacing_error((COARSE_M, coarse), (self.spacing_m, value)).variance);
        let own = OWN_ERROR * (self.spacing_m / OWN_ERROR_AT_M).powi(2) * whole;
        Component { variance: between + own * own, freedom: MANY }
    }

    /// Record of what was simulated.
    pub(super) fn simulated(&self, tried_pa_sn: Vec<f64>) -> BySimulation {
        BySimulation {
            reduced_pa_sn: self.rough.consistency_pa_sn,
            tried_pa_sn,
            spacing_m: self.spacing_m,
            simulations: self.simulations.made.load(Ordering::Relaxed)
                + self.simulations.reused.load(Ordering::Relaxed),
        }
    }
}
