//! Newton's correction of the closed step, for where the constant preconditioner does not get there.
//!
//! The equation is r(y) = y - x - dt F dH(x, y) = 0 with F = L - D, and its derivative 1 - dt F S with
//!
//! ```text
//! S = K^T K / 2 + W^T diag(w^2 c) W,    c = 1 / (A + A') - (a + a') a' / (A' (A + A')^2) > 0
//! ```
//! (the letters of [`super::Potential`], a' and A' at y). From the left by S it becomes S - dt S F S, whose
//! symmetric part S + dt S D S is positive: elimination needs no pivots then, as all of them are positive
//! (Golub and Van Loan, Matrix Computations, 4.3.1), and nothing in it can fail but overflow.

use super::{LATENTS, LatentOf};
use crate::real::Real;
use nalgebra::SMatrix;

/// A matrix on latent space.
pub(super) type Square = SquareOf<f64>;

/// Matrix on latent space in the precision of a stage.
pub(super) type SquareOf<R> = SMatrix<R, LATENTS, LATENTS>;

/// d of (1 - `dt` F S) d = r; not finite where S is singular or a number overflows.
#[must_use]
pub(super) fn correction<R: Real>(
    stiffness: &SquareOf<R>,
    flow: &SquareOf<R>,
    dt_s: f64,
    residual: &LatentOf<R>,
) -> LatentOf<R> {
    let left = stiffness - stiffness * flow * stiffness * R::of(dt_s);
    eliminate(&left, &(stiffness * residual))
}

/// x of `m` x = `right` by elimination without pivots, for an `m` with a positive symmetric part.
fn eliminate<R: Real>(m: &SquareOf<R>, right: &LatentOf<R>) -> LatentOf<R> {
    // Columns of the transpose are rows.
    let mut rows = m.transpose().data.0;
    let mut right = *right;
    let (mut rest, mut known, mut column) = (&mut rows[..], right.as_mut_slice(), 0);
    while let (Some((first, below)), Some((&mut r, known_below))) =
        (rest.split_first_mut(), known.split_first_mut())
    {
        for (row, known) in below.iter_mut().zip(known_below.iter_mut()) {
            let share = at(row, column) / at(first, column);
            row.iter_mut().zip(first.iter()).skip(column).for_each(|(m, f)| *m -= share * *f);
            *known -= share * r;
        }
        (rest, known, column) = (below, known_below, column + 1);
    }
    let mut x = [R::default(); LATENTS];
    let solved = rows.iter().zip(right.as_slice());
    for (k, (row, r)) in (0..LATENTS).rev().zip(solved.rev()) {
        let found: R = row.iter().zip(x).skip(k + 1).map(|(m, x)| *m * x).sum();
        if let Some(slot) = x.get_mut(k) {
            *slot = (*r - found) / at(row, k);
        }
    }
    LatentOf::from(x)
}

/// Element `k` of a row.
fn at<R: Real>(row: &[R; LATENTS], k: usize) -> R {
    row.get(k).copied().unwrap_or(R::from(f32::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::latent::generic::Latent;

    /// A stiffness, a flow and a residual without structure.
    fn problem() -> (Square, Square, Latent) {
        let number = |i: usize, j: usize| ((i * 7919 + j * 104_729) % 1009) as f64 / 1009.0 - 0.5;
        let root = Square::from_fn(number);
        let (raw, c) =
            (Square::from_fn(|i, j| 40.0 * number(j, 3 * i)), Square::from_fn(|i, j| 2.0 * number(i + 5, j)));
        let flow = raw - raw.transpose() - c * c.transpose();
        (root * root.transpose() + Square::identity() * 0.01, flow, Latent::from_fn(|i, _| number(i, 17)))
    }

    #[test]
    fn the_correction_solves_its_equation() {
        let (stiffness, flow, residual) = problem();
        let d = correction(&stiffness, &flow, 1.0 / 60.0, &residual);
        let again = d - flow * (stiffness * d) / 60.0;
        assert!((again - residual).norm() < 1e-9 * residual.norm(), "{}", (again - residual).norm());
    }
}
