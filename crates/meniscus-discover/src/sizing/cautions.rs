//! Cautions about a size, and reasons for which an effect cannot be what is missing, in words.

use super::candidate::SizingCandidate;
use super::interval::{Component, SizeVariance};
use super::search::Level;
use meniscus::reduced::effects::Stated;

/// Change of the viscosity, in standard deviations of what was stated, that is said.
const FAR: f64 = 2.0;

/// Factor between the viscosity that fits beside an effect and the stated one from which a second effect is missing: beside
/// right effects it was 1.13 at most, with an interval from 1.06 on (docs/discovery).
const FARTHEST: f64 = 1.12;

/// Returns the sentence of a size at the end of its range.
fn range_end(candidate: &SizingCandidate, level: &Level, stated: &Stated) -> Option<String> {
    let parameter = candidate.parameter(0);
    let si = |value: f64| parameter.to_value(value, stated);
    let (low, high) = parameter.range;
    level.end.map(|end| {
        format!(
            "{} stands at the end of its range of {:.4} to {:.4} {}, at {:.4}",
            parameter.spelling,
            si(low),
            si(high),
            parameter.unit,
            si(end)
        )
    })
}

/// Returns why the effect of `candidate` cannot be what is missing, as `level` found it; none where nothing speaks against it.
///
/// A best size at the end of its range speaks against an effect. So does a viscosity whose whole interval is farther than
/// [`FARTHEST`] from the stated one, if references in the same motion bear the simulator's own error (`is_controlled`).
#[must_use]
pub(super) fn refutation(
    candidate: &SizingCandidate,
    level: &Level,
    stated: &Stated,
    is_controlled: bool,
) -> Option<String> {
    if let Some(end) = range_end(candidate, level, stated) {
        return Some(end);
    }
    let deviation = candidate.viscosity_deviation.filter(|_| is_controlled)?;
    let which = candidate.free.len();
    let (logarithm, variance) = (*level.fit.others.last()?, level.variance.get(which)?);
    let [curvature, packings] = *variance;
    let half = SizeVariance { curvature, packings, spacing: Component::default() }.half_width();
    // Where references do not know the viscosity so well, less is certain.
    let far = FARTHEST.ln().max(FAR * deviation);
    (logarithm.abs() - half > far).then(|| {
        format!(
            "beside {} the viscosity has to be {:.2} times the stated one (90 %: {:.2} to {:.2}), which is known to {:.0} %",
            candidate.parameter(0).spelling,
            logarithm.exp(),
            (logarithm - half).exp(),
            (logarithm + half).exp(),
            100.0 * deviation
        )
    })
}

/// Returns the cautions about the size of `candidate` as `level` found it.
#[must_use]
pub(super) fn of(candidate: &SizingCandidate, level: &Level, half: f64, stated: &Stated) -> Vec<String> {
    let parameter = candidate.parameter(0);
    let neutral = parameter.neutral;
    let si = |value: f64| parameter.to_value(value, stated);
    let name = parameter.spelling;
    let mut out: Vec<String> = range_end(candidate, level, stated).into_iter().collect();
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
