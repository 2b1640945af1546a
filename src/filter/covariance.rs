//! Error covariance of the filter, propagated by a step and updated by one scalar measurement at a time.
//!
//! ```text
//! step          P-  = G P G^T + Q
//! measurement   z = c.y + e, <e^2> = r:    s = c.P c + r,    y += P c (z - c.y) / s,    P -= P c (P c)^T / s
//! ```
//! (Kalman, J. Basic Eng. 82 (1960) 35; measurements with independent errors may be processed one by one.) An innovation
//! beyond its gate, |z - c.y| > b sqrt(s), counts less: s grows to (z - c.y)^2 / b^2, so that it moves the estimate by no
//! more than b standard deviations would (bounded influence: Huber, Ann. Math. Stat. 35 (1964) 73).

use super::state::{STATES, StateIndex, StateMatrix, StateVector};
use crate::real::Real;

/// Covariance P of the state's error.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ErrorCovariance(StateMatrix);

/// One scalar measurement, compared with its prediction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measurement<R> {
    /// Innovation z - c.y.
    pub(super) innovation: R,
    /// Variance r of the measurement's own error.
    pub(super) noise: R,
    /// Gate b, in standard deviations of the innovation.
    pub(super) gate: R,
}

/// Result of an update.
#[derive(Clone, Copy, Debug)]
pub(super) struct Correction<R> {
    /// Change of the state.
    pub(super) moved: StateVector<R>,
    /// Innovation squared over its expectation, at most the gate squared; its mean is one where P and r are right.
    pub(super) normalised_innovation: R,
}

impl ErrorCovariance {
    /// Wraps a symmetric matrix.
    pub(super) fn new(p: StateMatrix) -> Self {
        Self(p)
    }

    /// P at row `i` and column `j`.
    pub(super) fn at(&self, i: usize, j: usize) -> f64 {
        self.0.get((i, j)).copied().unwrap_or(0.0)
    }

    /// P between two named numbers.
    pub(super) fn between(&self, i: StateIndex, j: StateIndex) -> f64 {
        self.at(i.index(), j.index())
    }

    /// Lends P to `work` in the precision `R`, and keeps what that leaves in it.
    pub(super) fn lend<R: Real, T>(&mut self, work: impl FnOnce(LentCovariance<'_, R>) -> T) -> T {
        R::lend(&mut self.0, |p| work(LentCovariance(p)))
    }

    /// Sets the variance of one number and makes its error independent of all others.
    pub(super) fn set_variance(&mut self, of: StateIndex, variance: f64) {
        let index = of.index();
        for other in 0..STATES {
            for entry in [(index, other), (other, index)] {
                if let Some(p) = self.0.get_mut(entry) {
                    *p = if index == other { variance } else { 0.0 };
                }
            }
        }
    }

    /// Whether all entries are finite.
    pub(super) fn is_finite(&self) -> bool {
        self.0.iter().all(|v| v.is_finite())
    }
}

/// P in the precision of a stage.
pub(super) struct LentCovariance<'p, R>(&'p mut StateMatrix<R>);

