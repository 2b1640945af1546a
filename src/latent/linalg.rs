//! Matrices on latent space: reading one from the blob, and its inverse square root without a panic.

use super::generic::LATENTS;
use super::nn::Matrix;
use crate::math::sqrt;
use nalgebra::SMatrix;

/// A matrix on latent space.
type Square = SMatrix<f64, LATENTS, LATENTS>;

/// M^(-1/2) of a covariance `m`, lower triangular: D^(-1/2) L^-1 of M = L D L^T, by the elimination that makes D of M made on
/// the identity too; what is zero but for rounding counts as a little more. Zeros, which say nothing, of what is no
/// covariance.
#[must_use]
pub(crate) fn whitener(m: &Square) -> Square {
    let rounding = 1e-6 * m.trace() / LATENTS as f64;
    // Columns are rows, as M is symmetric.
    let mut rows = (m + Square::identity() * rounding).data.0;
    let mut white = Square::identity().data.0;
    let (mut rest, mut rest_white, mut column) = (&mut rows[..], &mut white[..], 0);
    while let (Some((first, below)), Some((first_white, below_white))) =
        (rest.split_first_mut(), rest_white.split_first_mut())
    {
        let pivot = first.get(column).copied().unwrap_or(0.0);
        if !(pivot > 0.0 && pivot.is_finite()) {
            return Square::zeros();
        }
        for (row, row_white) in below.iter_mut().zip(below_white.iter_mut()) {
            let share = row.get(column).copied().unwrap_or(0.0) / pivot;
            row.iter_mut().zip(first.iter()).for_each(|(m, f)| *m -= share * f);
            row_white.iter_mut().zip(first_white.iter()).for_each(|(w, f)| *w -= share * f);
        }
        first_white.iter_mut().for_each(|w| *w /= sqrt(pivot));
        (rest, rest_white, column) = (below, below_white, column + 1);
    }
    let white = Square::from_fn(|i, j| white.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0.0));
    if white.iter().all(|w| w.is_finite()) { white } else { Square::zeros() }
}

/// The matrix whose entries `of` gives.
#[must_use]
pub(crate) fn square_of(of: &Matrix<'_>) -> Square {
    square_below(of, 0)
}

/// The matrix whose entries `of` gives from row `first` on.
#[must_use]
pub(crate) fn square_below(of: &Matrix<'_>, first: usize) -> Square {
    Square::from_fn(|i, j| f64::from(of.at(first.saturating_add(i), j)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::pow;

    /// W M W^T = 1, and zeros for a matrix that is not positive definite.
    #[test]
    fn whitened_errors_are_independent() {
        let m = Square::from_fn(|i, j| pow(0.5, i.abs_diff(j) as f64) * ((i + 1) * (j + 1)) as f64);
        let w = whitener(&m);
        assert!((w * m * w.transpose() - Square::identity()).norm() < 1e-4);
        assert_eq!(whitener(&-m), Square::zeros());
    }
}
