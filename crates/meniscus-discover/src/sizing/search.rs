//! Search for the size that fits best at one spacing of the particles.
//!
//! Three sizes at first; then the best size of the emulator is simulated, until it stays where it was. Where it lies at the
//! end of the sizes that were tried, the next one lies beyond them. A size at which the simulator fails bounds the search.
//! The other parameters are stepped once, at the best size, and further packings are simulated there at the end.

use super::emulator::{Fit, Prior};
use super::error::SizingError;
use super::forward::{Forward, Point};
use super::interval::{Component, Linearised};
use super::projection::Observed;
use super::tried::{MappedEmulator, Slope, Tried, slope};

/// Change of a size, relative to its distance from the absent effect, that is not simulated again.
const STABLE: f64 = 0.03;

/// The same in standard deviations of the size.
const STABLE_DEVIATIONS: f64 = 0.25;

/// Change of another parameter that is not simulated again, in its steps. A whole step is too much: its derivative depends on
/// the size, and a viscosity that was taken 12 % too high left a yield stress of 5 Pa at 4.79.
const STABLE_STEPS: f64 = 0.15;

/// Farthest that a second size may lie from the best one, relative to the effect: a derivative from farther away is that of
/// another size.
const LOCAL: f64 = 0.3;

/// Distance of the second size from the best one, relative to the effect.
const BESIDE: f64 = 0.12;

/// Least effect for which a second size is simulated, relative to the largest that was tried.
const PRESENT: f64 = 0.1;

/// Most changes of the simulation that the nuisances are projected out by, in one fit.
const MOST_CHANGES: usize = 4;

/// Size that is searched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizeRange {
    /// Least and largest size.
    pub bounds: (f64, f64),
    /// Size at which the effect is absent.
    pub neutral: f64,
}

/// Other parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OtherParameter {
    /// Prior.
    pub prior: Prior,
    /// Step of its derivative.
    pub step: f64,
}

/// Search at one spacing.
pub struct SizeSearch<'a> {
    /// Model.
    pub forward: &'a dyn Forward,
    /// Measured recordings.
    pub observed: &'a [Observed],
    /// Size.
    pub range: SizeRange,
    /// Other parameters.
    pub others: &'a [OtherParameter],
    /// Packings.
    pub packings: usize,
    /// Most sizes that are simulated.
    pub most_sizes: usize,
}

/// Place where a search begins.
#[derive(Clone, Debug)]
pub struct Start {
    /// Sizes that are simulated first.
    pub sizes: Vec<f64>,
    /// Other parameters.
    pub others: Vec<f64>,
    /// Derivatives by the other parameters from a coarser spacing; none where they are to be simulated.
    pub slopes: Option<Vec<Slope>>,
}

/// Size at which the simulator failed.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// Size.
    pub size: f64,
    /// Reason.
    pub reason: String,
}

/// Outcome of a search at one spacing.
#[derive(Clone, Debug)]
pub struct Level {
    /// Best fit, mean over the packings.
    pub fit: Fit,
    /// Parts of the variance of size and other parameters: curvature, then packings.
    pub variance: Vec<[Component; 2]>,
    /// Simulated sizes, in their order.
    pub sizes: Vec<f64>,
    /// Failures.
    pub failures: Vec<Failure>,
    /// End of the range at which the size stands.
    pub end: Option<f64>,
    /// Whether the last size that was simulated is the best one.
    pub stable: bool,
    /// Misfit per number.
    pub misfit: f64,
    /// Derivatives by the other parameters.
    pub slopes: Vec<Slope>,
    /// Emulator at the end.
    pub mapped: MappedEmulator,
}

/// State of a search.
struct Progress {
    tried: Vec<Tried>,
    failures: Vec<Failure>,
    slopes: Vec<Slope>,
}

