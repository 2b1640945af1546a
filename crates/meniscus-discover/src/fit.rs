//! Fits: the baseline's numbers and an effect's parameters, by damped Gauss-Newton on whitened residuals.

use super::problem::Problem;
use crate::fit_cache::CacheKey;
use meniscus::reduced::effects::{Active, Entry, PARAMETERS, Parameter};
use nalgebra::{DMatrix, DVector};

/// Most repetitions of a fit.
const REPEATS: usize = 12;

/// A fit ends when the cost falls by less.
const ENOUGH: f64 = 0.02;

/// One parameter that is free: of which effect, and which.
pub type Free = (usize, usize);

/// A fitted model.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The baseline's numbers and the lags.
    pub theta: Vec<f64>,
    /// The effects with their values.
    pub active: Vec<Active>,
    /// Which parameters were free.
    pub free: Vec<Free>,
    /// `|whitened residual|^2` with the prior's part.
    pub cost: f64,
    /// The residual.
    pub residual: DVector<f64>,
    /// Its derivatives by theta, then by the free parameters.
    pub jacobian: DMatrix<f64>,
}

impl Fitted {
    /// Schwarz's criterion with a penalty for each free parameter of an effect, `cost + p ln n`.
    #[must_use]
    pub fn bic(&self, count: usize) -> f64 {
        self.cost + self.free.len() as f64 * (count as f64).ln()
    }

    /// Whitened misfit of the data alone for each number.
    #[must_use]
    pub fn chi2(&self, count: usize) -> f64 {
        self.residual.rows(0, count).norm_squared() / count as f64
    }

    /// Covariance of theta and the free parameters, where it exists.
    #[must_use]
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        (self.jacobian.transpose() * &self.jacobian).try_inverse()
    }
}

/// The free parameters of `entry` for these recordings: a contact line's reach is a property of the wall
/// and stays, the recorded inclination or lift is taken where there is one that does not enter the model yet.
#[must_use]
pub fn free_of(problem: &Problem, entry: &'static Entry) -> Vec<usize> {
    let holds = |which: usize| {
        problem.known.motion_share[which] < 1.0 && problem.records().any(|record| record.drive.holds()[which])
    };
    match entry.name {
        "container_tilt" => vec![usize::from(holds(0))],
        "vertical_acceleration" => vec![usize::from(holds(1))],
        "contact_line" => vec![0],
        _ => (0..entry.parameters.len()).collect(),
    }
}

/// Fits theta, from `start`, and the parameters `free` of `active`, from their values; what was fitted in the
/// same way before is taken from where the problem keeps its fits.
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

/// Damped Gauss-Newton from `start`.
fn descend(problem: &Problem, start: &[f64], active: &[Active], free: &[Free]) -> Fitted {
    let mut theta = start.to_vec();
    let mut active = active.to_vec();
    let mut residual = problem.residual(&theta, &active);
    let mut jacobian = derivatives(problem, &theta, &active, free, &residual, None);
    let mut damping = 1e-3;
    for _ in 0..REPEATS {
        let square = jacobian.transpose() * &jacobian;
        let slope = jacobian.transpose() * &residual;
        let cost = residual.norm_squared();
        let mut gained = 0.0;
        for _ in 0..5 {
            let mut damped = square.clone();
            for i in 0..damped.nrows() {
                damped[(i, i)] *= 1.0 + damping;
                damped[(i, i)] += 1e-12;
            }
            let Some(step) = damped.cholesky().map(|factor| factor.solve(&slope)) else { break };
            let (t, a) = moved(&theta, &active, free, &step);
            let tried = problem.residual(&t, &a);
            let new = tried.norm_squared();
            if new < cost {
                (theta, active, residual, gained) = (t, a, tried, cost - new);
                damping = (0.2 * damping).max(1e-9);
                break;
            }
            damping *= 10.0;
        }
        if gained == 0.0 {
            break;
        }
        jacobian = derivatives(problem, &theta, &active, free, &residual, None);
        if gained < ENOUGH {
            break;
        }
    }
    Fitted { cost: residual.norm_squared(), theta, active, free: free.to_vec(), residual, jacobian }
}

/// Theta and effects after a step down the slope, inside every range.
fn moved(theta: &[f64], active: &[Active], free: &[Free], step: &DVector<f64>) -> (Vec<f64>, Vec<Active>) {
    let theta: Vec<f64> = theta.iter().zip(step.iter()).map(|(t, s)| t - s).collect();
    let mut active = active.to_vec();
    for (i, (effect, which)) in free.iter().enumerate() {
        let (least, largest) = active[*effect].entry.parameters[*which].range;
        let value = &mut active[*effect].values[*which];
        *value = (*value - step[theta.len() + i]).clamp(least, largest);
    }
    (theta, active)
}

/// Derivatives of the residual by differences; `only_theta` leaves out the effects.
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
        if value + h > parameter.range.1 {
            h = -h;
        }
        let mut shifted = active.to_vec();
        shifted[*effect].values[*which] += h;
        jacobian.set_column(theta.len() + i, &((problem.residual(theta, &shifted) - residual) / h));
    }
    jacobian
}

/// Values of a parameter to start from: on either side of the neutral one, from small to large.
fn ladder(parameter: &Parameter) -> Vec<f64> {
    let mut out = Vec::new();
    for size in [0.2, 0.6, 1.5, 4.0] {
        for sign in [1.0, -1.0] {
            let value = parameter.neutral + sign * size * parameter.typical;
            if (parameter.range.0..=parameter.range.1).contains(&value) {
                out.push(value);
            }
        }
    }
    out
}

/// The best of a coarse search over an effect's parameters beside those of `base`, with theta free but
/// only to first order: `|r|^2 - |Q^T r|^2` with the basis Q of what theta can do.
#[must_use]
pub fn search(problem: &Problem, base: &Fitted, entry: &'static Entry) -> (f64, Active, DVector<f64>) {
    let free = free_of(problem, entry);
    let basis = base.jacobian.clone().qr().q();
    let left = |values: [f64; PARAMETERS]| {
        let mut active = base.active.clone();
        active.push(Active { entry, values });
        let residual = problem.residual(&base.theta, &active);
        let part = basis.tr_mul(&residual);
        let rest = &residual - &basis * part;
        (rest.norm_squared(), rest)
    };
    let mut best = (f64::INFINITY, entry.neutral(), DVector::zeros(0));
    let mut try_it = |values: [f64; PARAMETERS]| {
        let (cost, rest) = left(values);
        if cost < best.0 {
            best = (cost, values, rest);
        }
    };
    for first in ladder(&entry.parameters[free[0]]) {
        let mut values = entry.neutral();
        values[free[0]] = first;
        match free.get(1).map(|second| &entry.parameters[*second]) {
            None => try_it(values),
            Some(second) => {
                for other in [0.3, 1.0, 3.0] {
                    values[free[1]] = (second.neutral * other).clamp(second.range.0, second.range.1);
                    try_it(values);
                }
            }
        }
    }
    (best.0, Active { entry, values: best.1 }, best.2)
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
