//! Best fit of what was tried: the emulator through the points nearest to it.

use super::emulator::{Fit, Prior};
use super::forward::Point;
use super::search::{Progress, SizeSearch};
use super::tried::{MappedEmulator, Tried};

/// Change of a size, relative to its distance from the absent effect, that is not simulated again.
pub(super) const STABLE: f64 = 0.03;

/// Change of another parameter that is not simulated again, in its steps. A whole step is too much: its derivative depends on
/// the size, and a viscosity that was taken 12 % too high left a yield stress of 5 Pa at 4.79.
pub(super) const STABLE_STEPS: f64 = 0.15;

/// Most changes of the simulation that the nuisances are projected out by, in one fit.
const MOST_CHANGES: usize = 4;

impl SizeSearch<'_> {
    /// Returns the emulator, its best fit, and the index of the simulated point nearest to it.
    pub(super) fn best(&self, progress: &Progress) -> (MappedEmulator, Fit, usize) {
        let priors: Vec<Prior> = self.others.iter().map(|other| other.prior).collect();
        let slopes = &progress.slopes;
        let fitted = |near: usize| {
            let like = &progress.tried[near];
            let nodes = self.distinct(&progress.tried, near);
            let mapped = MappedEmulator::new(self.observed, &nodes, like, slopes, &priors[..slopes.len()]);
            let mut best = mapped.emulator.minimum(self.sampled(&progress.tried), None);
            // Parameters without a derivative stay where they were simulated.
            best.others.extend(like.point.parameters[1 + slopes.len()..].iter().copied());
            (mapped, best)
        };
        // The nuisances are projected out by the simulation nearest to the best fit, which is known after the fit.
        let mut near = 0;
        let (mut mapped, mut best) = fitted(near);
        for _ in 0..MOST_CHANGES {
            let nearest = self.nearest(&progress.tried, &best);
            if nearest == near {
                break;
            }
            near = nearest;
            (mapped, best) = fitted(near);
        }
        (mapped, best, near)
    }

    /// Returns the distance of two points, 1 where one of their parameters differs by what is not simulated again.
    fn distance(&self, one: &[f64], other: &[f64]) -> f64 {
        let excess = (one[0] - self.range.neutral).abs().max((other[0] - self.range.neutral).abs());
        let along = (one[0] - other[0]).abs() / (STABLE * excess).max(f64::MIN_POSITIVE);
        let steps = one[1..].iter().zip(&other[1..]).zip(self.others);
        steps.fold(along, |far, ((a, b), of)| far.hypot((a - b) / (STABLE_STEPS * of.step)))
    }

    /// Returns whether `next` is a point of `tried`, as far as the search resolves it: one that goes back goes to and fro.
    pub(super) fn was_tried(&self, next: &Point, tried: &[Tried]) -> bool {
        tried.iter().any(|tried| self.distance(&tried.point.parameters, &next.parameters) < 1.0)
    }

    /// Returns the index of the simulated point nearest to `best`, the last one of several.
    fn nearest(&self, tried: &[Tried], best: &Fit) -> usize {
        let at: Vec<f64> = std::iter::once(best.size).chain(best.others.iter().copied()).collect();
        let far = |i: &usize| self.distance(&tried[*i].point.parameters, &at);
        (0..tried.len()).rev().min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(0)
    }

    /// Returns the points of `tried` whose sizes differ: of several that hardly do the one nearest to `tried[near]`. Their other
    /// parameters differ then, and what the derivatives by these do not explain would be taken for a change by the size.
    fn distinct<'b>(&self, tried: &'b [Tried], near: usize) -> Vec<&'b Tried> {
        let like = &tried[near].point.parameters;
        let mut sorted: Vec<&Tried> = tried.iter().rev().collect();
        let far = |tried: &Tried| self.distance(&tried.point.parameters, like);
        sorted.sort_by(|a, b| far(a).total_cmp(&far(b)));
        let neutral = self.range.neutral;
        let size = |tried: &Tried| tried.point.parameters[0];
        let largest =
            tried.iter().map(|tried| (size(tried) - neutral).abs()).fold(f64::MIN_POSITIVE, f64::max);
        let apart = STABLE * largest;
        let mut out: Vec<&Tried> = Vec::new();
        for one in sorted {
            if out.iter().all(|other| (size(one) - size(other)).abs() >= apart) {
                out.push(one);
            }
        }
        out
    }

    /// Returns the sizes that the emulator is looked at: half a step below the least that was simulated and a whole one
    /// above the largest.
    fn sampled(&self, tried: &[Tried]) -> (f64, f64) {
        let mut sizes: Vec<f64> = tried.iter().map(|tried| tried.point.parameters[0]).collect();
        sizes.sort_by(f64::total_cmp);
        let last = sizes.len() - 1;
        let low = sizes[0] - 0.5 * (sizes[1] - sizes[0]);
        let high = sizes[last] + (sizes[last] - sizes[last - 1]).max(0.3 * (sizes[last] - sizes[0]));
        (low.max(self.range.bounds.0), high.min(self.range.bounds.1))
    }
}