impl SizeSearch<'_> {
    /// Searches from `start`.
    ///
    /// # Errors
    /// [`SizingError`], when the work ends early or fewer than two sizes can be simulated.
    pub fn run(&self, start: &Start) -> Result<Level, SizingError> {
        let mut progress = Progress {
            tried: Vec::new(),
            failures: Vec::new(),
            slopes: start.slopes.clone().unwrap_or_default(),
        };
        let point = |size: f64, others: &[f64]| {
            let parameters = std::iter::once(size).chain(others.iter().copied()).collect();
            Point { parameters, packing: 0 }
        };
        let mut batch: Vec<Point> = start.sizes.iter().map(|size| point(*size, &start.others)).collect();
        loop {
            self.simulate(&batch, &mut progress)?;
            let (mapped, best, near) = self.best(&progress);
            let here = progress.tried[near].point.clone();
            let close = self.is_close(&mapped, &best, &here);
            let most = progress.tried.len() + progress.failures.len() >= self.most_sizes;
            if (close || most) && progress.slopes.len() < self.others.len() {
                // Stepped where the size is nearly right, because a derivative depends on it.
                progress.slopes = self.derivatives(&progress.tried[near])?;
                batch.clear();
                continue;
            }
            let beside = self.beside(&best, &progress.tried).filter(|_| close);
            if (close && beside.is_none()) || most {
                return self.finish(progress, mapped, best, near, close);
            }
            let next = beside.unwrap_or_else(|| self.beyond(best.size, &progress.tried));
            batch = vec![point(self.allowed(next, here.parameters[0], &progress.failures), &best.others)];
        }
    }

    /// Simulates `batch`.
    fn simulate(&self, batch: &[Point], progress: &mut Progress) -> Result<(), SizingError> {
        for (point, outcome) in batch.iter().zip(self.forward.run(batch)?) {
            match outcome {
                Ok(simulated) => progress.tried.push(Tried { point: point.clone(), simulated }),
                Err(reason) => progress.failures.push(Failure { size: point.parameters[0], reason }),
            }
        }
        if progress.tried.len() < 2 {
            let reason = progress.failures.last().map_or(String::new(), |failure| failure.reason.clone());
            return Err(SizingError::TooFewSizes { left: progress.tried.len(), reason });
        }
        Ok(())
    }

    /// Returns the emulator, its best fit, and the index of the simulated point nearest to it.
    fn best(&self, progress: &Progress) -> (MappedEmulator, Fit, usize) {
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
        let largest = tried.iter().map(|tried| (size(tried) - neutral).abs()).fold(f64::MIN_POSITIVE, f64::max);
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

    /// Returns `size`, or twice as far from the absent effect as any size that was tried where it lies well beyond them: an
    /// emulator is poor there.
    fn beyond(&self, size: f64, tried: &[Tried]) -> f64 {
        let neutral = self.range.neutral;
        let sizes = tried.iter().map(|tried| tried.point.parameters[0]);
        let (least, largest) = sizes.fold((f64::MAX, f64::MIN), |(a, b), size| (a.min(size), b.max(size)));
        let (low, high) = self.range.bounds;
        let far = 0.25 * (largest - least);
        if size > largest + far && largest > neutral {
            return (neutral + 2.0 * (largest - neutral)).max(size).min(high);
        }
        if size < least - far && least < neutral {
            return (neutral + 2.0 * (least - neutral)).min(size).max(low);
        }
        size
    }

    /// Returns a size beside the best one that its derivative needs; none where one was simulated.
    fn beside(&self, best: &Fit, tried: &[Tried]) -> Option<f64> {
        let sizes = || tried.iter().map(|tried| tried.point.parameters[0]);
        let excess = best.size - self.range.neutral;
        let largest = sizes().map(|size| (size - self.range.neutral).abs()).fold(0.0, f64::max);
        let apart = |size: f64| (size - best.size).abs() / excess.abs();
        // Several points near the best one that differ in another parameter are one size.
        let is_local = sizes().any(|size| (0.5 * BESIDE..LOCAL).contains(&apart(size)));
        if is_local || excess.abs() < PRESENT * largest {
            return None;
        }
        let (low, high) = self.range.bounds;
        let outward = best.size + BESIDE * excess;
        Some(if (low..=high).contains(&outward) { outward } else { best.size - BESIDE * excess })
    }

    /// Returns the end of the range at which `size` stands, as far as the search resolves it.
    fn end(&self, size: f64) -> Option<f64> {
        let (low, high) = self.range.bounds;
        let resolved = (2.0 * STABLE * (size - self.range.neutral).abs()).max(1e-4 * (high - low).min(1e3));
        [low, high].into_iter().find(|end| end.is_finite() && (size - end).abs() <= resolved)
    }

    /// Returns whether the best fit is as good as the simulated point `here`.
    fn is_close(&self, mapped: &MappedEmulator, best: &Fit, here: &Point) -> bool {
        let slopes = mapped.emulator.slopes.len();
        let variance = Linearised::of(&mapped.emulator, best)
            .map(|linear| linear.curvature(&mapped.emulator.recordings, &mapped.channels()));
        // A change within the noise is not worth a simulation either.
        let within_noise = |which: usize| {
            variance.as_ref().map_or(0.0, |parts| STABLE_DEVIATIONS * parts[which].variance.sqrt())
        };
        let stays = |which: usize, moved: f64, resolved: f64| moved.abs() <= resolved.max(within_noise(which));
        let excess = (best.size - self.range.neutral).abs();
        let others = best.others.iter().zip(&here.parameters[1..]).zip(self.others).take(slopes);
        stays(0, best.size - here.parameters[0], STABLE * excess)
            && others
                .enumerate()
                .all(|(j, ((new, old), of))| stays(1 + j, new - old, STABLE_STEPS * of.step.abs()))
    }

    /// Returns `size`, or halfway to `here` as often as it takes to stay on this side of every failure.
    fn allowed(&self, size: f64, here: f64, failures: &[Failure]) -> f64 {
        let mut size = size;
        for failure in failures {
            let beyond = (failure.size - here) * (size - failure.size) >= 0.0;
            if beyond {
                size = 0.5 * (here + failure.size);
            }
        }
        size
    }

    /// Returns the derivatives by the other parameters at `at`.
    fn derivatives(&self, at: &Tried) -> Result<Vec<Slope>, SizingError> {
        let stepped = |j: usize| {
            let mut point = at.point.clone();
            point.parameters[1 + j] += self.others[j].step;
            point
        };
        let points: Vec<Point> = (0..self.others.len()).map(stepped).collect();
        let mut slopes = Vec::new();
        for (outcome, other) in self.forward.run(&points)?.into_iter().zip(self.others) {
            let simulated = outcome.map_err(|reason| SizingError::NotSimulated { reason })?;
            slopes.push(slope(&at.simulated, &simulated, other.step));
        }
        Ok(slopes)
    }

    /// Simulates the other packings at the last point and puts the outcome together.
    fn finish(
        &self,
        progress: Progress,
        mapped: MappedEmulator,
        best: Fit,
        near: usize,
        stable: bool,
    ) -> Result<Level, SizingError> {
        let here = &progress.tried[near].point;
        let points: Vec<Point> =
            (1..self.packings).map(|packing| Point { packing, ..here.clone() }).collect();
        let emulator = &mapped.emulator;
        let mut failures = progress.failures;
        let mut residuals = vec![&emulator.data - mapped.at_origin(&progress.tried[near])];
        for (outcome, point) in self.forward.run(&points)?.into_iter().zip(&points) {
            match outcome {
                Ok(simulated) => {
                    let tried = Tried { point: point.clone(), simulated };
                    residuals.push(&emulator.data - mapped.at_origin(&tried));
                }
                Err(reason) => failures.push(Failure { size: point.parameters[0], reason }),
            }
        }
        // Before the other packings move it.
        let end = self.end(best.size);
        let mut fit = best;
        let mut variance = vec![[Component { variance: f64::INFINITY, freedom: 1.0 }; 2]];
        if let Some(linear) = Linearised::of(emulator, &fit) {
            let curvature = linear.curvature(&emulator.recordings, &mapped.channels());
            let (shift, packings) = linear.packings(&emulator.recordings, &residuals);
            let (low, high) = self.range.bounds;
            fit.size = (fit.size + shift[0]).clamp(low, high);
            for (other, change) in fit.others.iter_mut().zip(shift.iter().skip(1)) {
                *other += change;
            }
            variance = curvature.into_iter().zip(packings).map(|(c, p)| [c, p]).collect();
        }
        let misfit = fit.cost / mapped.measured().max(1) as f64;
        let sizes = progress.tried.iter().map(|tried| tried.point.parameters[0]).collect();
        Ok(Level { fit, variance, sizes, failures, end, stable, misfit, slopes: progress.slopes, mapped })
    }
}
