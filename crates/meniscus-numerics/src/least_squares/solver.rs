//! The search from a start to a least cost.

use super::damping::{Damping, NormalEquations};
use nalgebra::{DMatrix, DVector};

/// Residuals whose square is to be least.
pub trait Model {
    /// Returns `r(p)`.
    fn residual(&self, parameters: &DVector<f64>) -> DVector<f64>;

    /// Returns `J_ij = dr_i/dp_j` at `parameters`, where `residual` is `r(p)`.
    fn jacobian(&self, parameters: &DVector<f64>, residual: &DVector<f64>) -> DMatrix<f64>;

    /// Returns the parameters within their bounds that stand for `parameters`; without bounds, these themselves.
    fn within_bounds(&self, parameters: DVector<f64>) -> DVector<f64> {
        parameters
    }
}

/// Gain of an iteration below which the search has converged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stop {
    /// In units of the cost: for whitened residuals, whose cost counts in standard deviations squared.
    Gain(f64),
    /// As a share of the cost.
    GainShare(f64),
}

impl Stop {
    fn converged(self, before: f64, after: f64) -> bool {
        match self {
            Self::Gain(least) => before - after < least,
            Self::GainShare(least) => after > (1.0 - least) * before,
        }
    }
}

/// Settings of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Most iterations, each of which takes one Jacobian.
    pub iterations: usize,
    /// Rule for the damping.
    pub damping: Damping,
    /// When to stop.
    pub stop: Stop,
}

impl Default for Settings {
    fn default() -> Self {
        Self { iterations: 50, damping: Damping::default(), stop: Stop::GainShare(1e-12) }
    }
}

/// Reason for which a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The last iteration gained less than [`Settings::stop`].
    Converged,
    /// No trial step lowered the cost: a minimum to rounding, or a residual that is not a number.
    NoDescent,
    /// [`Settings::iterations`] were made.
    Iterations,
}

/// Result of a search.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The parameters with the least cost found.
    pub parameters: DVector<f64>,
    /// The residual there.
    pub residual: DVector<f64>,
    /// `|r|^2` there.
    pub cost: f64,
    /// The Jacobian there, if the search has needed it: [`End::NoDescent`] has, the others have not.
    pub jacobian: Option<DMatrix<f64>>,
    /// Reason for the end of the search.
    pub end: End,
}

