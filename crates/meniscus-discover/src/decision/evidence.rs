//! Evidence for a verdict: bootstrap, and cross-validation by recording.

use super::rank::Candidate;
use crate::baseline::predict::{Difference, SHARED};
use crate::fitting::fit::{Fitted, fit};
use crate::fitting::problem::Problem;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Draws of the bootstrap.
const DRAWS: usize = 200;

/// Frames of a block of the bootstrap: a fifth of a second at 60 Hz.
const BLOCK: usize = 12;

/// Returns the share of bootstrap draws of blocks in which the first of `rivals` stays ahead of the others and of no
/// effect.
#[must_use]
pub fn inclusion(problem: &Problem, rivals: &[Candidate], plain: &Fitted, seed: u64) -> f64 {
    let places = problem.places();
    let mut names: Vec<(usize, usize)> = places.iter().map(|(r, _, f)| (*r, f / BLOCK)).collect();
    names.dedup();
    names.sort_unstable();
    names.dedup();
    let block = |r: usize, f: usize| names.binary_search(&(r, f / BLOCK)).unwrap_or(0);
    let sums = |fitted: &Fitted| {
        let mut sums = vec![0.0; names.len()];
        for ((r, _, f), e) in places.iter().zip(fitted.residual.iter()) {
            sums[block(*r, *f)] += e * e;
        }
        sums
    };
    let mut all = vec![(sums(plain), 0.0)];
    let penalty = (problem.count() as f64).ln();
    for rival in rivals.iter().filter_map(|rival| rival.fitted.as_ref()) {
        let prior = rival.residual.rows_range(problem.count()..).norm_squared();
        all.push((sums(rival), penalty * rival.free.len() as f64 + prior));
    }
    all[0].1 = plain.residual.rows_range(problem.count()..).norm_squared();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut won = 0;
    for _ in 0..DRAWS {
        let drawn: Vec<usize> = (0..names.len()).map(|_| random.random_range(0..names.len())).collect();
        let cost = |(sums, extra): &(Vec<f64>, f64)| drawn.iter().map(|b| sums[*b]).sum::<f64>() + extra;
        let mine = cost(&all[1]);
        won += usize::from(all.iter().enumerate().all(|(i, other)| i == 1 || cost(other) >= mine));
    }
    won as f64 / DRAWS as f64
}

/// Score of a fit on recordings that it did not see, each left out in turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldOutScore {
    /// Recordings that are predicted better with the effects than without.
    pub better: usize,
    /// Recordings that were left out.
    pub recordings: usize,
    /// Improvement over all of them, in units of minus twice the logarithmic score.
    pub improvement: f64,
}

/// Scores `chosen` against `plain` on recordings that the fits do not see.
///
/// Each recording is left out in turn and everything is fitted again, because a strong effect is not linear in its
/// parameters.
#[must_use]
pub fn cross_validate(problem: &Problem, plain: &Fitted, chosen: &Fitted) -> HeldOutScore {
    let recordings = problem.counts().len();
    let improvement = |which: usize| {
        let others = problem.without(which);
        let score = |fitted: &Fitted| {
            let mut start = fitted.theta.clone();
            start.remove(SHARED + which);
            let without = fit(&others, &start, &fitted.active, &fitted.free);
            let difference = Difference { active: &without.active, law: None };
            problem.held_out_misfit(which, &without.theta, difference)
        };
        score(plain) - score(chosen)
    };
    let improvements: Vec<f64> = (0..recordings).into_par_iter().map(improvement).collect();
    HeldOutScore {
        better: improvements.iter().filter(|gained| **gained > 0.0).count(),
        recordings,
        improvement: improvements.iter().sum(),
    }
}
