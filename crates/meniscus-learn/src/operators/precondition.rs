//! Preconditioners of the implicit step. That of the blob is the constant matrix with which it converges best on motions of the liquid. It
//! changes the number of iterations and no law.

use crate::data::trajectory::Path;
use crate::operators::reference_step::{Dynamics, Square};
use meniscus::latent::generic::Latent;
use meniscus::units::FRAME_INTERVAL_S;

/// Iterations that the run time gives it, before it takes Newton's.
const ITERATIONS: usize = 12;

/// Every so many frames of the paths are tried.
const STRIDE: usize = 7;

/// Levels of phi, each three times the one before, for which a preconditioner is at hand.
pub(crate) const LEVELS: [f64; 4] = [0.5, 1.5, 4.5, 13.5];

impl Dynamics {
    /// P = (I - dt/2 (L - D) grad^2 H(0))^-1, or the identity where that is singular.
    #[must_use]
    pub(crate) fn preconditioner(&self) -> Square {
        self.precondition(&self.stiffness())
    }

    /// P for a stiffness.
    #[must_use]
    pub(crate) fn precondition(&self, stiffness: &Square) -> Square {
        self.precondition_at(stiffness, 1.0)
    }

    /// P for a stiffness, one for each of [`LEVELS`] under a friction law.
    #[must_use]
    pub(crate) fn preconditioners(&self, stiffness: &Square) -> Vec<Square> {
        let levels: &[f64] = if self.law.is_some() { &LEVELS } else { &[1.0] };
        levels.iter().map(|&level| self.precondition_at(stiffness, level)).collect()
    }

    /// P for a stiffness and friction of `factor` times D.
    fn precondition_at(&self, stiffness: &Square, factor: f64) -> Square {
        let flow = self.skew - self.friction * self.friction.transpose() * factor;
        let step = Square::identity() - flow * stiffness * (0.5 * FRAME_INTERVAL_S);
        step.try_inverse().unwrap_or_else(Square::identity)
    }
}

/// Mean of grad^2 H over `states`, each with its weight.
fn mean_stiffness<'a>(
    dynamics: &Dynamics,
    states: impl Iterator<Item = (&'a Latent, f64)>,
) -> Option<Square> {
    let (mut sum, mut total) = (Square::zeros(), 0.0);
    for (x, weight) in states {
        sum += dynamics.stiffness_at(x) * weight;
        total += weight;
    }
    (total > 0.0).then(|| sum / total)
}

/// P for the mean stiffness over `states`, as [`Dynamics::preconditioners`]: good enough for training, where it is renewed as H
/// changes.
#[must_use]
pub(crate) fn typical<'a>(dynamics: &Dynamics, states: impl Iterator<Item = &'a Latent>) -> Vec<Square> {
    let mean = mean_stiffness(dynamics, states.step_by(31).map(|x| (x, 1.0)));
    dynamics.preconditioners(&mean.unwrap_or_else(|| dynamics.stiffness()))
}

/// Mean logarithm of what the iterations of the run time leave of the turns of `paths`; below rounding
/// it is as good as zero.
fn left_over(dynamics: &Dynamics, paths: &[Path], preconditioner: &Square) -> f64 {
    let turns = paths.iter().flat_map(|p| p.x.iter().zip(p.u.iter().skip(1))).step_by(STRIDE);
    turns.map(|(x, &u)| (dynamics.residual(x, u, preconditioner, ITERATIONS) + 1e-15).ln()).sum()
}

/// The P between that of rest and beyond that of lively states which leaves least.
#[must_use]
pub(crate) fn best(dynamics: &Dynamics, paths: &[Path]) -> Square {
    let states = paths.iter().flat_map(|p| &p.x).step_by(STRIDE);
    let at_rest = dynamics.stiffness();
    let lively = mean_stiffness(dynamics, states.map(|x| (x, dynamics.energy(x)))).unwrap_or(at_rest);
    let blends = (0..=10).map(|k| at_rest + (lively - at_rest) * (0.125 * f64::from(k)));
    let candidates = blends.map(|stiffness| dynamics.precondition(&stiffness));
    let judged = candidates.map(|p| (left_over(dynamics, paths, &p), p));
    judged.min_by(|a, b| a.0.total_cmp(&b.0)).map_or_else(|| dynamics.preconditioner(), |(_, p)| p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::networks::noise::normal;
    use crate::operators::reference_step::tests::random;

    #[test]
    fn the_best_leaves_less_than_none() {
        let (dynamics, mut rng) = random(31);
        let u: Vec<f64> = (0..80).map(|_| normal(&mut rng)).collect();
        let x = dynamics.roll_out(Latent::zeros(), &u);
        let paths = [Path { x, energy: vec![0.0; u.len()], heat: vec![0.0; u.len()], u }];
        let left = left_over(&dynamics, &paths, &best(&dynamics, &paths));
        assert!(
            left <= left_over(&dynamics, &paths, &dynamics.preconditioner()),
            "no worse than that of rest"
        );
        assert!(left < left_over(&dynamics, &paths, &Square::identity()), "better than none");
    }
}
