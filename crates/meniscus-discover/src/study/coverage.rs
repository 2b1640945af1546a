//! Whether intervals hold the truth as often as they say: data drawn from the model itself, with effects
//! drawn over their usual sizes, baseline and errors from prior and covariance (Talts et al. 2018).

use super::super::fit::{fit, fit_beside, search};
use super::super::problem::Problem;
use meniscus::reduced::effects::{Active, find};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Effects whose first parameter is drawn.
const DRAWN: [&str; 8] = [
    "viscosity",
    "wall_slip",
    "yield_stress",
    "foam",
    "surface_tension",
    "actuation_gain",
    "camera_pitch",
    "camera_latency",
];

/// Share of `trials` draws in which the 90 % interval of the effect's parameter held the truth.
#[must_use]
pub fn coverage(problem: &Problem, trials: usize, seed: u64) -> f64 {
    let held: usize = (0..trials).into_par_iter().map(|n| usize::from(one(problem, n, seed))).sum();
    held as f64 / trials.max(1) as f64
}

fn one(problem: &Problem, n: usize, seed: u64) -> bool {
    let mut random = ChaCha8Rng::seed_from_u64(seed.wrapping_mul(0x9e37_79b9).wrapping_add(n as u64));
    let mut normal = move || meniscus_numerics::random::normal(&mut random);
    let Some(entry) = find(DRAWN[n % DRAWN.len()]) else { return false };
    let parameter = &entry.parameters[0];
    let theta: Vec<f64> =
        problem.mean.iter().zip(&problem.deviation).map(|(m, s)| m + s * normal()).collect();
    let mut values = entry.neutral();
    values[0] += parameter.typical * (1.0 + 0.3 * normal().clamp(-2.0, 2.0));
    let truth = values[0];
    let drawn = problem.redraw(&theta, &[Active { entry, values }], &mut normal);
    let plain = fit(&drawn, &drawn.mean, &[], &[]);
    let (_, start, _) = search(&drawn, &plain, entry);
    let fitted = fit_beside(&drawn, &plain, entry, &start);
    let place = fitted.theta.len();
    let deviation = fitted.covariance().map_or(f64::INFINITY, |c| c[(place, place)].max(0.0).sqrt());
    (fitted.active[0].values[0] - truth).abs() <= 1.645 * deviation
}
