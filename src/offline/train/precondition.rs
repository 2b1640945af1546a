//! The preconditioner of the blob: the constant matrix with which the implicit step converges best on
//! what the liquid does. It costs or saves iterations and changes no law.

use super::generic::{Dynamics, LATENTS, Latent, Square};
use super::linear::Path;
use crate::offline::prelude::*;

/// Iterations that the run time has.
const ITERATIONS: usize = 16;

/// Every so many frames of the paths are tried.
const STRIDE: usize = 7;

/// Finite step of the second derivative of H.
const STEP: f64 = 1e-5;

/// grad^2 H at `x`, by central differences of the gradient.
fn stiffness(dynamics: &Dynamics, x: &Latent) -> Square {
    let mut columns = Square::zeros();
    for i in 0..LATENTS {
        let mut aside = Latent::zeros();
        aside[i] = STEP;
        let slope = dynamics.gradient(&(x + aside)) - dynamics.gradient(&(x - aside));
        columns.set_column(i, &(slope / (2.0 * STEP)));
    }
    columns
}

/// Mean of grad^2 H over `states`, each with its weight.
fn mean_stiffness<'a>(
    dynamics: &Dynamics,
    states: impl Iterator<Item = (&'a Latent, f64)>,
) -> Option<Square> {
    let (mut sum, mut total) = (Square::zeros(), 0.0);
    for (x, weight) in states {
        sum += stiffness(dynamics, x) * weight;
        total += weight;
    }
    (total > 0.0).then(|| sum / total)
}

/// P for the mean stiffness over `states`: good enough for training, where it is renewed as H changes.
#[must_use]
pub(super) fn typical<'a>(dynamics: &Dynamics, states: impl Iterator<Item = &'a Latent>) -> Square {
    let mean = mean_stiffness(dynamics, states.step_by(31).map(|x| (x, 1.0)));
    mean.map_or_else(|| dynamics.preconditioner(), |stiffness| dynamics.precondition(&stiffness))
}

/// The P between that of rest and beyond that of lively states which leaves least after the iterations
/// of the run time, on the worst of the turns of `paths`.
#[must_use]
pub(super) fn best(dynamics: &Dynamics, paths: &[Path]) -> Square {
    let states = || paths.iter().flat_map(|p| p.x.iter().zip(p.u.iter().skip(1))).step_by(STRIDE);
    let at_rest = dynamics.stiffness();
    let lively = mean_stiffness(dynamics, states().map(|(x, _)| (x, dynamics.energy(x)))).unwrap_or(at_rest);
    let blends = (0..=8).map(|k| at_rest + (lively - at_rest) * (0.25 * f64::from(k)));
    let candidates = blends.map(|stiffness| dynamics.precondition(&stiffness));
    let left =
        |p: &Square| states().map(|(x, &u)| dynamics.residual(x, u, p, ITERATIONS)).fold(0.0, f64::max);
    let judged = candidates.map(|p| (left(&p), p));
    judged.min_by(|a, b| a.0.total_cmp(&b.0)).map_or_else(|| dynamics.preconditioner(), |(_, p)| p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::offline::train::generic::tests::random;
    use crate::offline::train::noise::normal;

    /// On lively states of a curved H the chosen P leaves no more than that of rest.
    #[test]
    fn the_best_leaves_no_more_than_that_of_rest() {
        let (mut dynamics, mut rng) = random(31);
        dynamics.outer *= 3.0;
        let u: Vec<f64> = (0..80).map(|_| 3.0 * normal(&mut rng)).collect();
        let x = dynamics.roll_out(Latent::zeros(), &u);
        let path = Path { x, energy: vec![0.0; u.len()], heat: vec![0.0; u.len()], u };
        let chosen = best(&dynamics, std::slice::from_ref(&path));
        let left = |p: &Square| {
            let turns = path.x.iter().zip(path.u.iter().skip(1)).step_by(STRIDE);
            turns.map(|(x, &u)| dynamics.residual(x, u, p, ITERATIONS)).fold(0.0, f64::max)
        };
        assert!(left(&chosen) <= left(&dynamics.preconditioner()));
        assert!(left(&chosen) < 1e-6, "{}", left(&chosen));
    }
}
