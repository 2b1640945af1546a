//! Fits of the baseline's numbers and of an effect's parameters, by damped Gauss-Newton steps on whitened residuals
//! ([`meniscus_numerics::least_squares`]).

use super::fit_cache::CacheKey;
use super::problem::Problem;
use meniscus::reduced::effects::{Active, Entry, FreeParameters, Recorded};
use meniscus_numerics::least_squares::{Damping, Model, Settings, Stop, minimise};
use nalgebra::{DMatrix, DVector};

/// The search of a fit. Residuals are whitened, so that a gain of 0.02 moves no parameter by more than a seventh of its
/// standard deviation; `floor` is for an effect that does nothing at its present value.
const SEARCH: Settings = Settings {
    iterations: 12,
    stop: Stop::Gain(0.02),
    damping: Damping {
        first: 1e-3,
        shrink: 5.0,
        grow: 10.0,
        least: 1e-9,
        most: f64::INFINITY,
        scaled_floor: 0.0,
        floor: 1e-12,
        trials: 5,
    },
};

/// Index of an effect and of one of its parameters, which is free.
pub type Free = (usize, usize);

/// A fitted model.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The baseline's numbers and the lags.
    pub theta: Vec<f64>,
    /// The effects with their values.
    pub active: Vec<Active>,
    /// Parameters that were free.
    pub free: Vec<Free>,
    /// Squared norm of the whitened residual with the prior's part.
    pub cost: f64,
    /// The residual.
    pub residual: DVector<f64>,
    /// Its derivatives by theta, then by the free parameters.
    pub jacobian: DMatrix<f64>,
}

impl Fitted {
    /// Returns Schwarz's criterion with a penalty for each free parameter of an effect, `cost + p ln n`.
    #[must_use]
    pub fn bic(&self, count: usize) -> f64 {
        self.cost + self.free.len() as f64 * (count as f64).ln()
    }

    /// Returns the whitened misfit of the data alone for each number.
    #[must_use]
    pub fn chi2(&self, count: usize) -> f64 {
        self.residual.rows(0, count).norm_squared() / count as f64
    }

    /// Returns the covariance of theta and the free parameters, where it exists.
    #[must_use]
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        (self.jacobian.transpose() * &self.jacobian).try_inverse()
    }
}

/// Returns the free parameters of `entry` for these recordings: a contact line's reach is a property of the wall
/// and stays, the recorded inclination or lift is taken where there is one that does not enter the model yet.
#[must_use]
pub fn free_of(problem: &Problem, entry: &'static Entry) -> Vec<usize> {
    let holds = |which: usize| {
        problem.known.motion_share[which] < 1.0 && problem.records().any(|record| record.drive.holds()[which])
    };
    match entry.free {
        FreeParameters::All => (0..entry.parameters.len()).collect(),
        FreeParameters::First => vec![0],
        FreeParameters::FirstOrRecorded(Recorded::Inclination) => vec![usize::from(holds(0))],
        FreeParameters::FirstOrRecorded(Recorded::Lift) => vec![usize::from(holds(1))],
    }
}

/// Fits theta, from `start`, and the parameters `free` of `active`, from their values; a fit with the
/// same inputs is taken from the cache of the problem.
#[must_use]
pub fn fit(problem: &Problem, start: &[f64], active: &[Active], free: &[Free]) -> Fitted {
    let Some((cache, mine)) = problem.cache() else { return descend(problem, start, active, free) };
    let mut key = CacheKey::new();
    key.add_word(&format!("{mine:x} {free:?}"));
    key.add(start);
    for effect in active {
        key.add_word(effect.entry.name);
        key.add(effect.values);
    }
    let key = key.finish();
    if let Some(found) = cache.get(key, start.len() + free.len()) {
        let (theta, values) = found.split_at(start.len());
        let mut active = active.to_vec();
        for ((effect, which), value) in free.iter().zip(values) {
            active[*effect].values[*which] = *value;
        }
        let residual = problem.residual(theta, &active);
        let jacobian = derivatives(problem, theta, &active, free, &residual, None);
        let cost = residual.norm_squared();
        return Fitted { theta: theta.to_vec(), active, free: free.to_vec(), cost, residual, jacobian };
    }
    let fitted = descend(problem, start, active, free);
    let values = free.iter().map(|(effect, which)| fitted.active[*effect].values[*which]);
    cache.put(key, &fitted.theta.iter().copied().chain(values).collect::<Vec<_>>());
    fitted
}

