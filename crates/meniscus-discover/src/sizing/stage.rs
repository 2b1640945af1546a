//! The whole stage: candidates in, sizes and verdict by simulation out.

use super::candidate::{SizingCandidate, candidates};
use super::comparison::{Score, Scores};
use super::error::SizingError;
use super::forward::{Forward, Point};
use super::glass::{GlassForward, Matched, References};
use super::interval::{Component, SizeVariance, spacing_error};
use super::outcome::{HeldOutError, SizedCandidate, SizedParameter, Sizing, SpacingResult, Unsized, decide};
use super::projection::{Observed, Projection};
use super::search::{Level, SizeSearch, Start};
use super::simulations::{Shard, Simulations};
use crate::findings::Findings;
use crate::findings::gap::gap_to;
use crate::insert::simulated::Resolution;
use crate::recordings::record::Record;
use meniscus::reduced::effects::Parameter;
use std::path::PathBuf;
use std::sync::PoisonError;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Spacing at which candidates are sized first and compared, m.
pub const COARSE_M: f64 = 0.007;

/// Spacings nearer to each other than this are one.
const APART: f64 = 0.85;

/// Most sizes of a candidate at the coarse and at the fine spacing.
const MOST_SIZES: [usize; 2] = [7, 5];

/// Sizes that a search is expected to take beyond the first, for the estimate of the time.
const EXPECTED_MORE: usize = 2;

/// Distance of the second size at the fine spacing from the first, relative to the effect: least and largest.
const FINE_STEP: (f64, f64) = (0.08, 0.3);

/// Choices of a sizing.
#[derive(Clone, Debug, PartialEq)]
pub struct SizingSettings {
    /// Spacing of the particles at the end, m.
    pub spacing_m: f64,
    /// Seed of the first packing.
    pub seed: u64,
    /// Packings at each size that is final.
    pub packings: usize,
    /// Most rivals.
    pub rivals: usize,
    /// Folder of the simulations.
    pub store: PathBuf,
    /// Part of the simulations that is made here; none makes all.
    pub shard: Option<Shard>,
}

impl SizingSettings {
    /// Returns the spacings, the coarsest first.
    #[must_use]
    pub fn spacings_m(&self) -> Vec<f64> {
        if self.spacing_m < APART * COARSE_M { vec![COARSE_M, self.spacing_m] } else { vec![self.spacing_m] }
    }
}

/// Everything that a sizing works on.
struct Stage<'a> {
    findings: &'a Findings,
    settings: &'a SizingSettings,
    simulations: &'a Simulations<'a>,
    fitted: Vec<Matched<'a>>,
    held_out: Option<Matched<'a>>,
}

/// A candidate after the coarse search.
struct Coarse {
    candidate: SizingCandidate,
    level: Level,
    scores: Scores,
}