/// Searches the parameters of least `|r(p)|^2` from `start`, which is taken as it is, within its bounds or not.
///
/// ```
/// use meniscus_numerics::least_squares::{Model, Settings, forward_differences, minimise};
/// use nalgebra::{DMatrix, DVector, dvector};
///
/// /// A decay y = a exp(-b t) sampled at t = 0, 1, 2.
/// struct Decay([f64; 3]);
///
/// impl Model for Decay {
///     fn residual(&self, p: &DVector<f64>) -> DVector<f64> {
///         DVector::from_fn(3, |t, _| p[0] * (-p[1] * t as f64).exp() - self.0[t])
///     }
///
///     fn jacobian(&self, p: &DVector<f64>, r: &DVector<f64>) -> DMatrix<f64> {
///         forward_differences(p, r, &dvector![1e-6, 1e-6], |p| self.residual(p))
///     }
/// }
///
/// let found = minimise(&Decay([8.0, 4.0, 2.0]), dvector![1.0, 0.1], &Settings::default());
/// assert!((found.parameters - dvector![8.0, 2.0_f64.ln()]).norm() < 1e-6);
/// ```
#[must_use]
pub fn minimise(model: &impl Model, start: DVector<f64>, settings: &Settings) -> Solution {
    let mut parameters = start;
    let mut residual = model.residual(&parameters);
    let mut cost = residual.norm_squared();
    let mut lambda = settings.damping.first;
    for _ in 0..settings.iterations {
        let jacobian = model.jacobian(&parameters, &residual);
        let (matrix, gradient) = (jacobian.tr_mul(&jacobian), jacobian.tr_mul(&residual));
        let equations = NormalEquations { matrix: &matrix, gradient: &gradient, cost };
        let attempt = |step: &DVector<f64>| {
            let next = model.within_bounds(&parameters - step);
            let tried = model.residual(&next);
            let cost = tried.norm_squared();
            ((next, tried), cost)
        };
        let Some(((next, tried), new)) = settings.damping.step(&mut lambda, equations, attempt) else {
            let jacobian = Some(jacobian);
            return Solution { parameters, residual, cost, jacobian, end: End::NoDescent };
        };
        let converged = settings.stop.converged(cost, new);
        (parameters, residual, cost) = (next, tried, new);
        if converged {
            return Solution { parameters, residual, cost, jacobian: None, end: End::Converged };
        }
    }
    Solution { parameters, residual, cost, jacobian: None, end: End::Iterations }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{dmatrix, dvector};

    /// Rosenbrock's valley as residuals `10 (y - x^2), 1 - x`, with `x` at most `bound`.
    struct Valley {
        bound: f64,
    }

    impl Model for Valley {
        fn residual(&self, p: &DVector<f64>) -> DVector<f64> {
            dvector![10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0]]
        }

        fn jacobian(&self, p: &DVector<f64>, _: &DVector<f64>) -> DMatrix<f64> {
            dmatrix![-20.0 * p[0], 10.0; -1.0, 0.0]
        }

        fn within_bounds(&self, mut p: DVector<f64>) -> DVector<f64> {
            p[0] = p[0].min(self.bound);
            p
        }
    }

    /// A decay `a e^(-b t)` with an offset `c` through points that none passes.
    struct Decay;

    const TIMES: [f64; 6] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
    const SEEN: [f64; 6] = [2.9, 1.6, 1.2, 0.65, 0.62, 0.41];

    impl Model for Decay {
        fn residual(&self, p: &DVector<f64>) -> DVector<f64> {
            let miss = |(t, y): (&f64, &f64)| p[0] * (-p[1] * t).exp() + p[2] - y;
            DVector::from_iterator(6, TIMES.iter().zip(&SEEN).map(miss))
        }

        fn jacobian(&self, p: &DVector<f64>, _: &DVector<f64>) -> DMatrix<f64> {
            DMatrix::from_fn(6, 3, |i, j| {
                let decayed = (-p[1] * TIMES[i]).exp();
                [decayed, -p[0] * TIMES[i] * decayed, 1.0][j]
            })
        }
    }

    #[test]
    fn the_valley_is_followed_to_its_end() {
        let found = minimise(&Valley { bound: 9.0 }, dvector![-1.2, 1.0], &Settings::default());
        assert!((found.parameters - dvector![1.0, 1.0]).norm() < 1e-10, "{:?}", found.end);
        assert!(found.cost < 1e-20);
    }

    #[test]
    fn a_bound_is_not_crossed_and_the_other_parameter_comes_near_its_least() {
        let found = minimise(&Valley { bound: 0.5 }, dvector![-1.2, 1.0], &Settings::default());
        assert_eq!(found.parameters[0], 0.5);
        assert!((found.parameters[1] - 0.25).abs() < 1e-2 && found.cost < 0.26, "{}", found.parameters);
    }

    #[test]
    fn a_fit_with_noise_agrees_with_scipy() {
        // python3 -c "import numpy as n; from scipy.optimize import curve_fit as c; print(c(lambda t, a, b, k:
        // a*n.exp(-b*t)+k, n.arange(6.), [2.9, 1.6, 1.2, .65, .62, .41], [1, 1, 0], ftol=1e-15, xtol=1e-15)[0])"
        let found = minimise(&Decay, dvector![1.0, 1.0, 0.0], &Settings::default());
        let due = dvector![2.529_733_771_813_603, 0.629_790_014_798_491_2, 0.348_359_029_281_192_3];
        assert!((&found.parameters - due).norm() < 1e-6, "{}", found.parameters);
    }

    #[test]
    fn every_end_is_named_and_the_jacobian_is_there_when_it_was_needed() {
        let valley = Valley { bound: 9.0 };
        let start = || dvector![-1.2, 1.0];
        let few = Settings { iterations: 2, ..Settings::default() };
        let found = minimise(&valley, start(), &few);
        assert!(found.end == End::Iterations && found.jacobian.is_none());
        let rough = Settings { stop: Stop::Gain(0.5), ..Settings::default() };
        let found = minimise(&valley, start(), &rough);
        assert!(found.end == End::Converged && found.jacobian.is_none());
        let found = minimise(&valley, dvector![1.0, 1.0], &Settings::default());
        assert!(found.end == End::NoDescent && found.jacobian.is_some_and(|j| j[(0, 0)] == -20.0));
        let found = minimise(&valley, dvector![f64::NAN, 1.0], &Settings::default());
        assert!(found.end == End::NoDescent && found.cost.is_nan());
    }
}
