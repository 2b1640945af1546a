//! How firmly a verdict stands: the bootstrap, recordings left out, and what recordings can tell apart.

use super::fit::{Fitted, derivatives, free_of};
use super::problem::Problem;
use super::rank::Candidate;
use crate::effects::{Active, Entry};
use crate::offline::prelude::*;
use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Frames of a block of the bootstrap.
const BLOCK: usize = 12;

/// Share of draws of blocks in which the first of `rivals` keeps the lead over the others and over none.
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
    const DRAWS: usize = 200;
    let mut won = 0;
    for _ in 0..DRAWS {
        let drawn: Vec<usize> = (0..names.len()).map(|_| random.random_range(0..names.len())).collect();
        let cost = |(sums, extra): &(Vec<f64>, f64)| drawn.iter().map(|b| sums[*b]).sum::<f64>() + extra;
        let mine = cost(&all[1]);
        won += usize::from(all.iter().enumerate().all(|(i, other)| i == 1 || cost(other) >= mine));
    }
    won as f64 / DRAWS as f64
}

/// Recordings that are foretold better with the effects when they are left out of the fit, and all, and
/// by how much together: each is taken out to first order, `theta` and parameters follow from the others.
#[must_use]
pub fn held_out(problem: &Problem, plain: &Fitted, chosen: &Fitted) -> ((usize, usize), f64) {
    let counts = problem.counts();
    let score = |fitted: &Fitted, first: usize, rows: usize| {
        let (j, r) = (&fitted.jacobian, &fitted.residual);
        let (own_j, own_r) = (j.rows(first, rows), r.rows(first, rows));
        let square = j.transpose() * j - own_j.transpose() * own_j;
        let slope = j.transpose() * r - own_j.transpose() * own_r;
        let step = square.cholesky().map(|factor| factor.solve(&slope));
        step.map_or(f64::INFINITY, |step| (own_r - own_j * step).norm_squared())
    };
    let (mut better, mut first, mut sum) = (0, 0, 0.0);
    for rows in &counts {
        let gained = score(plain, first, *rows) - score(chosen, first, *rows);
        better += usize::from(gained > 0.0);
        sum += gained;
        first += rows;
    }
    ((better, counts.len()), sum)
}

/// Signatures of the effects of `library` at their typical size, with what the baseline can do taken out:
/// length (signal over noise) and cosines.
#[must_use]
pub fn isolability(
    problem: &Problem,
    plain: &Fitted,
    library: &[&'static Entry],
) -> (Vec<f64>, Vec<Vec<f64>>) {
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
    let length: Vec<f64> = signatures.iter().map(|s| s.norm()).collect();
    let cosine = |a: &DVector<f64>, b: &DVector<f64>| a.dot(b) / (a.norm() * b.norm()).max(1e-12);
    let matrix = signatures.iter().map(|a| signatures.iter().map(|b| cosine(a, b)).collect()).collect();
    (length, matrix)
}
