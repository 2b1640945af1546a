//! A recording small enough to ship: each field group as a truncated singular value decomposition.
//!
//! With `A` (numbers x frames) the group minus its rest state, the method of snapshots (Sirovich
//! 1987) takes the small eigenproblem instead of the large decomposition:
//! ```text
//! A^T A u_k = lambda_k u_k,   mode_k ~ A u_k,   A ~ sum_k mode_k coefficient_k^T
//! ```
//! The relative error of keeping r modes is `sqrt(sum_{k >= r} lambda_k / sum lambda_k)`. For a small
//! file everything is rounded: modes are scaled to the largest entry 1, strong ones kept in half
//! precision and weak ones (below 5 % of the whole) in steps of 1/127, which adds about 1 % of their
//! own small size; coefficients in half precision of the largest of their mode. The error that is
//! stated is measured after all rounding.

use super::{Recording, STATE, States, group_range};
use half::f16;
use meniscus::latent::decoder::GROUP_COMPONENTS;
use nalgebra::{DMatrix, SymmetricEigen};

/// Rest state plus, for each group, `coefficients x modes`, truncated at a stated relative error.
#[derive(Clone, Debug, PartialEq)]
pub struct Factored {
    /// The reference that the product is added to, the first frame (at rest): [`STATE`] numbers.
    pub reference: Vec<f32>,
    /// Frames x rank, row-major, one matrix a group; in units of a mode's largest, half-precision numbers.
    pub coefficients: [Vec<f32>; 5],
    /// Rank x numbers of the group, row-major, one matrix a group; the largest of a mode is 1.
    pub modes: [Vec<f32>; 5],
    /// Leading modes of each group that are half-precision numbers; the others are multiples of 1/127.
    pub strong: [usize; 5],
    /// Relative L2 error of the truncation over the recording, by group, of the fluctuation about
    /// the reference.
    pub truncation: [f32; 5],
}

impl Factored {
    /// Factors the states of `recording`, each group with as few modes as keep the relative L2 error
    /// of its fluctuation at `tolerance` (before rounding).
    #[must_use]
    pub fn from(recording: &Recording, tolerance: f64) -> Self {
        let frames = recording.frames();
        let mut states = vec![0.0_f32; frames * STATE];
        for (frame, row) in states.chunks_exact_mut(STATE).enumerate() {
            recording.state(frame, row);
        }
        let mut factored = Self {
            reference: states.iter().copied().take(STATE).collect(),
            coefficients: std::array::from_fn(|_| Vec::new()),
            modes: std::array::from_fn(|_| Vec::new()),
            strong: [0; 5],
            truncation: [0.0; 5],
        };
        for group in 0..GROUP_COMPONENTS.len() {
            let range = group_range(group);
            let fluctuation = DMatrix::from_fn(range.len(), frames, |i, frame| {
                let i = range.start + i;
                f64::from(states[frame * STATE + i]) - f64::from(factored.reference[i])
            });
            let truncated = truncate(&fluctuation, tolerance);
            factored.coefficients[group] = truncated.coefficients;
            factored.modes[group] = truncated.modes;
            factored.strong[group] = truncated.strong;
            factored.truncation[group] = truncated.error as f32;
        }
        factored
    }

    /// Number of modes kept in `group`.
    #[must_use]
    pub fn rank(&self, group: usize) -> usize {
        self.modes[group].len() / group_range(group).len()
    }

    /// Writes the full state of `frame` into `out` ([`STATE`] numbers).
    ///
    /// # Panics
    /// When `frame` or the length of `out` is out of range.
    pub fn state(&self, frame: usize, out: &mut [f32]) {
        assert_eq!(out.len(), STATE, "a full state has {STATE} numbers");
        out.copy_from_slice(&self.reference);
        for group in 0..GROUP_COMPONENTS.len() {
            let range = group_range(group);
            let (rank, width) = (self.rank(group), range.len());
            let row = &self.coefficients[group][frame * rank..(frame + 1) * rank];
            for (c, mode) in row.iter().zip(self.modes[group].chunks_exact(width)) {
                for (o, m) in out[range.clone()].iter_mut().zip(mode) {
                    *o += c * m;
                }
            }
        }
    }
}

