//! Search for the size that fits best at one spacing of the particles.
//!
//! Three sizes at first; then the best size of the emulator is simulated, until size and other parameters stay where they
//! were and a second size lies near. Where the best one lies at the end of the sizes that were tried, the next one lies beyond
//! them. A size at which the simulator fails bounds the search. The other parameters are stepped once, at the best size, and
//! further packings are simulated there at the end.

use super::emulator::{Fit, Prior};
use super::error::SizingError;
use super::forward::{Forward, Point};
use super::interval::{Component, Linearised};
use super::projection::Observed;
use super::tried::{MappedEmulator, Slope, Tried, slope};

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

impl Level {
    /// Returns the best fit where `alike` numbers count as one, and the priors in full.
    #[must_use]
    pub fn weighted(&self, alike: f64) -> Fit {
        let plain = &self.mapped.emulator;
        let mut weighted = plain.clone();
        weighted.priors.iter_mut().for_each(|prior| prior.deviation /= alike.sqrt());
        let nodes = &plain.nodes;
        let range = (nodes[0].size, nodes[nodes.len() - 1].size);
        let (from, to) = (plain.minimum(range, None), weighted.minimum(range, None));
        // From the mean over the packings, which the emulator does not know.
        let moved = |of: f64, from: f64, to: f64| of + to - from;
        let others = self.fit.others.iter().zip(from.others.iter().zip(&to.others));
        Fit {
            size: moved(self.fit.size, from.size, to.size).clamp(range.0, range.1),
            others: others.map(|(of, (from, to))| moved(*of, *from, *to)).collect(),
            cost: to.cost,
        }
    }
}

/// State of a search.
pub(super) struct Progress {
    pub(super) tried: Vec<Tried>,
    failures: Vec<Failure>,
    pub(super) slopes: Vec<Slope>,
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
            let next = point(self.allowed(next, here.parameters[0], &progress.failures), &best.others);
            batch = vec![if self.was_tried(&next, &progress.tried) { here.halfway(&next) } else { next }];
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
