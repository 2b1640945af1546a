//! One damped step, and the rule by which the damping follows success and failure.

use nalgebra::{DMatrix, DVector};

/// Rule for the damping `lambda` of a least-squares search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damping {
    /// Damping at the start of a search.
    pub first: f64,
    /// Divisor after a step that lowers the cost.
    pub shrink: f64,
    /// Factor after a trial that does not.
    pub grow: f64,
    /// Lower bound of the damping.
    pub least: f64,
    /// Upper bound of the damping.
    pub most: f64,
    /// `s`: what is added to each diagonal element before it is scaled by the damping.
    pub scaled_floor: f64,
    /// `f`: what is added to each diagonal element whatever the damping.
    pub floor: f64,
    /// Trials before a step is given up.
    pub trials: usize,
}

impl Default for Damping {
    /// Starts near Gauss-Newton steps, with Marquardt's factor of ten in both directions.
    fn default() -> Self {
        Self {
            first: 1e-3,
            shrink: 10.0,
            grow: 10.0,
            least: 1e-12,
            most: 1e12,
            scaled_floor: 0.0,
            floor: 0.0,
            trials: 10,
        }
    }
}

/// Normal equations of a linearised problem.
#[derive(Clone, Copy, Debug)]
pub struct NormalEquations<'a> {
    /// `A = J^T J`, with weights where there are any.
    pub matrix: &'a DMatrix<f64>,
    /// `g = J^T r`, with the same weights.
    pub gradient: &'a DVector<f64>,
    /// Cost at the parameters at which both were taken.
    pub cost: f64,
}

impl Damping {
    /// Tries steps of rising damping until one lowers the cost, and returns what `attempt` made of that step; `None` when
    /// no trial does.
    ///
    /// `attempt` gets the step `d`, to be subtracted from the parameters, and returns the cost there with whatever the
    /// caller wants to keep of it. `lambda` is left as the next call should find it. A cost that is not a number never
    /// counts as lower, and a matrix that is not positive definite counts as a failed trial.
    ///
    /// ```
    /// use meniscus_numerics::least_squares::{Damping, NormalEquations};
    /// use nalgebra::{dmatrix, dvector};
    ///
    /// // C(p) = (2 p - 6)^2 at p = 0: A = 4, g = 2 * -6.
    /// let (matrix, gradient) = (dmatrix![4.0], dvector![-12.0]);
    /// let equations = NormalEquations { matrix: &matrix, gradient: &gradient, cost: 36.0 };
    /// let mut lambda = 1e-9;
    /// let step = Damping::default().step(&mut lambda, equations, |d| (-d[0], (-2.0 * d[0] - 6.0).powi(2)));
    /// assert!(step.is_some_and(|(p, cost)| (p - 3.0).abs() < 1e-6 && cost < 1e-9));
    /// ```
    pub fn step<T>(
        &self,
        lambda: &mut f64,
        equations: NormalEquations<'_>,
        mut attempt: impl FnMut(&DVector<f64>) -> (T, f64),
    ) -> Option<(T, f64)> {
        let NormalEquations { matrix, gradient, cost } = equations;
        for _ in 0..self.trials {
            let mut damped = matrix.clone();
            for i in 0..damped.nrows() {
                damped[(i, i)] += *lambda * (matrix[(i, i)] + self.scaled_floor) + self.floor;
            }
            if let Some(factor) = damped.cholesky() {
                let (kept, new) = attempt(&factor.solve(gradient));
                if new < cost {
                    *lambda = (*lambda / self.shrink).max(self.least);
                    return Some((kept, new));
                }
            }
            *lambda = (*lambda * self.grow).min(self.most);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{dmatrix, dvector};

    const RULE: Damping = Damping {
        first: 1.0,
        shrink: 4.0,
        grow: 2.0,
        least: 0.3,
        most: 16.0,
        scaled_floor: 0.0,
        floor: 0.0,
        trials: 3,
    };

    #[test]
    fn the_step_solves_the_damped_equations() {
        // python3 -c "import numpy as n; A = n.array([[4., 1], [1, 3]]); print(n.linalg.solve(A + n.diag([2., 1.5]), [1, 2]))"
        let (matrix, gradient) = (dmatrix![4.0, 1.0; 1.0, 3.0], dvector![1.0, 2.0]);
        let equations = NormalEquations { matrix: &matrix, gradient: &gradient, cost: 1.0 };
        let step = RULE.step(&mut 0.5, equations, |d| (d.clone(), 0.0)).expect("the cost is lower").0;
        assert!((step - dvector![0.096_153_846_153_846_15, 0.423_076_923_076_923_1]).norm() < 1e-15);
    }

    #[test]
    fn damping_falls_after_success_and_rises_after_failure_within_its_bounds() {
        let (matrix, gradient) = (dmatrix![1.0], dvector![1.0]);
        let equations = NormalEquations { matrix: &matrix, gradient: &gradient, cost: 1.0 };
        let mut lambda = 1.0;
        assert!(RULE.step(&mut lambda, equations, |_| ((), 2.0)).is_none());
        assert_eq!(lambda, 8.0);
        assert!(RULE.step(&mut lambda, equations, |_| ((), f64::NAN)).is_none());
        assert_eq!(lambda, 16.0);
        for due in [4.0, 1.0, 0.3, 0.3] {
            assert!(RULE.step(&mut lambda, equations, |_| ((), 0.5)).is_some());
            assert_eq!(lambda, due);
        }
    }

    #[test]
    fn a_matrix_that_is_not_definite_is_a_failed_trial_until_its_floor_mends_it() {
        let (matrix, gradient) = (dmatrix![1.0, 0.0; 0.0, 0.0], dvector![1.0, 0.0]);
        let equations = NormalEquations { matrix: &matrix, gradient: &gradient, cost: 1.0 };
        assert!(RULE.step(&mut 1.0, equations, |_| ((), 0.0)).is_none());
        let mended = Damping { scaled_floor: 1e-9, ..RULE };
        assert!(mended.step(&mut 1.0, equations, |_| ((), 0.0)).is_some());
        let mended = Damping { floor: 1e-9, ..RULE };
        assert!(mended.step(&mut 0.0, equations, |_| ((), 0.0)).is_some());
    }
}
