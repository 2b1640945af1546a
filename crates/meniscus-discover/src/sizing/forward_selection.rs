//! Two effects at once: forward selection with the simulator as judge.
//!
//! A second effect is looked for beside each of the best single ones. Every other effect is simulated once, at a size that
//! matters, and the squares that its derivative d promises to remove order them:
//! ```text
//! fall = g'^T H'^-1 g' - g^T H^-1 g,   H = J^T J + P,   g = J^T r
//! ```
//! r is the residual of the single effect and J its derivatives by size and other parameters, P their priors; the primed
//! ones have d as a column more (a score test: Rao, Proc. Camb. Phil. Soc. 44 (1948) 50). The best of them are sized.

use super::candidate::SizingCandidate;
use super::error::SizingError;
use super::forward::{Forward, Point};
use super::interval::Linearised;
use super::stage::{Coarse, Stage};
use meniscus::reduced::effects::{Entry, find};
use nalgebra::{DMatrix, DVector};

/// Single effects beside which a second one is looked for.
const FIRSTS: usize = 2;

/// Squares of such a one over those of the best single effect, at most.
const FAR: f64 = 4.0;

/// Second effects that are sized beside each.
const SECONDS: usize = 3;

/// Second effect, and the squares that it promises to remove.
struct Promise {
    candidate: SizingCandidate,
    /// Size of the first effect, and the viscosity where it is fitted.
    others: Vec<f64>,
    fall: f64,
}

impl Stage<'_> {
    /// Returns the pairs that were sized beside the best of `singles`, which are sorted.
    pub(super) fn pairs(&self, singles: &[Coarse]) -> Result<Vec<Coarse>, SizingError> {
        let mut out: Vec<Coarse> = Vec::new();
        let Some(best) = singles.first() else { return Ok(out) };
        let is_near = |single: &&Coarse| {
            single.candidate.names.len() == 1 && single.scores.squares() <= FAR * best.scores.squares()
        };
        for first in singles.iter().filter(is_near).take(FIRSTS) {
            let mut promises = Vec::new();
            for entry in self.others_than(&first.candidate) {
                promises.extend(self.promise(first, entry)?);
            }
            promises.sort_by(|a, b| b.fall.total_cmp(&a.fall));
            for Promise { candidate, others, fall } in promises.into_iter().take(SECONDS) {
                log::info!("{} promises to remove {fall:.0} squares", candidate.names.join(" + "));
                let is_same = |coarse: &Coarse| {
                    candidate.names.iter().all(|name| coarse.candidate.names.contains(name))
                };
                if out.iter().any(is_same) {
                    continue;
                }
                match self.coarse(candidate, Some(&others)) {
                    Ok(coarse) => out.push(coarse),
                    Err(SizingError::NotSimulated { .. } | SizingError::TooFewSizes { .. }) => {}
                    Err(error) => return Err(error),
                }
            }
        }
        Ok(out)
    }

    /// Returns the effects in the liquid that the simulator carries, other than those of `candidate`.
    fn others_than(&self, candidate: &SizingCandidate) -> Vec<&'static Entry> {
        let ranking = &self.findings.assessment.search.ranking;
        let entries = ranking.iter().filter_map(|ranked| find(ranked.last()));
        let is_other = |entry: &&'static Entry| !candidate.names.contains(&entry.name);
        entries
            .filter(|entry| entry.class.in_liquid() && entry.simulator.law().is_some())
            .filter(is_other)
            .collect()
    }

    /// Returns what `entry` beside `first` promises; none where it cannot be simulated.
    fn promise(&self, first: &Coarse, entry: &'static Entry) -> Result<Option<Promise>, SizingError> {
        let near = &first.level.near;
        let candidate = first.candidate.with(entry, &near.point.parameters);
        let others = near.point.parameters[..candidate.others().len()].to_vec();
        let sizes = candidate.first_sizes();
        let point = |size: f64| Point {
            parameters: std::iter::once(size).chain(others.iter().copied()).collect(),
            packing: 0,
        };
        let forward = self.forward(&candidate, &self.fitted, self.settings.spacings_m()[0]);
        let points = [point(sizes[0]), point(sizes[1])];
        let Ok(simulated) = forward.run(&points)?.into_iter().collect::<Result<Vec<_>, String>>() else {
            return Ok(None);
        };
        let mapped = &first.level.mapped;
        let along = mapped.reduce(&simulated[1].recordings) - mapped.reduce(&simulated[0].recordings);
        let linear = Linearised::of(&mapped.emulator, &first.level.fit);
        let (low, high) = candidate.range().bounds;
        let has_two_sides = (low..high).contains(&(2.0 * sizes[0] - sizes[1]));
        let fall = linear.map_or(0.0, |linear| fall(&linear, along, has_two_sides));
        Ok(Some(Promise { candidate, others, fall }))
    }
}

/// Returns the squares that a step along `along` removes beside the parameters of `linear`; none where it goes backwards and
/// has not two sides.
fn fall(linear: &Linearised, along: DVector<f64>, has_two_sides: bool) -> f64 {
    let Linearised { residual, jacobian, prior, .. } = linear;
    let count = jacobian.ncols();
    let step = |jacobian: &DMatrix<f64>| -> Option<(f64, f64)> {
        let mut square = jacobian.tr_mul(jacobian);
        let mut corner = square.view_mut((0, 0), (count, count));
        corner += prior;
        let right = jacobian.tr_mul(residual);
        let step = square.cholesky()?.solve(&right);
        Some((right.dot(&step), step.iter().last().copied()?))
    };
    let mut wider = jacobian.clone().insert_column(count, 0.0);
    wider.set_column(count, &along);
    match (step(jacobian), step(&wider)) {
        (Some((without, _)), Some((with, last))) if last > 0.0 || has_two_sides => with - without,
        _ => 0.0,
    }
}