impl<R: Real> LentCovariance<'_, R> {
    /// Propagates P by a step with G^T `transposed` and Q `noise`.
    pub(super) fn step(&mut self, transposed: &StateMatrix<R>, noise: impl Fn(usize, usize) -> f64) {
        let half = *self.0 * transposed;
        transposed.tr_mul_to(&half, self.0);
        let (mean, p) = (R::from(0.5), &*self.0);
        let at = |i: usize, j: usize| p.get((i, j)).copied().unwrap_or_default();
        // Without the mean with the transpose, rounding would add up to an asymmetric P over the turns.
        let next = StateMatrix::from_fn(|i, j| mean * (at(i, j) + at(j, i)) + R::of(noise(i, j)));
        *self.0 = next;
    }

    /// Updates P by a measurement with slopes `c`.
    pub(super) fn update(&mut self, c: &StateVector<R>, measurement: Measurement<R>) -> Correction<R> {
        let Measurement { innovation, noise, gate } = measurement;
        let mut moved = *self.0 * c;
        // Rounding or a hostile blob may have made c.P c negative: such a direction counts as exactly known.
        let expected = c.dot(&moved).larger(R::default()) + noise;
        let normalised_innovation = (innovation * innovation / expected).smaller(gate * gate);
        let s = expected.larger(innovation * innovation / (gate * gate));
        self.0.ger(-R::from(1.0) / s, &moved, &moved, R::from(1.0));
        moved *= innovation / s;
        Correction { moved, normalised_innovation }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{pow, sincos};
    use nalgebra::SymmetricEigen;

    const GATE: f64 = 5.0;

    fn update(
        covariance: &mut ErrorCovariance,
        c: &StateVector,
        measurement: Measurement<f64>,
    ) -> Correction<f64> {
        covariance.lend(|mut p| p.update(c, measurement))
    }

    fn unit(index: usize) -> StateVector {
        StateVector::from_fn(|i, _| f64::from(u8::from(i == index)))
    }

    /// The scalar filter x' = a x + w, z = x + e settles at p- = a^2 p- r / (p- + r) + q.
    #[test]
    fn variance_settles_where_theory_says() {
        let (a, q, r) = (0.9, 0.02, 0.3);
        let mut covariance = ErrorCovariance::new(StateMatrix::identity());
        for _ in 0..200 {
            covariance.lend(|mut p: LentCovariance<'_, f64>| {
                p.step(&(StateMatrix::identity() * a), |i, j| if i == j { q } else { 0.0 });
            });
            for index in 0..STATES {
                update(&mut covariance, &unit(index), Measurement { innovation: 0.0, noise: r, gate: GATE });
            }
        }
        let before = a * a * covariance.at(3, 3) + q;
        let due = a * a * before * r / (before + r) + q;
        assert!((before / due - 1.0).abs() < 1e-12, "{before} against {due}");
        assert_eq!(covariance.at(3, 4), 0.0);
    }

    /// Scalar updates one by one equal the joint update P+ = (P^-1 + C^T R^-1 C)^-1.
    #[test]
    fn one_by_one_is_all_at_once() {
        let p = StateMatrix::from_fn(|i, j| pow(0.8, i.abs_diff(j) as f64));
        let rows = [0.3, 1.7, -0.4].map(|t: f64| StateVector::from_fn(|i, _| sincos(t * i as f64).1));
        let (noise, mut covariance) = (0.1, ErrorCovariance::new(p));
        let mut information = p.try_inverse().expect("positive");
        let (mut moved, mut right) = (StateVector::zeros(), StateVector::zeros());
        for (k, c) in rows.iter().enumerate() {
            let z = 0.2 * (k as f64 + 1.0);
            let innovation = z - c.dot(&moved);
            moved += update(&mut covariance, c, Measurement { innovation, noise, gate: GATE }).moved;
            information += c * c.transpose() / noise;
            right += c * (z / noise);
        }
        let due = information.try_inverse().expect("positive");
        assert!((covariance.0 - due).norm() < 1e-9);
        assert!((moved - due * right).norm() < 1e-9);
        assert!(SymmetricEigen::new(covariance.0).eigenvalues.min() > 0.0);
    }

    #[test]
    fn an_innovation_beyond_the_gate_moves_little() {
        let mut covariance = ErrorCovariance::new(StateMatrix::identity());
        let measured = |innovation: f64| Measurement { innovation, noise: 1.0, gate: GATE };
        let fair = update(&mut covariance.clone(), &unit(0), measured(2.0));
        assert!((fair.moved[0] - 1.0).abs() < 1e-12 && (fair.normalised_innovation - 2.0).abs() < 1e-12);
        let far = update(&mut covariance, &unit(0), measured(1e6));
        assert!(far.moved[0] < 1e-4 && far.normalised_innovation == GATE * GATE);
        assert!(covariance.at(0, 0) > 0.999, "and tells little");
    }
}
