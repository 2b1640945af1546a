//! Warm start of the GENERIC operators from a linear fit; a cold start was far behind after 300 steps.

use crate::TrainError;
use crate::data::trajectory::Path;
use crate::hyperparameters::WarmStartParameters;
use crate::operators::linear::{Linear, cayley};
use crate::operators::open_loop::validate;
use crate::operators::reference_step::{Dynamics, HIDDEN, Square};
use meniscus::latent::generic::{LATENTS, Latent};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_optim::weights::Matrix;
use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};
use rand_chacha::ChaCha8Rng;

/// Q of the physical energy, E = x^T Q x / 2, by weighted ridge regression; it may come out indefinite.
fn regress_energy(paths: &[Path]) -> Square {
    let pairs: Vec<(usize, usize)> = (0..LATENTS).flat_map(|i| (0..=i).map(move |j| (i, j))).collect();
    let mut normal = DMatrix::<f64>::zeros(pairs.len(), pairs.len());
    let mut mixed = DVector::<f64>::zeros(pairs.len());
    for (x, &energy) in paths.iter().flat_map(|p| p.x.iter().zip(&p.energy)) {
        let entry = |&(i, j): &(usize, usize)| if i == j { 0.5 * x[i] * x[i] } else { x[i] * x[j] };
        let row = DVector::from_iterator(pairs.len(), pairs.iter().map(entry));
        // Small energies count too, but not below the noise of the books.
        let weight = 1.0 / (0.1 + energy.abs());
        normal.ger(weight, &row, &row, 1.0);
        mixed.axpy(weight * energy, &row, 1.0);
    }
    let ridge = 1e-4 * normal.trace() / pairs.len() as f64;
    (0..pairs.len()).for_each(|i| normal[(i, i)] += ridge);
    let solution = Cholesky::new(normal).map_or_else(|| mixed.clone(), |c| c.solve(&mixed));
    let mut q = Square::zeros();
    for (&(i, j), &value) in pairs.iter().zip(solution.iter()) {
        q[(i, j)] = value;
        q[(j, i)] = value;
    }
    q
}

/// `m` with its eigenvalues raised to at least `floor` times the largest.
fn raise(m: &Square, floor: f64) -> Square {
    let eigen = SymmetricEigen::new((m + m.transpose()) * 0.5);
    let least = floor * eigen.eigenvalues.amax();
    let values = eigen.eigenvalues.map(|l| l.max(least));
    eigen.eigenvectors * Square::from_diagonal(&values) * eigen.eigenvectors.transpose()
}

/// Q of M^T Q + Q M = -R, as one linear system in the entries of Q.
fn lyapunov(m: &Square, r: &Square) -> Option<Square> {
    const ENTRIES: usize = LATENTS * LATENTS;
    let (id, t) =
        (DMatrix::<f64>::identity(LATENTS, LATENTS), DMatrix::from_fn(LATENTS, LATENTS, |i, j| m[(j, i)]));
    let system = id.kronecker(&t) + t.kronecker(&id);
    let right = DVector::from_iterator(ENTRIES, r.iter().map(|v| -v));
    let q = Square::from_iterator(system.lu().solve(&right)?.iter().copied());
    Some((q + q.transpose()) * 0.5)
}

/// A split M = (L - D) Q: L, C with D = C C^T, and K with Q = K^T K.
#[derive(Clone, Copy, Debug)]
struct Split {
    skew: Square,
    friction: Square,
    linear: Square,
}

/// Splits a stable generator M into (L - D) Q with L skew, D >= 0, Q > 0, and Q near `energy`.
///
/// R = -(M^T Q + Q M) must not be negative, for D = Q^-1 R Q^-1 / 2. Where the regressed Q makes it so,
/// two ways lead out. Adding to Q what the Lyapunov equation gives for the negative part of R keeps the
/// motion exactly and falsifies the energy; clipping D keeps the energy and changes the motion. `share`
/// goes from the second (0) to the first (1).
fn split(m: &Square, energy: &Square, share: f64) -> Option<Split> {
    let dissipation = -(m.transpose() * energy + energy * m);
    let missing = raise(&dissipation, 1e-8) - dissipation;
    let q = energy + lyapunov(m, &missing)? * share;
    let k = Cholesky::new(q)?;
    let flow = m * k.inverse();
    let friction = raise(&((flow + flow.transpose()) * -0.5), 1e-9);
    Some(Split {
        skew: (flow - flow.transpose()) * 0.5,
        friction: Cholesky::new(friction)?.l(),
        linear: k.l().transpose(),
    })
}