/// Sizes the effects of `findings` and compares them with their rivals.
///
/// # Errors
/// [`SizingError`], when the work ends early or the best candidate cannot be sized.
pub fn size(
    findings: &Findings,
    references: &References<'_>,
    settings: &SizingSettings,
    simulations: &Simulations<'_>,
) -> Result<Sizing, SizingError> {
    let begun = Instant::now();
    let candidates = candidates(findings, settings.rivals);
    if candidates.is_empty() {
        return Err(SizingError::NotSimulated { reason: "the verdict has no effect to size".into() });
    }
    let matched = |record| Matched::new(record, &findings.known, references);
    let stage = Stage {
        findings,
        settings,
        simulations,
        fitted: findings.split.fitted.iter().map(matched).collect(),
        held_out: findings.split.held_out.as_ref().map(matched),
    };
    stage.announce(&candidates);
    let chosen = candidates[0].names.clone();
    let (mut sized, mut not_sized) = (Vec::new(), Vec::new());
    for (n, candidate) in candidates.into_iter().enumerate() {
        let names = candidate.names.clone();
        match stage.coarse(candidate) {
            Ok(coarse) => sized.push(coarse),
            Err(error @ (SizingError::NotSimulated { .. } | SizingError::TooFewSizes { .. })) if n > 0 => {
                not_sized.push(Unsized { names, reason: error.to_string() });
            }
            Err(error) => return Err(error),
        }
    }
    sized.sort_by(|a, b| a.scores.squares().total_cmp(&b.scores.squares()));
    let mut outcome: Vec<SizedCandidate> = sized.iter().map(|coarse| stage.described(coarse, None)).collect();
    let verdict = &findings.assessment.verdict;
    let (word, names, change) = decide(verdict, &chosen, &outcome);
    let mut sizing = Sizing {
        candidates: Vec::new(),
        not_sized,
        word,
        names,
        change,
        held_out: None,
        with_control: stage.with_control(),
        packings: settings.packings,
        simulations: (0, 0),
        seconds: 0.0,
    };
    // Only what goes into other models is worth the fine spacing.
    sizing.candidates = outcome.clone();
    let final_names = sizing.chosen().map(|c| c.names.clone()).unwrap_or_default();
    if let Some(which) = sized.iter().position(|coarse| coarse.candidate.names == final_names) {
        if settings.spacings_m().len() > 1 {
            outcome[which] = stage.described(&sized[which], Some(stage.fine(&sized[which])?));
        }
        sizing.held_out = stage.held_out_error(&outcome[which])?;
    }
    sizing.candidates = outcome;
    let count = |counter: &std::sync::atomic::AtomicUsize| counter.load(Ordering::Relaxed);
    sizing.simulations = (count(&simulations.reused), count(&simulations.made));
    sizing.seconds = begun.elapsed().as_secs_f64();
    Ok(sizing)
}

