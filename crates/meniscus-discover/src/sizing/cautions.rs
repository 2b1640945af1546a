//! Cautions about a size, in words.

use super::candidate::SizingCandidate;
use super::search::Level;
use meniscus::reduced::effects::Stated;

/// Change of the viscosity, in standard deviations of what was stated, that is said.
const FAR: f64 = 2.0;

/// Returns the cautions about the size of `candidate` as `level` found it.
#[must_use]
pub(super) fn of(candidate: &SizingCandidate, level: &Level, half: f64, stated: &Stated) -> Vec<String> {
    let parameter = candidate.parameter(0);
    let neutral = parameter.neutral;
    let si = |value: f64| parameter.to_value(value, stated);
    let name = parameter.spelling;
    let mut out = Vec::new();
    if let Some(end) = level.end {
        let (low, high) = parameter.range;
        let end = si(end);
        out.push(format!(
            "{name} stands at the end of its range of {:.4} to {:.4} {}, at {end:.4}",
            si(low),
            si(high),
            parameter.unit
        ));
    }
    if !half.is_finite() {
        out.push(format!("{name} changes nothing in the simulator, so that it has no size"));
    } else if (level.fit.size - neutral).abs() <= half {
        out.push(format!("the interval of {name} holds the absent effect"));
    }
    if !level.stable {
        out.push(format!("{name} was still moving after {} sizes", level.sizes.len()));
    }
    for failure in &level.failures {
        let (size, unit) = (si(failure.size), parameter.unit);
        out.push(format!("the simulator failed at {size:.4} {unit}: {}", failure.reason));
    }
    if let (Some(deviation), Some(logarithm)) = (candidate.viscosity_deviation, level.fit.others.last())
        && logarithm.abs() > FAR * deviation
    {
        out.push(format!(
            "beside {name} the viscosity has to be {:.2} times the stated one, far from the {:.0} % to which it is known",
            logarithm.exp(),
            100.0 * deviation
        ));
    }
    out
}
