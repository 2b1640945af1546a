//! Liquid by simulation: the simulator is fitted to the recordings, from where the reduced model stands.
//!
//! The reduced model is linear. A real slosh is steeper, and what is steep about it is taken for viscosity: of glycerine the
//! reduced model finds 0.6 to 0.75 of the truth, of water ten times and more. The simulator has the steep wave. Each viscosity that is
//! tried is simulated in the recorded motions ([`SizeSearch`]): first with coarse particles over a factor of 25, then with those of
//! the training in several packings. A law with more numbers is fitted as a flow curve (`law_by_simulation`).
//!
//! ```text
//! interval: curvature of the misfit, scatter of the packings, errors of spacing and simulator    (meniscus_discover::sizing::interval)
//! ```

use super::identified::{BySimulation, Identified};
use super::measured::MeasuredRecording;
use super::viscosity::{Value, calibration};
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
use meniscus_discover::sizing::interval::{Component, SizeVariance, spacing_error};
use meniscus_discover::sizing::projection::Observed;
use meniscus_discover::sizing::search::{Level, SizeSearch, Start};
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

/// Viscosities that are tried first, over the one that the search starts from.
const FIRST: [f64; 3] = [0.65, 1.0, 1.5];

/// Most sizes that are tried at the coarse and at the fine spacing.
const MOST: [usize; 2] = [7, 4];

/// Sizes that the fine search starts from, over the one that the coarse search found.
const FINE: [f64; 2] = [1.0, 1.12];

/// Searches with coarse particles: each ends within a factor of five of where it starts.
const CENTRES: usize = 3;

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
    if rough.law != Law::Newtonian {
        return fit.law(known).map_err(|error| ended(error, how));
    }
    let (known, coarse) = fit.coarse(known).map_err(|error| ended(error, how))?;
    let fine = if how.spacing_m < APART * COARSE_M {
        Some(fit.fine(&known, &coarse).map_err(|error| ended(error, how))?)
    } else {
        None
    };
    Ok(fit.identified(&known, &coarse, fine.as_ref()))
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

    /// Searches from `start` with particles at `spacing_m`.
    fn search(
        &self,
        known: &Known,
        spacing_m: f64,
        start: &Start,
        limits: (usize, usize),
    ) -> Result<Level, SizingError> {
        let candidate = self.candidate();
        let (packings, most_sizes) = limits;
        self.with_forward(known, spacing_m, &candidate, |forward, observed| {
            self.expect(forward, [start.sizes[0]].iter().chain(&start.others), sets_of(start, packings));
            let search = SizeSearch {
                forward,
                observed,
                range: candidate.range(),
                others: &candidate.others(),
                packings,
                most_sizes,
            };
            search.run(start)
        })
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

    /// The search with coarse particles, and the liquid that it counts from.
    fn coarse(&self, known: &Known) -> Result<(Known, Level), SizingError> {
        let spacing_m = self.spacing_m.max(COARSE_M);
        let mut known = Known { viscosity_pa_s: self.rough.consistency_pa_sn.best, ..*known };
        let start = Start { sizes: FIRST.to_vec(), others: self.candidate().first_others(), slopes: None };
        let packings = if self.spacing_m < APART * COARSE_M { 1 } else { PACKINGS };
        let mut level = self.search(&known, spacing_m, &start, (packings, MOST[0]))?;
        for _ in 1..CENTRES {
            let Some(end) = level.end else { break };
            known.viscosity_pa_s *= end;
            level = self.search(&known, spacing_m, &start, (packings, MOST[0]))?;
        }
        Ok((known, level))
    }

    /// The search with the particles of the training, near what coarse ones found.
    fn fine(&self, known: &Known, coarse: &Level) -> Result<Level, SizingError> {
        let (low, high) = self.candidate().range().bounds;
        let sizes = FINE.map(|factor| (factor * coarse.fit.size).clamp(low, high)).to_vec();
        let start = Start { sizes, others: coarse.fit.others.clone(), slopes: Some(coarse.slopes.clone()) };
        self.search(known, self.spacing_m, &start, (PACKINGS, MOST[1]))
    }

    /// The liquid at the end of the last search.
    fn identified(&self, known: &Known, coarse: &Level, fine: Option<&Level>) -> Identified {
        let last = fine.unwrap_or(coarse);
        let [curvature, packings] = last.variance.first().copied().unwrap_or_default();
        let spacing = self.spacing(last.fit.size, fine.map(|_| coarse.fit.size), last.fit.size);
        let half = SizeVariance { curvature, packings, spacing }.half_width();
        let parameter = self.candidate().parameter(0);
        let (best, (least, most), (none, all)) = (last.fit.size, parameter.range, parameter.admissible);
        let si = |coordinate: f64| parameter.to_value(coordinate, &known.stated());
        // Beyond the sizes that a search may try nothing is known: there the interval ends where any liquid does.
        let low = if best - half > least { si(best - half) } else { none };
        let high = if best + half < most { si(best + half) } else { all };
        let viscosity = Value { best: si(best), interval: [low, high] };
        Identified {
            consistency_pa_sn: viscosity,
            undetermined_below_pa_s: viscosity.bound(known.density_kg_m3),
            misfit: last.misfit,
            by_simulation: Some(
                self.simulated(last.sizes.iter().map(|size| size * known.viscosity_pa_s).collect()),
            ),
            ..self.rough.clone()
        }
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
