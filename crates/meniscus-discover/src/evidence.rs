//! Evidence for a verdict: bootstrap, cross-validation by recording, and isolability of the effects.

use super::fit::{Fitted, derivatives, fit, free_of};
use super::predict::SHARED;
use super::problem::Problem;
use super::rank::Candidate;
use super::verdict::HeldOutScore;
use meniscus::reduced::effects::{Active, Entry};
use nalgebra::DVector;
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
            problem.held_out_misfit(which, &without.theta, &without.active)
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

/// Signatures of effects on these recordings: what they could distinguish.
#[derive(Clone, Debug, PartialEq)]
pub struct Isolability {
    /// Names of the effects.
    pub names: Vec<&'static str>,
    /// Length of each signature, signal over noise.
    pub lengths: Vec<f64>,
    /// Cosines between the signatures.
    pub cosines: Vec<Vec<f64>>,
}

/// Returns the signatures of the effects of `library` at their typical size, without the part that the baseline can
/// reproduce.
#[must_use]
pub fn isolability(problem: &Problem, plain: &Fitted, library: &[&'static Entry]) -> Isolability {
    let jacobian = derivatives(problem, &plain.theta, &[], &[], &plain.residual, Some(&plain.jacobian));
    let basis = jacobian.qr().q();
    let signatures: Vec<DVector<f64>> = library
        .par_iter()
        .map(|entry| {
            let mut values = entry.neutral();
            let which = free_of(problem, entry)[0];
            let parameter = &entry.parameters[which];
            let up = parameter.neutral + parameter.typical;
            values[which] = if up <= parameter.range.1 { up } else { parameter.neutral - parameter.typical };
            let change = problem.residual(&plain.theta, &[Active { entry, values }]) - &plain.residual;
            let part = basis.tr_mul(&change);
            change - &basis * part
        })
        .collect();
    let lengths: Vec<f64> = signatures.iter().map(|s| s.norm()).collect();
    let cosine = |a: &DVector<f64>, b: &DVector<f64>| a.dot(b) / (a.norm() * b.norm()).max(1e-12);
    let cosines = signatures.iter().map(|a| signatures.iter().map(|b| cosine(a, b)).collect()).collect();
    let names = library.iter().map(|entry| entry.name).collect();
    Isolability { names, lengths, cosines }
}
