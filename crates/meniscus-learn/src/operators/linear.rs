//! The best linear map from frame to frame under known motion: a baseline, and where the dynamics start.

use crate::TrainError;
use crate::data::trajectory::Path;
use crate::operators::open_loop::validate;
use crate::operators::reference_step::Square;
use meniscus::latent::generic::{LATENTS, Latent};
use meniscus::units::FRAME_INTERVAL_S;
use nalgebra::{Cholesky, DMatrix, DVector};

/// Regressors of one step: the state and the port.
const WIDTH: usize = LATENTS + 1;

/// x_{n+1} = A x_n + b u_{n+1}.
#[derive(Clone, Debug)]
pub(crate) struct Linear {
    /// A.
    pub(crate) a: Square,
    /// b.
    pub(crate) b: Latent,
}

impl Linear {
    /// Ridge regression of x_{n+1} on (x_n, u_{n+1}) over `paths`, pulled inside the unit circle, with
    /// the ridge that rolls out best.
    ///
    /// Normal stresses follow the acceleration at once, so the state nearly contains the port, and one
    /// step cannot distinguish them: it extrapolates the motion instead of reading it. The ridge is on
    /// the state alone, which leaves the explanation to the port, and roll-outs decide how strong.
    ///
    /// # Errors
    /// [`TrainError::Singular`] when the paths do not determine it.
    pub(crate) fn fit(paths: &[Path], metric: &Square) -> Result<Self, TrainError> {
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

    /// The same map of the states `forth` x; `back` is the way back.
    #[must_use]
    pub(crate) fn mapped(&self, forth: &Square, back: &Square) -> Self {
        Self { a: forth * self.a * back, b: forth * self.b }
    }

    /// The states after each of `ports`, from `x`.
    #[must_use]
    pub(crate) fn roll_out(&self, x: Latent, ports: &[f64]) -> Vec<Latent> {
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
    pub(crate) fn generator(&self) -> Result<(Square, Latent), TrainError> {
        let plus = self.a + Square::identity();
        let inverse = plus.try_inverse().ok_or(TrainError::Singular("the Cayley transform"))?;
        let rate = 2.0 / FRAME_INTERVAL_S;
        Ok(((self.a - Square::identity()) * inverse * rate, inverse * self.b * rate))
    }
}

/// A = (1 - dt/2 M)^-1 (1 + dt/2 M), or rest where that is singular.
pub(crate) fn cayley(m: &Square) -> Square {
    let half = m * (0.5 * FRAME_INTERVAL_S);
    let inverse = (Square::identity() - half).try_inverse();
    inverse.map_or_else(Square::zeros, |inverse| inverse * (Square::identity() + half))
}

/// `a` with every eigenvalue of modulus above 0.999 scaled back to it and every negative real one set to
/// zero, the others untouched: what changes sign from frame to frame is noise, and the Cayley transform
/// would make it a friction without bound.
///
/// In the real Schur form A = Q T Q^T the eigenvalues are those of the diagonal blocks of T.
fn pull_inside(a: Square) -> Square {
    const MOST: f64 = 0.999;
    let (q, mut t) = a.schur().unpack();
    let mut i = 0;
    while i < LATENTS {
        let size = if i + 1 < LATENTS && t[(i + 1, i)] != 0.0 { 2 } else { 1 };
        let mut block = t.view_mut((i, i), (size, size));
        if size == 1 {
            block[(0, 0)] = block[(0, 0)].clamp(0.0, MOST);
        } else {
            let radius = block.determinant().abs().sqrt();
            block *= (MOST / radius).min(1.0);
        }
        i += size;
    }
    q * t * q.transpose()
}