impl Recording {
    /// The same recording with factored states; see [`Factored::from`].
    #[must_use]
    pub fn compact(self, tolerance: f64) -> Self {
        let states = States::Factored(Box::new(Factored::from(&self, tolerance)));
        Self { states, ..self }
    }
}

/// Share of the whole below which a mode is weak.
const WEAK: f64 = 0.05;

/// One group, truncated; fields as in [`Factored`].
struct Truncated {
    coefficients: Vec<f32>,
    modes: Vec<f32>,
    strong: usize,
    error: f64,
}

/// Truncates `a` (numbers x frames) at the relative error `tolerance`.
fn truncate(a: &DMatrix<f64>, tolerance: f64) -> Truncated {
    let (numbers, frames) = a.shape();
    let total = a.norm_squared();
    let eigen = SymmetricEigen::new(a.tr_mul(a));
    let mut order: Vec<usize> = (0..frames).collect();
    order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
    let mut out = Truncated { coefficients: Vec::new(), modes: Vec::new(), strong: 0, error: 0.0 };
    let (mut rank, mut left) = (0, total);
    for k in order {
        let lambda = eigen.eigenvalues[k];
        if left <= tolerance * tolerance * total {
            break;
        }
        let mode = a * eigen.eigenvectors.column(k);
        let largest = mode.amax();
        if lambda >= WEAK * WEAK * total {
            out.strong += 1;
            out.modes.extend(mode.iter().map(|m| half(m / largest)));
        } else {
            out.modes.extend(mode.iter().map(|m| (127.0 * m / largest).round() as f32 / 127.0));
        }
        left -= lambda;
        rank += 1;
    }
    if rank == 0 {
        return out;
    }
    // Rounded modes are no longer quite orthogonal: the coefficients are fitted by least squares.
    let basis = DMatrix::from_iterator(numbers, rank, out.modes.iter().map(|m| f64::from(*m)));
    let fitted = basis.tr_mul(&basis).cholesky().map(|c| c.solve(&basis.tr_mul(a)));
    let mut fitted = fitted.unwrap_or_else(|| DMatrix::zeros(rank, frames));
    for mut row in fitted.row_iter_mut() {
        let largest = row.amax() as f32;
        row.apply(|c| *c = f64::from(half(*c / f64::from(largest)) * largest));
    }
    out.error = ((a - &basis * &fitted).norm_squared() / total).sqrt();
    // Column-major rank x frames is row-major frames x rank.
    out.coefficients = fitted.iter().map(|c| *c as f32).collect();
    out
}

/// `x` rounded to half precision.
fn half(x: f64) -> f32 {
    f16::from_f64(x).to_f32()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_low_rank_matrix_comes_back_and_the_stated_error_is_the_measured_one() {
        let a = DMatrix::from_fn(200, 30, |i, t| {
            let (i, t) = (i as f64 * 0.05, t as f64 * 0.3);
            i.sin() * t.cos() + 0.3 * (2.0 * i).cos() * t.sin() + 0.01 * (5.0 * i).sin() * (3.0 * t).cos()
        });
        let Truncated { coefficients, modes, strong, error } = truncate(&a, 0.05);
        assert_eq!((modes.len() / 200, strong), (2, 2));
        assert!(error < 0.05, "{error}");
        let product = DMatrix::from_fn(200, 30, |i, t| {
            (0..2).map(|k| f64::from(coefficients[t * 2 + k]) * f64::from(modes[k * 200 + i])).sum()
        });
        let measured = (&a - product).norm() / a.norm();
        assert!((measured - error).abs() < 1e-6, "{measured} {error}");
        let Truncated { modes, strong, error, .. } = truncate(&a, 1e-3);
        assert_eq!((modes.len() / 200, strong), (3, 2));
        assert!(error < 1e-3, "rounding leaves {error}");
    }
}
