//! Fit of a drawn law and of the baseline's numbers together, by damped Gauss-Newton steps with bounds.
//!
//! ```text
//! |r(p)|^2 -> least,   p = (theta, c, d),   d >= 0,     r: whitened residuals, prior of theta, prior of c and d
//! (J^T J + lambda diag(J^T J)) p' = (J^T J + lambda diag(J^T J)) p - J^T r,      d' >= 0     (active set)
//! ```
//! The recordings are predicted in full, so that a force is found by all that it changes later; nothing is differentiated.

use super::shape::{Extent, NUMBERS, SimpleLaw, least, prior};
use crate::baseline::predict::Difference;
use crate::fitting::problem::Problem;
use meniscus::reduced::DrawnLaw;
use meniscus_numerics::least_squares::bounded;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Most steps, and tries of one step.
const STEPS: usize = 25;
const TRIES: usize = 6;

/// Gain in the cost at which the fit ends, as for the effects of the library.
const SETTLED: f64 = 0.02;

/// Step of the differences by a number of the law.
const WIDTH: f64 = 2e-3;

/// First number of the hats: a drag that is off its bound.
const FIRST_DRAG: f64 = 0.02;

/// A fitted law.
#[derive(Clone, Debug)]
pub struct LawFit {
    /// Extents and units of its curves.
    pub extent: Extent,
    /// The baseline's numbers and the lags.
    pub theta: Vec<f64>,
    /// Numbers of the law.
    pub numbers: Vec<f64>,
    /// Law.
    pub law: DrawnLaw,
    /// Squared norm of the residual.
    pub cost: f64,
    /// Residual: data, prior of theta, prior of the law.
    pub residual: DVector<f64>,
    /// Its derivatives by theta, then by the numbers of the law.
    pub jacobian: DMatrix<f64>,
}

impl LawFit {
    /// Returns the whitened misfit of the data alone for each of `count` numbers.
    #[must_use]
    pub fn chi2(&self, count: usize) -> f64 {
        self.residual.rows(0, count).norm_squared() / count as f64
    }

    /// Returns how many numbers of the law the data set, each counted by the part that the prior does not set.
    #[must_use]
    pub fn freedom(&self) -> f64 {
        let all = self.jacobian.tr_mul(&self.jacobian);
        let own = prior(&self.numbers).len();
        let data = self.jacobian.rows(0, self.jacobian.nrows() - own);
        let Some(inverse) = all.try_inverse() else { return NUMBERS as f64 };
        let hat = inverse * data.tr_mul(&data);
        (self.theta.len()..self.theta.len() + NUMBERS).map(|i| hat[(i, i)]).sum()
    }
}

/// Returns the residual at `point`; none where the law of it has no meaning.
fn residual(problem: &Problem, extent: &Extent, point: &DVector<f64>, thetas: usize) -> Option<DVector<f64>> {
    let (theta, numbers) = point.as_slice().split_at(thetas);
    let law = extent.law(numbers)?;
    let data = problem.residual_with(theta, Difference { active: &[], law: Some(&law) });
    let all: Vec<f64> = data.iter().copied().chain(prior(numbers)).collect();
    all.iter().all(|r| r.is_finite()).then(|| DVector::from_vec(all))
}

/// Returns the derivatives of the residual at `point` by forward differences.
fn derivatives(
    problem: &Problem,
    extent: &Extent,
    point: &DVector<f64>,
    thetas: usize,
    at: &DVector<f64>,
) -> Option<DMatrix<f64>> {
    let column = |i: usize| {
        let width = if i < thetas { 0.05 * problem.deviation[i] } else { WIDTH };
        let mut shifted = point.clone();
        shifted[i] += width;
        Some((residual(problem, extent, &shifted, thetas)? - at) / width)
    };
    let columns: Option<Vec<DVector<f64>>> = (0..point.len()).into_par_iter().map(column).collect();
    Some(DMatrix::from_columns(&columns?))
}

/// Stiffnesses, hardenings and drags of the grid of starts; the drag of a start grows straight with the rate.
const STIFFNESSES: [f64; 9] = [-0.4, -0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3, 0.4];
const HARDENINGS: [f64; 3] = [-0.25, 0.0, 0.25];
const DRAGS: [f64; 2] = [FIRST_DRAG, 0.4];

