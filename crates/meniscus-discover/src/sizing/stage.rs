//! The whole stage: candidates in, sizes and verdict by simulation out.

use super::candidate::{SizingCandidate, candidates};
use super::comparison::{Score, Scores};
use super::emulator::Fit;
use super::error::SizingError;
use super::forward::{Forward, Point};
use super::glass::{GlassForward, Matched, References};
use super::judgement::{Compared, Judgement, judge};
use super::outcome::{HeldOutError, SizedCandidate, Sizing, Unsized};
use super::projection::{Observed, Projection};
use super::search::{Level, SizeSearch, Start};
use super::simulations::{Shard, Simulations};
use crate::findings::Findings;
use crate::findings::gap::gap_to;
use crate::insert::simulated::Resolution;
use crate::recordings::record::Record;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Spacing at which candidates are sized first and compared, m.
pub const COARSE_M: f64 = 0.007;

/// Spacings nearer to each other than this are one.
const APART: f64 = 0.85;

/// Most sizes of a candidate at one spacing.
pub(super) const MOST_SIZES: usize = 9;

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
pub(super) struct Stage<'a> {
    pub(super) findings: &'a Findings,
    pub(super) settings: &'a SizingSettings,
    pub(super) simulations: &'a Simulations<'a>,
    pub(super) fitted: Vec<Matched<'a>>,
    pub(super) held_out: Option<Matched<'a>>,
}

/// A candidate after the coarse search.
pub(super) struct Coarse {
    pub(super) candidate: SizingCandidate,
    pub(super) level: Level,
    pub(super) scores: Scores,
    /// Best fit where residuals of neighbouring frames, which tell the same, count once. Counted one by one, they outweigh what
    /// references know of the viscosity: a slip of 3 mm was sized as one of 3.6 mm in a liquid that is 7 % more viscous.
    pub(super) weighted: Fit,
}

/// Sizes the effects of `findings` and compares them with their rivals.
///
/// # Errors
/// [`SizingError`], when the work ends early, the best candidate cannot be sized, or its effects are outside the liquid.
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
    // A fill of 73 mm was sized as one of 70.3 mm: particles of another fill are another packing, whose scatter is larger than
    // what a fit takes it for. Gains and delays had intervals that were too narrow.
    if !candidates[0].is_of_the_particles() {
        return Err(SizingError::OutsideTheLiquid { names: candidates[0].names.join(" and ") });
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
    let with_control = stage.with_control();
    let compared = Compared { chosen: &chosen, candidates: &outcome };
    let Judgement { word, names, change } = judge(verdict, &compared);
    let mut sizing = Sizing {
        candidates: Vec::new(),
        not_sized,
        word,
        names,
        change,
        held_out: None,
        with_control,
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
    pub(super) fn forward<'b>(
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

    pub(super) fn observed(&self, recordings: &[Matched<'_>]) -> Vec<Observed> {
        let count = self.fitted.len();
        recordings.iter().map(|matched| matched.observed(&self.findings.calibration, count)).collect()
    }

    /// Returns whether every fitted recording has a reference in the same motion, which bears the simulator's own error.
    pub(super) fn is_controlled(&self) -> bool {
        let (with, all) = self.with_control();
        with == all
    }

    fn with_control(&self) -> (usize, usize) {
        (self.fitted.iter().filter(|matched| !matched.references.is_empty()).count(), self.fitted.len())
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
            most_sizes: MOST_SIZES,
        };
        let start = Start { sizes: candidate.first_sizes(), others: candidate.first_others(), slopes: None };
        let level = search.run(&start)?;
        let names: Vec<String> = observed.iter().map(|observed| observed.name.clone()).collect();
        let mut scores = Scores::left_out(&level.mapped, &names, candidate.range().neutral);
        if let Some(held_out) = &self.held_out {
            scores.each.push(self.held_out_score(&candidate, &level, held_out)?);
        }
        let weighted = level.weighted(scores.correlation.max(1.0));
        Ok(Coarse { candidate, level, scores, weighted })
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
}