impl<'a> Stage<'a> {
    fn forward<'b>(
        &'b self,
        candidate: &'b SizingCandidate,
        recordings: &'b [Matched<'a>],
        spacing_m: f64,
    ) -> GlassForward<'b> {
        GlassForward {
            simulations: self.simulations,
            candidate,
            known: self.findings.known,
            recordings,
            lag_s: self.findings.calibration.lag_s,
            spacing_m,
            seed: self.settings.seed,
        }
    }

    fn observed(&self, recordings: &[Matched<'_>]) -> Vec<Observed> {
        let count = self.fitted.len();
        recordings.iter().map(|matched| matched.observed(&self.findings.calibration, count)).collect()
    }

    fn with_control(&self) -> (usize, usize) {
        (self.fitted.iter().filter(|matched| !matched.references.is_empty()).count(), self.fitted.len())
    }

    /// Adds the expected work of all searches and tells the observer.
    fn announce(&self, candidates: &[SizingCandidate]) {
        let spacings = self.settings.spacings_m();
        let mut workload = self.simulations.workload.lock().unwrap_or_else(PoisonError::into_inner);
        for (n, candidate) in candidates.iter().enumerate() {
            let (others, packings) = (candidate.others().len(), self.settings.packings);
            for (level, spacing_m) in spacings.iter().enumerate() {
                let sets = match level {
                    0 => 3 + EXPECTED_MORE + others + packings - 1,
                    _ if n == 0 => 2 + EXPECTED_MORE + packings - 1,
                    _ => continue,
                };
                let forward = self.forward(candidate, &self.fitted, *spacing_m);
                let parameters: Vec<f64> = candidate
                    .first_sizes()
                    .into_iter()
                    .skip(1)
                    .take(1)
                    .chain(candidate.first_others())
                    .collect();
                let frames: usize = self.fitted.iter().map(|matched| matched.record.frames()).sum();
                if let Some(setup) = forward.setup(&Point { parameters, packing: 0 }) {
                    workload.expect(&setup, sets * frames, sets * self.fitted.len(), sets);
                }
            }
        }
        let mut progress = workload.progress();
        progress.left_s = workload.estimate_s(rayon::current_num_threads());
        drop(workload);
        (self.simulations.watch)(progress);
    }

    /// Sizes `candidate` at the coarse spacing and scores it on recordings that it was not fitted to.
    fn coarse(&self, candidate: SizingCandidate) -> Result<Coarse, SizingError> {
        let spacing_m = self.settings.spacings_m()[0];
        let observed = self.observed(&self.fitted);
        let forward = self.forward(&candidate, &self.fitted, spacing_m);
        let search = SizeSearch {
            forward: &forward,
            observed: &observed,
            range: candidate.range(),
            others: &candidate.others(),
            packings: self.settings.packings,
            most_sizes: MOST_SIZES[0],
        };
        let start = Start { sizes: candidate.first_sizes(), others: candidate.first_others(), slopes: None };
        let level = search.run(&start)?;
        let names: Vec<String> = observed.iter().map(|observed| observed.name.clone()).collect();
        let mut scores = Scores::left_out(&level.mapped, &names, candidate.range().neutral);
        if let Some(held_out) = &self.held_out {
            scores.each.push(self.held_out_score(&candidate, &level, held_out)?);
        }
        Ok(Coarse { candidate, level, scores })
    }

    /// Returns the score on the recording that took no part in anything.
    fn held_out_score(
        &self,
        candidate: &SizingCandidate,
        level: &Level,
        held_out: &Matched<'a>,
    ) -> Result<Score, SizingError> {
        let one = std::slice::from_ref(held_out);
        let forward = self.forward(candidate, one, self.settings.spacings_m()[0]);
        let point = |size: f64, others: &[f64]| Point {
            parameters: std::iter::once(size).chain(others.iter().copied()).collect(),
            packing: 0,
        };
        let points = [
            point(level.fit.size, &level.fit.others),
            point(candidate.range().neutral, &candidate.first_others()),
        ];
        let observed = self.observed(one);
        let mut squares = Vec::new();
        let mut numbers = 0;
        for outcome in forward.run(&points)? {
            let simulated = outcome.map_err(|reason| SizingError::NotSimulated { reason })?;
            let series = &simulated.recordings[0];
            let projection = Projection::new(&observed[0], series, simulated.control[0].as_ref());
            squares.push((projection.data() - projection.reduce(series)).norm_squared());
            numbers = projection.measured();
        }
        Ok(Score { recording: observed[0].name.clone(), numbers, squares: squares[0], absent: squares[1] })
    }

    /// Sizes a candidate at the fine spacing, from its size and derivatives at the coarse one.
    fn fine(&self, coarse: &Coarse) -> Result<Level, SizingError> {
        let Coarse { candidate, level, .. } = coarse;
        let observed = self.observed(&self.fitted);
        let forward = self.forward(candidate, &self.fitted, self.settings.spacing_m);
        let range = candidate.range();
        let typical = candidate.parameter(0).typical.abs();
        let found = level.fit.size - range.neutral;
        let excess = found.abs().max(0.1 * typical);
        let deviation = level.variance[0].iter().map(|component| component.variance).sum::<f64>().sqrt();
        let step = (2.0 * deviation).clamp(FINE_STEP.0 * excess, FINE_STEP.1 * excess);
        // Away from the absent effect, unless the range ends there.
        let step =
            step.copysign(if found == 0.0 { candidate.first_sizes()[1] - range.neutral } else { found });
        let (low, high) = range.bounds;
        let second = if (low..=high).contains(&(level.fit.size + step)) {
            level.fit.size + step
        } else {
            level.fit.size - step
        };
        let start = Start {
            sizes: vec![level.fit.size, second],
            others: level.fit.others.clone(),
            slopes: Some(level.slopes.clone()),
        };
        let search = SizeSearch {
            forward: &forward,
            observed: &observed,
            range,
            others: &candidate.others(),
            packings: self.settings.packings,
            most_sizes: MOST_SIZES[1],
        };
        search.run(&start)
    }

    /// Returns the error of the simulator on the held-out recording, without and with the effects.
    fn held_out_error(&self, sized: &SizedCandidate) -> Result<Option<HeldOutError>, SizingError> {
        let Some(record) = &self.findings.split.held_out else { return Ok(None) };
        let noise_m = self.findings.gap.as_ref().map_or(0.0, |gap| gap.gap.noise);
        let error = |predicted: Vec<Vec<f64>>| gap_to(record, &predicted, noise_m);
        let predict = |active, known: &_, record: &Record| {
            self.simulations.predict(
                known,
                active,
                record,
                self.findings.calibration.lag_s,
                self.resolution(),
            )
        };
        Ok(Some(HeldOutError {
            untouched_m: error(predict(&[], &self.findings.known, record)?),
            effect_m: error(predict(&sized.active, &sized.known, record)?),
        }))
    }

    fn resolution(&self) -> Resolution {
        Resolution { spacing_m: self.settings.spacing_m, seed: self.settings.seed }
    }

    /// Returns the outcome for people, from the fine search where there was one.
    fn described(&self, coarse: &Coarse, fine: Option<Level>) -> SizedCandidate {
        let Coarse { candidate, level: first, scores } = coarse;
        let spacings = self.settings.spacings_m();
        let last = fine.as_ref().unwrap_or(first);
        let stated = self.findings.known.stated();
        let parameter = candidate.parameter(0);
        let si = |parameter: &Parameter, value: f64| parameter.to_value(value, &stated);
        let result = |level: &Level, spacing_m: f64| SpacingResult {
            spacing_m,
            value: si(parameter, level.fit.size),
            sizes: level.sizes.iter().map(|size| si(parameter, *size)).collect(),
            misfit: level.misfit,
        };
        let spacing = match &fine {
            Some(fine) => spacing_error((spacings[0], first.fit.size), (spacings[1], fine.fit.size)),
            None => Component::default(),
        };
        let parts = |which: usize| {
            let [curvature, packings] = last.variance.get(which).copied().unwrap_or_default();
            let spacing = if which == 0 { spacing } else { Component::default() };
            SizeVariance { curvature, packings, spacing }
        };
        let values: Vec<f64> =
            std::iter::once(last.fit.size).chain(last.fit.others.iter().copied()).collect();
        let parameters = (0..candidate.free.len())
            .map(|which| {
                let (parameter, half) = (candidate.parameter(which), parts(which).half_width());
                let (low, high) = parameter.range;
                let (effect, index) = candidate.free[which];
                SizedParameter {
                    effect: candidate.active[effect].entry.name,
                    parameter: parameter.name,
                    unit: parameter.unit,
                    value: si(parameter, values[which]),
                    interval: (
                        si(parameter, (values[which] - half).max(low)),
                        si(parameter, (values[which] + half).min(high)),
                    ),
                    reduced: si(parameter, candidate.active[effect].values[index]),
                    absent: si(parameter, parameter.neutral),
                }
            })
            .collect();
        let viscosity = candidate.viscosity_deviation.map(|_| {
            let which = candidate.free.len();
            let (logarithm, half) = (values[which], parts(which).half_width());
            (logarithm.exp(), ((logarithm - half).exp(), (logarithm + half).exp()))
        });
        let (active, known) = candidate.at(&values, &self.findings.known);
        let mut results = vec![result(first, spacings[0])];
        results.extend(fine.as_ref().map(|fine| result(fine, spacings[1])));
        SizedCandidate {
            names: candidate.names.clone(),
            parameters,
            viscosity,
            active,
            known,
            variance: parts(0),
            spacings: results,
            scores: scores.clone(),
            cautions: super::cautions::of(candidate, last, parts(0).half_width(), &stated),
        }
    }
}
