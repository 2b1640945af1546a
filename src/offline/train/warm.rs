//! Warm start of the GENERIC operators from a linear fit; a cold start was far behind after 300 steps.

use super::TrainError;
use super::generic::{Dynamics, HIDDEN, LATENTS, Latent, Square};
use super::rollout::validate;
use super::weights::Matrix;
use crate::offline::prelude::*;
use crate::units::FRAME_INTERVAL_S;
use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};
use rand_chacha::ChaCha8Rng;

/// What one step is explained by: the state and the port.
const WIDTH: usize = LATENTS + 1;

/// x_{n+1} = A x_n + b u_{n+1}.
#[derive(Clone, Debug)]
pub(super) struct Linear {
    /// A.
    pub(super) a: Square,
    /// b.
    pub(super) b: Latent,
}

/// One observed trajectory: states, the port that led to each, energies in units of H.
#[derive(Clone, Debug)]
pub(super) struct Path {
    /// States.
    pub(super) x: Vec<Latent>,
    /// Ports; `u[n]` acts between frames n - 1 and n.
    pub(super) u: Vec<f64>,
    /// Kinetic plus potential energy over the energy scale.
    pub(super) energy: Vec<f64>,
    /// Heat since the first frame over the energy scale.
    pub(super) heat: Vec<f64>,
}

impl Linear {
    /// Ridge regression of x_{n+1} on (x_n, u_{n+1}) over `paths`, pulled inside the unit circle, with
    /// the ridge that rolls out best.
    ///
    /// Normal stresses follow the acceleration at once, so the state nearly contains the port, and one
    /// step cannot tell them apart: it extrapolates the motion instead of reading it. The ridge is on
    /// the state alone, which leaves the explanation to the port, and roll-outs decide how strong.
    ///
    /// # Errors
    /// [`TrainError::Singular`] when the paths do not determine it.
    pub(super) fn fit(paths: &[Path], metric: &Square) -> Result<Self, TrainError> {
        let (mut normal, mut mixed) =
            (DMatrix::<f64>::zeros(WIDTH, WIDTH), DMatrix::<f64>::zeros(WIDTH, LATENTS));
        for path in paths {
            for ((from, to), &u) in path.x.iter().zip(path.x.iter().skip(1)).zip(path.u.iter().skip(1)) {
                let row = DVector::from_iterator(WIDTH, from.iter().copied().chain([u]));
                normal.ger(1.0, &row, &row, 1.0);
                mixed.ger(1.0, &row, to, 1.0);
            }
        }
        let fits = (0..7).filter_map(|k| Self::ridge(&normal, &mixed, 10.0_f64.powi(k - 7)));
        let judged = fits.map(|fit| (validate(|x, u| fit.roll_out(x, u), paths, metric), fit));
        let best = judged.min_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, fit)| fit).ok_or(TrainError::Singular("the linear fit"))
    }

    /// The solution with a ridge relative to the mean square of the states.
    fn ridge(normal: &DMatrix<f64>, mixed: &DMatrix<f64>, ridge: f64) -> Option<Self> {
        let mut raised = normal.clone();
        let size = normal.trace() / WIDTH as f64;
        (0..LATENTS).for_each(|i| raised[(i, i)] += ridge * size);
        let solution = Cholesky::new(raised)?.solve(mixed);
        let a = Square::from_fn(|i, j| solution[(j, i)]);
        Some(Self { a: pull_inside(a), b: Latent::from_fn(|i, _| solution[(LATENTS, i)]) })
    }

    /// The states after each of `ports`, from `x`.
    #[must_use]
    pub(super) fn roll_out(&self, x: Latent, ports: &[f64]) -> Vec<Latent> {
        let next = |x: &mut Latent, &u: &f64| {
            *x = self.a * *x + self.b * u;
            Some(*x)
        };
        ports.iter().scan(x, next).collect()
    }

    /// Generator M and port B of the Strang step that equals this map for a quadratic H.
    ///
    /// With M = (L - D) Q the closed step is the Cayley transform A = (1 - dt/2 M)^-1 (1 + dt/2 M), so
    /// M = 2/dt (A - 1)(A + 1)^-1, and b = dt/2 (A + 1) B.
    ///
    /// # Errors
    /// [`TrainError::Singular`] when A has the eigenvalue -1.
    pub(super) fn generator(&self) -> Result<(Square, Latent), TrainError> {
        let plus = self.a + Square::identity();
        let inverse = plus.try_inverse().ok_or(TrainError::Singular("the Cayley transform"))?;
        let rate = 2.0 / FRAME_INTERVAL_S;
        Ok(((self.a - Square::identity()) * inverse * rate, inverse * self.b * rate))
    }
}

/// `a` with every eigenvalue of modulus above 0.999 scaled back to it, the others untouched.
///
/// In the real Schur form A = Q T Q^T the eigenvalues are those of the diagonal blocks of T.
fn pull_inside(a: Square) -> Square {
    const MOST: f64 = 0.999;
    let (q, mut t) = a.schur().unpack();
    let mut i = 0;
    while i < LATENTS {
        let size = if i + 1 < LATENTS && t[(i + 1, i)] != 0.0 { 2 } else { 1 };
        let mut block = t.view_mut((i, i), (size, size));
        let radius = if size == 1 { block[(0, 0)].abs() } else { block.determinant().abs().sqrt() };
        if radius > MOST {
            block *= MOST / radius;
        }
        i += size;
    }
    q * t * q.transpose()
}

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

