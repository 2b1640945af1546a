//! Findings of a discovery: verdict, evidence, parameters, gap and suggested recording.

pub mod gap;
pub mod isolability;
pub mod size_error;
pub mod suggest;

use self::gap::MeasuredGap;
use self::isolability::Isolability;
use self::size_error::SizeError;
use self::suggest::Suggestion;
use crate::baseline::calibrate::Calibration;
use crate::decision::assessment::Assessment;
use crate::decision::rank::Candidate;
use crate::decision::rules::DecisionRules;
use crate::decision::thresholds::Thresholds;
use crate::decision::verdict::Verdict;
use crate::fitting::fit::Fitted;
use crate::fitting::localise::Cell;
use crate::recordings::split::Split;
use crate::recordings::stated::Known;
use meniscus::reduced::effects::Stated;

/// Parameter of an effect with its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Effect.
    pub effect: &'static str,
    /// Parameter.
    pub parameter: &'static str,
    /// Unit of the SI value.
    pub unit: &'static str,
    /// SI value, as `--effect` takes it.
    pub value: f64,
    /// Interval with a nominal coverage of 90 %, SI, with the error of the formula.
    pub interval: (f64, f64),
    /// SI value at which the effect is absent.
    pub absent: f64,
    /// Error of the formula that gave the size.
    pub size_error: SizeError,
    /// Coordinate in the reduced model, and its interval.
    pub coordinate: (f64, (f64, f64)),
}

/// Everything that the recordings of one glass show.
#[derive(Clone, Debug)]
pub struct Findings {
    /// Glass and liquid as stated.
    pub known: Known,
    /// Recordings that were fitted, and the one that was held out.
    pub split: Split,
    /// Calibration by the references.
    pub calibration: Calibration,
    /// Thresholds that were used.
    pub limits: Thresholds,
    /// Constants of the decision that were used.
    pub rules: DecisionRules,
    /// Verdict with the fits that led to it.
    pub assessment: Assessment,
    /// Discrepancy of the model without an effect.
    pub map: Vec<Cell>,
    /// Signatures of the effects on these recordings.
    pub isolability: Isolability,
    /// Parameters of the chosen fit.
    pub estimates: Vec<Estimate>,
    /// Parameters of the other effects that a tied verdict names, each by the fit with that effect alone.
    pub rivals: Vec<Estimate>,
    /// Errors on the held-out recording, where there is one.
    pub gap: Option<MeasuredGap>,
    /// Recording that would distinguish the leading candidates of an ambiguous verdict.
    pub suggestion: Option<Suggestion>,
}

/// Returns the parameters of the chosen effects with their intervals; coordinates are counted from `stated`.
#[must_use]
pub fn estimates(assessment: &Assessment, rules: &DecisionRules, stated: &Stated) -> Vec<Estimate> {
    estimates_of(assessment.chosen(), assessment.verdict.misfit(), rules, stated)
}

/// Returns the parameters of the effects that a tied verdict names beside the chosen one, each by the fit with it alone.
#[must_use]
pub fn rivals(assessment: &Assessment, rules: &DecisionRules, stated: &Stated) -> Vec<Estimate> {
    let Verdict::Ambiguous(claim) = &assessment.verdict else { return Vec::new() };
    let [chosen] = claim.fitted.active.as_slice() else { return Vec::new() };
    let is_rival = |c: &&Candidate| match c.names[..] {
        [name] => name != chosen.entry.name && claim.names.contains(&name),
        _ => false,
    };
    let search = &assessment.search;
    let fits = search.ranking.iter().filter(is_rival).filter_map(|c| c.fitted.as_ref());
    fits.flat_map(|fitted| estimates_of(fitted, fitted.chi2(search.count), rules, stated)).collect()
}

/// Returns the parameters of the effects of `fitted`, which leaves `misfit` per number.
///
/// The half-width comes from the curvature of the posterior, widened by the square root of the misfit. A size that only a
/// formula gives has an error of its own beside it, [`SizeError`].
fn estimates_of(fitted: &Fitted, misfit: f64, rules: &DecisionRules, stated: &Stated) -> Vec<Estimate> {
    let covariance = fitted.covariance();
    let widen = misfit.max(1.0).sqrt();
    let one = |(i, (effect, which)): (usize, &(usize, usize))| {
        let active = &fitted.active[*effect];
        let parameter = &active.entry.parameters[*which];
        let value = active.values[*which];
        let place = fitted.theta.len() + i;
        let deviation = covariance.as_ref().map_or(f64::INFINITY, |c| c[(place, place)].max(0.0).sqrt());
        let half = rules.interval_deviations * widen * deviation;
        let (least, largest) = parameter.range;
        let size_error = if *which == 0 { SizeError::of(active.entry.kind) } else { SizeError::EXACT };
        let (low, high) = size_error.interval(value, half, parameter.neutral);
        let interval = (low.max(least), high.min(largest));
        let si = |coordinate: f64| parameter.to_value(coordinate, stated);
        Estimate {
            effect: active.entry.name,
            parameter: parameter.name,
            unit: parameter.unit,
            value: si(value),
            interval: (si(interval.0), si(interval.1)),
            absent: si(parameter.neutral),
            size_error,
            coordinate: (value, interval),
        }
    };
    fitted.free.iter().enumerate().map(one).collect()
}
