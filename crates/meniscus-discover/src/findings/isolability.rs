//! Isolability of the effects: the signatures that these recordings could distinguish.

use crate::fitting::fit::{Fitted, derivatives, free_of};
use crate::fitting::problem::Problem;
use meniscus::reduced::effects::{Active, Entry};
use nalgebra::DVector;
use rayon::prelude::*;

/// Signatures of effects on these recordings: what they could distinguish.
#[derive(Clone, Debug, PartialEq)]
pub struct Isolability {
    /// Names of the effects.
    pub names: Vec<&'static str>,
    /// Length of each signature, signal over noise.
    pub lengths: Vec<f64>,
    /// Cosines between the signatures.
    pub cosines: Vec<Vec<f64>>,
}

/// Returns the signatures of the effects of `library` at their typical size, without the part that the baseline can
/// reproduce.
#[must_use]
pub fn isolability(problem: &Problem, plain: &Fitted, library: &[&'static Entry]) -> Isolability {
    let jacobian = derivatives(problem, &plain.theta, &[], &[], &plain.residual, Some(&plain.jacobian));
    let basis = jacobian.qr().q();
    let signatures: Vec<DVector<f64>> = library
        .par_iter()
        .map(|entry| {
            let mut values = entry.neutral();
            let which = free_of(problem, entry)[0];
            let parameter = &entry.parameters[which];
            let up = parameter.neutral + parameter.typical;
            values[which] = if up <= parameter.range.1 { up } else { parameter.neutral - parameter.typical };
            let change = problem.residual(&plain.theta, &[Active { entry, values }]) - &plain.residual;
            let part = basis.tr_mul(&change);
            change - &basis * part
        })
        .collect();
    let lengths: Vec<f64> = signatures.iter().map(|s| s.norm()).collect();
    let cosine = |a: &DVector<f64>, b: &DVector<f64>| a.dot(b) / (a.norm() * b.norm()).max(1e-12);
    let cosines = signatures.iter().map(|a| signatures.iter().map(|b| cosine(a, b)).collect()).collect();
    let names = library.iter().map(|entry| entry.name).collect();
    Isolability { names, lengths, cosines }
}