/// The split that is the best compromise between motion and books over `paths`.
fn compromise(
    linear: &Linear,
    paths: &[Path],
    metric: &Square,
    parameters: &WarmStartParameters,
) -> Result<(Split, Latent), TrainError> {
    let (m, port) = linear.generator()?;
    let energy = regress_energy(paths);
    let size: f64 = paths.iter().flat_map(|p| &p.energy).map(|e| e * e).sum();
    let judge = |split: &Split| {
        let q = split.linear.transpose() * split.linear;
        let a = cayley(&((split.skew - split.friction * split.friction.transpose()) * q));
        let fit = Linear { a, b: (a + Square::identity()) * port * (0.5 * FRAME_INTERVAL_S) };
        let all = paths.iter().flat_map(|p| p.x.iter().zip(&p.energy));
        let books =
            all.map(|(x, e)| (0.5 * (split.linear * x).norm_squared() - e).powi(2)).sum::<f64>() / size;
        validate(|x, u| fit.roll_out(x, u), paths, metric) + parameters.energy_error_weight * books.sqrt()
    };
    // A direction of no energy cannot drive one that has some, so every latent is given energy in
    // proportion to its share in the decoded fields; how much is a trade as well. Both H and |U x|^2
    // have a mean of about one.
    let grounded = |floor: f64| raise(&energy, 1e-6) + metric.transpose() * metric * (2.0 * floor);
    let floors = &parameters.grounding;
    let shares = parameters.lyapunov_shares;
    let all = floors.iter().flat_map(|&floor| shares.map(|share| split(&m, &grounded(floor), share)));
    let best = all.flatten().map(|s| (judge(&s), s)).min_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, split)| (split, port)).ok_or(TrainError::Singular("the split of the generator"))
}

/// Dynamics near the linear fit, with a small nonlinear part of H to grow from.
///
/// # Errors
/// [`TrainError::Singular`] when the paths do not determine a stable generator.
pub(crate) fn start(
    linear: &Linear,
    paths: &[Path],
    metric: &Square,
    parameters: &WarmStartParameters,
    rng: &mut ChaCha8Rng,
) -> Result<Dynamics, TrainError> {
    let (Split { skew, friction, linear }, port) = compromise(linear, paths, metric, parameters)?;
    let bound = 1.0 / (LATENTS as f64).sqrt();
    Ok(Dynamics {
        skew,
        friction,
        linear,
        // The energy bends with what carries energy, K x, not with silent latents.
        inner: Matrix::uniform(HIDDEN, LATENTS, bound, rng).to_f64()
            * DMatrix::from_fn(LATENTS, LATENTS, |i, j| linear[(i, j)]),
        bias: Matrix::uniform(HIDDEN, 1, bound, rng).to_f64().column(0).into(),
        weight: Matrix::uniform(HIDDEN, 1, 0.1, rng).to_f64().column(0).into(),
        port,
        law: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::networks::noise::normal;
    use crate::operators::reference_step::tests::random;

    /// A stable generator with known parts, split with a wrong idea of its energy.
    #[test]
    fn split_reproduces_the_linear_generator() {
        let (dynamics, mut rng) = random(7);
        let m = dynamics.flow() * dynamics.stiffness();
        let wrong = Square::from_fn(|_, _| 0.2 * normal(&mut rng));
        let guess = dynamics.stiffness() + wrong * wrong.transpose();
        let Split { skew, friction: c, linear: k } = split(&m, &guess, 1.0).expect("a stable generator");
        assert!((skew + skew.transpose()).norm() < 1e-9, "L is skew");
        let again = (skew - c * c.transpose()) * (k.transpose() * k);
        assert!((again - m).norm() < 1e-6 * m.norm(), "{} of {}", (again - m).norm(), m.norm());
    }

    /// The fit finds the map that made the paths, and the step started from it makes them again.
    #[test]
    fn warm_start_rolls_out_like_the_linear_fit() {
        let (truth, mut rng) = random(8);
        let mut quadratic = truth;
        quadratic.weight.fill(0.0);
        // Many short paths from anywhere, so that no direction is left unexplored.
        let path = |rng: &mut ChaCha8Rng| {
            let u: Vec<f64> = (0..60).map(|_| normal(rng)).collect();
            let x = quadratic.roll_out(Latent::from_fn(|_, _| 3.0 * normal(rng)), &u);
            let energy = x.iter().map(|x| quadratic.energy(x)).collect();
            let heat = vec![0.0; x.len()];
            Path { x, u, energy, heat }
        };
        let paths: Vec<Path> = (0..40).map(|_| path(&mut rng)).collect();
        let linear = Linear::fit(&paths, &Square::identity()).expect("a determined fit");
        let (m, port) = linear.generator().expect("no eigenvalue -1");
        let split = split(&m, &raise(&regress_energy(&paths), 1e-3), 1.0).expect("a stable generator");
        let warm =
            Dynamics { skew: split.skew, friction: split.friction, linear: split.linear, port, ..quadratic };
        let (x, u) = (paths[0].x[0], &paths[0].u[1..]);
        for (ours, theirs) in warm.roll_out(x, u).iter().zip(linear.roll_out(x, u)) {
            assert!((ours - theirs).norm() < 1e-4 * x.norm(), "{}", (ours - theirs).norm());
        }
        let miss = validate(|x, u| linear.roll_out(x, u), &paths, &Square::identity());
        assert!(miss < 0.02, "the fit finds the map that made the paths: {miss}");
    }
}
