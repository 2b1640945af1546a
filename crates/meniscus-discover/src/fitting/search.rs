//! Coarse search over the parameters of an effect, with the baseline free to first order.

use super::fit::{Fitted, free_of};
use super::problem::Problem;
use meniscus::reduced::effects::{Active, Entry, PARAMETERS, Parameter};
use nalgebra::DVector;

/// Returns the values of a parameter to start from: on either side of the neutral one, from small to large.
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

/// Returns the best of a coarse search over an effect's parameters beside those of `base`, with theta free but
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