/// Starts of the grid from which the fit descends.
const DESCENTS: usize = 2;

/// Returns the starts of a fit: that of the plain fit `theta` without a law, and the best of a grid of laws beside the
/// prior's mean, because a wave that has run out of phase hides the way to a stiffer or softer spring.
fn starts(problem: &Problem, extent: &Extent, theta: &[f64]) -> Vec<DVector<f64>> {
    let start = |theta: &[f64], law: SimpleLaw| {
        DVector::from_iterator(theta.len() + NUMBERS, theta.iter().copied().chain(law.numbers()))
    };
    let mut grid = Vec::new();
    for stiffness in STIFFNESSES {
        for hardening in HARDENINGS {
            grid.extend(DRAGS.map(|drag| start(&problem.mean, SimpleLaw { stiffness, hardening, drag })));
        }
    }
    let cost = |point: &DVector<f64>| {
        residual(problem, extent, point, theta.len()).map_or(f64::INFINITY, |r| r.norm_squared())
    };
    let costs: Vec<f64> = grid.par_iter().map(cost).collect();
    let mut order: Vec<usize> = (0..grid.len()).collect();
    order.sort_by(|i, j| costs[*i].total_cmp(&costs[*j]));
    let best = order.into_iter().take(DESCENTS).map(|i| grid[i].clone());
    let none = SimpleLaw { stiffness: 0.0, hardening: 0.0, drag: FIRST_DRAG };
    std::iter::once(start(theta, none)).chain(best).collect()
}

/// Fits a law of `extent` to `problem`, beside a plain fit with the baseline's numbers `theta`.
///
/// None where no start can be predicted.
#[must_use]
pub fn fit_law(problem: &Problem, extent: Extent, theta: &[f64]) -> Option<LawFit> {
    let all = starts(problem, &extent, theta);
    let fits = all.into_par_iter().filter_map(|start| descend(problem, extent, start, theta.len()));
    fits.min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// Fits the law of `fit` again to `problem`, from its numbers and `theta` on.
#[must_use]
pub fn fit_again(problem: &Problem, fit: &LawFit, theta: &[f64]) -> Option<LawFit> {
    let start = DVector::from_iterator(theta.len() + NUMBERS, theta.iter().chain(&fit.numbers).copied());
    descend(problem, fit.extent, start, theta.len())
}

/// Descends from `point`.
fn descend(problem: &Problem, extent: Extent, mut point: DVector<f64>, thetas: usize) -> Option<LawFit> {
    let bounds: Vec<f64> = vec![f64::NEG_INFINITY; thetas].into_iter().chain(least()).collect();
    let mut at = residual(problem, &extent, &point, thetas)?;
    let mut jacobian = derivatives(problem, &extent, &point, thetas, &at)?;
    let mut lambda = 1e-3;
    for _ in 0..STEPS {
        let (normal, slope) = (jacobian.tr_mul(&jacobian), jacobian.tr_mul(&at));
        let mut gained = None;
        for _ in 0..TRIES {
            let mut damped = normal.clone();
            (0..damped.nrows()).for_each(|i| damped[(i, i)] *= 1.0 + lambda);
            let right = &damped * &point - &slope;
            let tried = bounded(&damped, &right, &bounds);
            let there = tried.and_then(|next| Some((residual(problem, &extent, &next, thetas)?, next)));
            match there.filter(|(there, _)| there.norm_squared() < at.norm_squared()) {
                Some((there, next)) => {
                    gained = Some(at.norm_squared() - there.norm_squared());
                    (at, point) = (there, next);
                    lambda = f64::max(0.2 * lambda, 1e-9);
                    break;
                }
                None => lambda *= 10.0,
            }
        }
        let Some(gained) = gained else { break };
        jacobian = derivatives(problem, &extent, &point, thetas, &at)?;
        if gained < SETTLED {
            break;
        }
    }
    let (theta, numbers) = point.as_slice().split_at(thetas);
    Some(LawFit {
        extent,
        law: extent.law(numbers)?,
        theta: theta.to_vec(),
        numbers: numbers.to_vec(),
        cost: at.norm_squared(),
        residual: at,
        jacobian,
    })
}
