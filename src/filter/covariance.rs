//! The covariance of a filter's error, and what a step and a measurement of one number do to it.
//!
//! ```text
//! step          P-  = G P G^T + Q
//! measurement   z = c.y + e, <e^2> = r:    s = c.P c + r,    y += P c (z - c.y) / s,    P -= P c (P c)^T / s
//! ```
//! (Kalman, J. Basic Eng. 82 (1960) 35; numbers with independent errors may be taken one by one.) A number further from
//! what was foretold than its bound, |z - c.y| > b sqrt(s), is worth less: s grows to (z - c.y)^2 / b^2, so that it moves
//! the estimate by no more than b deviations would (the bounded influence of Huber, Ann. Math. Stat. 35 (1964) 73).

use crate::latent::generic::LATENTS;
use nalgebra::{SMatrix, SVector};

/// Numbers of the filter: latents, the port value of the last three instants, speed and place of the glass, the
/// slosh across its line now and the instant before.
pub(super) const ALL: usize = LATENTS + 7;

pub(super) type Wide = SMatrix<f64, ALL, ALL>;
pub(super) type Column = SVector<f64, ALL>;

/// P.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Belief(Wide);

/// What a measurement says.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measured {
    /// z - c.y.
    pub(super) miss: f64,
    /// r.
    pub(super) noise: f64,
    /// b.
    pub(super) bound: f64,
}

impl Belief {
    pub(super) fn new(p: Wide) -> Self {
        Self(p)
    }

    /// P at (`i`, `j`).
    pub(super) fn at(&self, i: usize, j: usize) -> f64 {
        self.0.get((i, j)).copied().unwrap_or(0.0)
    }

    /// A step with G^T `transposed` and Q `noise`.
    pub(super) fn step(&mut self, transposed: &Wide, noise: impl Fn(usize, usize) -> f64) {
        let half = self.0 * transposed;
        transposed.tr_mul_to(&half, &mut self.0);
        // What rounding makes of the symmetry does not add up over the turns.
        let next = Wide::from_fn(|i, j| 0.5 * (self.at(i, j) + self.at(j, i)) + noise(i, j));
        self.0 = next;
    }

    /// Takes a measurement along `c`. Gives the change of y, and (z - c.y)^2 over its expectation, at most b^2.
    pub(super) fn take(&mut self, c: &Column, measured: Measured) -> (Column, f64) {
        let Measured { miss, noise, bound } = measured;
        let mut along = self.0 * c;
        // What rounding or a hostile blob has made negative tells nothing.
        let expected = c.dot(&along).max(0.0) + noise;
        let surprise = (miss * miss / expected).min(bound * bound);
        let s = expected.max(miss * miss / (bound * bound));
        self.0.ger(-1.0 / s, &along, &along, 1.0);
        along *= miss / s;
        (along, surprise)
    }

    /// Number `index` is known to `variance`, independently of all others.
    pub(super) fn set(&mut self, index: usize, variance: f64) {
        for other in 0..ALL {
            for place in [(index, other), (other, index)] {
                if let Some(p) = self.0.get_mut(place) {
                    *p = if index == other { variance } else { 0.0 };
                }
            }
        }
    }

    /// Whether every number is one.
    pub(super) fn is_finite(&self) -> bool {
        self.0.iter().all(|v| v.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{pow, sincos};
    use nalgebra::SymmetricEigen;

    const FAIR: f64 = 5.0;

    fn along(index: usize) -> Column {
        Column::from_fn(|i, _| f64::from(u8::from(i == index)))
    }

    /// The scalar filter x' = a x + w, z = x + e settles at p- = a^2 p- r / (p- + r) + q.
    #[test]
    fn variance_settles_where_theory_says() {
        let (a, q, r) = (0.9, 0.02, 0.3);
        let mut belief = Belief::new(Wide::identity());
        for _ in 0..200 {
            belief.step(&(Wide::identity() * a), |i, j| if i == j { q } else { 0.0 });
            for index in 0..ALL {
                belief.take(&along(index), Measured { miss: 0.0, noise: r, bound: FAIR });
            }
        }
        let before = a * a * belief.at(3, 3) + q;
        let due = a * a * before * r / (before + r) + q;
        assert!((before / due - 1.0).abs() < 1e-12, "{before} against {due}");
        assert_eq!(belief.at(3, 4), 0.0);
    }

    /// Numbers one by one come to the same as all at once: P+ = (P^-1 + C^T R^-1 C)^-1.
    #[test]
    fn one_by_one_is_all_at_once() {
        let p = Wide::from_fn(|i, j| pow(0.8, i.abs_diff(j) as f64));
        let rows = [0.3, 1.7, -0.4].map(|t: f64| Column::from_fn(|i, _| sincos(t * i as f64).1));
        let (noise, mut belief) = (0.1, Belief::new(p));
        let mut information = p.try_inverse().expect("positive");
        let (mut moved, mut right) = (Column::zeros(), Column::zeros());
        for (k, c) in rows.iter().enumerate() {
            let z = 0.2 * (k as f64 + 1.0);
            moved += belief.take(c, Measured { miss: z - c.dot(&moved), noise, bound: FAIR }).0;
            information += c * c.transpose() / noise;
            right += c * (z / noise);
        }
        let due = information.try_inverse().expect("positive");
        assert!((belief.0 - due).norm() < 1e-9);
        assert!((moved - due * right).norm() < 1e-9);
        assert!(SymmetricEigen::new(belief.0).eigenvalues.min() > 0.0);
    }

    #[test]
    fn what_is_far_off_moves_little() {
        let mut belief = Belief::new(Wide::identity());
        let (fair, surprise) =
            belief.clone().take(&along(0), Measured { miss: 2.0, noise: 1.0, bound: FAIR });
        assert!((fair[0] - 1.0).abs() < 1e-12 && (surprise - 2.0).abs() < 1e-12);
        let (far, surprise) = belief.take(&along(0), Measured { miss: 1e6, noise: 1.0, bound: FAIR });
        assert!(far[0] < 1e-4 && surprise == FAIR * FAIR);
        assert!(belief.at(0, 0) > 0.999, "and tells little");
    }
}