/// Splits a stable generator M into (L - D) Q with L skew, D >= 0, Q > 0, and Q near `energy`.
///
/// R = -(M^T Q + Q M) must not be negative. Where the regressed Q makes it so, its eigenvalues are
/// raised and the Lyapunov equation gives the Q of the raised R; then D = Q^-1 R Q^-1 / 2 >= 0 and
/// L - D = M Q^-1 holds exactly: clipping costs no part of the linear motion.
///
/// # Errors
/// [`TrainError::Singular`] when M is not stable.
pub(super) fn split(m: &Square, energy: &Square) -> Result<(Square, Square, Square), TrainError> {
    let error = TrainError::Singular("the split of the generator");
    let dissipation = -(m.transpose() * energy + energy * m);
    let raised = raise(&dissipation, 1e-8);
    let q = lyapunov(m, &raised).ok_or(error.clone())?;
    let k = Cholesky::new(q).ok_or(error.clone())?;
    let flow = m * k.inverse();
    let skew = (flow - flow.transpose()) * 0.5;
    let friction = raise(&((flow + flow.transpose()) * -0.5), 1e-12);
    let c = Cholesky::new(friction).ok_or(error)?.l();
    Ok((skew, c, k.l().transpose()))
}

/// Dynamics that equal the linear fit but for a small nonlinear part of H to grow from.
///
/// # Errors
/// [`TrainError::Singular`] when the paths do not determine a stable generator.
pub(super) fn start(linear: &Linear, paths: &[Path], rng: &mut ChaCha8Rng) -> Result<Dynamics, TrainError> {
    let (m, port) = linear.generator()?;
    let energy = regress_energy(paths);
    // A direction of no energy cannot drive one that has some: the higher the floor under Q, the less
    // the Lyapunov equation must add to the rest, so the floor is a trade and the books decide.
    let splits = [1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3].map(|floor| split(&m, &raise(&energy, floor)));
    let books = |k: &Square| {
        let all = paths.iter().flat_map(|p| p.x.iter().zip(&p.energy));
        all.map(|(x, e)| (0.5 * (k * x).norm_squared() - e).powi(2)).sum::<f64>()
    };
    let best = splits.into_iter().flatten().min_by(|a, b| books(&a.2).total_cmp(&books(&b.2)));
    let (skew, friction, k) = best.ok_or(TrainError::Singular("the split of the generator"))?;
    let bound = 1.0 / (LATENTS as f64).sqrt();
    Ok(Dynamics {
        skew,
        friction,
        linear: k,
        inner: Matrix::uniform(HIDDEN, LATENTS, bound, rng).to_f64(),
        bias: Matrix::uniform(HIDDEN, 1, bound, rng).to_f64().column(0).into(),
        outer: Matrix::uniform(HIDDEN, HIDDEN, 0.1 / (HIDDEN as f64).sqrt(), rng).to_f64(),
        port,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::offline::train::generic::tests::random;
    use crate::offline::train::noise::normal;

    /// A stable generator with known parts, split with a wrong idea of its energy.
    #[test]
    fn split_reproduces_the_linear_generator() {
        let (dynamics, mut rng) = random(7);
        let m = dynamics.flow() * dynamics.stiffness();
        let wrong = Square::from_fn(|_, _| 0.2 * normal(&mut rng));
        let guess = dynamics.stiffness() + wrong * wrong.transpose();
        let (skew, c, k) = split(&m, &guess).expect("a stable generator");
        assert!((skew + skew.transpose()).norm() < 1e-9, "L is skew");
        let again = (skew - c * c.transpose()) * (k.transpose() * k);
        assert!((again - m).norm() < 1e-6 * m.norm(), "{} of {}", (again - m).norm(), m.norm());
    }

    /// The fit finds the map that made the paths, and the step started from it makes them again.
    #[test]
    fn warm_start_rolls_out_like_the_linear_fit() {
        let (truth, mut rng) = random(8);
        let mut quadratic = truth;
        quadratic.outer.fill(0.0);
        let path = |rng: &mut ChaCha8Rng| {
            let u: Vec<f64> = (0..300).map(|_| normal(rng)).collect();
            let x = quadratic.roll_out(Latent::zeros(), &u);
            let energy = x.iter().map(|x| quadratic.energy(x)).collect();
            let heat = vec![0.0; x.len()];
            Path { x, u, energy, heat }
        };
        let paths = [path(&mut rng), path(&mut rng)];
        let linear = Linear::fit(&paths, &Square::identity()).expect("a determined fit");
        let mut warm = start(&linear, &paths, &mut rng).expect("a stable fit");
        warm.outer.fill(0.0);
        let (ours, theirs) = (warm.roll_out(Latent::zeros(), &paths[0].u), &paths[0].x);
        let miss: f64 = ours.iter().zip(theirs).map(|(a, b)| (a - b).norm_squared()).sum();
        let size: f64 = theirs.iter().map(nalgebra::Matrix::norm_squared).sum();
        assert!((miss / size).sqrt() < 0.1, "{}", (miss / size).sqrt());
    }
}