/// A problem as a function of theta, followed by the free parameters of the effects.
struct Unknowns<'a> {
    problem: &'a Problem,
    active: &'a [Active],
    free: &'a [Free],
    /// Numbers in theta.
    thetas: usize,
}

impl Unknowns<'_> {
    fn point(&self, theta: &[f64]) -> DVector<f64> {
        let values = self.free.iter().map(|(effect, which)| self.active[*effect].values[*which]);
        DVector::from_iterator(theta.len() + self.free.len(), theta.iter().copied().chain(values))
    }

    fn parts(&self, point: &DVector<f64>) -> (Vec<f64>, Vec<Active>) {
        let (theta, values) = point.as_slice().split_at(self.thetas);
        let mut active = self.active.to_vec();
        for ((effect, which), value) in self.free.iter().zip(values) {
            active[*effect].values[*which] = *value;
        }
        (theta.to_vec(), active)
    }
}

impl Model for Unknowns<'_> {
    fn residual(&self, point: &DVector<f64>) -> DVector<f64> {
        let (theta, active) = self.parts(point);
        self.problem.residual(&theta, &active)
    }

    fn jacobian(&self, point: &DVector<f64>, residual: &DVector<f64>) -> DMatrix<f64> {
        let (theta, active) = self.parts(point);
        derivatives(self.problem, &theta, &active, self.free, residual, None)
    }

    /// An effect's parameter stays in its range; theta has none, its prior holds it.
    fn within_bounds(&self, mut point: DVector<f64>) -> DVector<f64> {
        for ((effect, which), value) in self.free.iter().zip(point.iter_mut().skip(self.thetas)) {
            let (least, largest) = self.active[*effect].entry.parameters[*which].range;
            *value = value.clamp(least, largest);
        }
        point
    }
}

/// Least squares from `start`.
fn descend(problem: &Problem, start: &[f64], active: &[Active], free: &[Free]) -> Fitted {
    let unknowns = Unknowns { problem, active, free, thetas: start.len() };
    let found = minimise(&unknowns, unknowns.point(start), &SEARCH);
    let jacobian = found.jacobian.unwrap_or_else(|| unknowns.jacobian(&found.parameters, &found.residual));
    let (theta, active) = unknowns.parts(&found.parameters);
    Fitted { theta, active, free: free.to_vec(), cost: found.cost, residual: found.residual, jacobian }
}

/// Returns the derivatives of the residual by theta and the free parameters, by differences; those by theta are taken from `reuse`
/// where it is given.
#[must_use]
pub fn derivatives(
    problem: &Problem,
    theta: &[f64],
    active: &[Active],
    free: &[Free],
    residual: &DVector<f64>,
    reuse: Option<&DMatrix<f64>>,
) -> DMatrix<f64> {
    let mut jacobian = DMatrix::zeros(residual.len(), theta.len() + free.len());
    for i in 0..theta.len() {
        if let Some(known) = reuse {
            jacobian.set_column(i, &known.column(i));
            continue;
        }
        let h = 0.05 * problem.deviation[i];
        let mut shifted = theta.to_vec();
        shifted[i] += h;
        jacobian.set_column(i, &((problem.residual(&shifted, active) - residual) / h));
    }
    for (i, (effect, which)) in free.iter().enumerate() {
        let parameter = &active[*effect].entry.parameters[*which];
        let value = active[*effect].values[*which];
        let mut h = 0.02 * parameter.typical;
        // Beyond its range an effect need not have a meaning.
        if value + h > parameter.range.1 {
            h = -h;
        }
        let mut shifted = active.to_vec();
        shifted[*effect].values[*which] += h;
        jacobian.set_column(theta.len() + i, &((problem.residual(theta, &shifted) - residual) / h));
    }
    jacobian
}

/// Fits `entry` beside the effects of `base`, from its values in `from`.
#[must_use]
pub fn fit_beside(problem: &Problem, base: &Fitted, entry: &'static Entry, from: &Active) -> Fitted {
    let place = base.active.len();
    let mut free = base.free.clone();
    free.extend(free_of(problem, entry).into_iter().map(|which| (place, which)));
    let mut all = base.active.clone();
    all.push(*from);
    fit(problem, &base.theta, &all, &free)
}
