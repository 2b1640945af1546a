//! The steps in order: split, calibrate, detect, localise, screen, rank, decide, ask, add, and the gap.

use super::ask::{Question, ask};
use super::calibrate::{Calibration, Group};
use super::decision_rules::DecisionRules;
use super::evidence::isolability;
use super::gap::{Gap, gap};
use super::localise::{Cell, localise};
use super::predict::Known;
use super::problem::Problem;
use super::record::Record;
use super::settings::Settings;
use super::split::Split;
use super::thresholds::Thresholds;
use super::verdict::{Decision, Verdict, decide};
/// A parameter with its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Effect.
    pub effect: &'static str,
    /// Parameter.
    pub parameter: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Value.
    pub value: f64,
    /// Interval that should hold the truth in 90 % of cases.
    pub interval: (f64, f64),
}

/// Everything about one discovery.
#[derive(Clone, Debug)]
pub struct Discovery {
    /// The decision and what led to it.
    pub verdict: Verdict,
    /// The recordings that were fitted, and the one that was held out.
    pub split: Split,
    /// Glass and liquid as stated.
    pub known: Known,
    /// Constants of the decision.
    pub rules: DecisionRules,
    /// What the references taught.
    pub calibration: Calibration,
    /// Thresholds that were used.
    pub limits: Thresholds,
    /// Where the model without an effect disagrees.
    pub map: Vec<Cell>,
    /// Names, signal over noise, cosines of the signatures on these recordings.
    pub isolability: (Vec<&'static str>, Vec<f64>, Vec<Vec<f64>>),
    /// Parameters of the chosen fit.
    pub estimates: Vec<Estimate>,
    /// Errors on the sealed recording.
    pub gap: Option<Gap>,
    /// The motion that would tell the leading candidates apart.
    pub question: Option<Question>,
    /// Curves of the sealed recording: time, measured, untouched, with the effect (slope or peak, m).
    pub curves: Vec<[f64; 4]>,
}

/// One discovery on `records` of a liquid of which `known` is said, against `groups` of references.
///
/// # Errors
/// In words, when recordings are too few or cannot be fitted.
pub fn discover(
    records: &[Record],
    known: Known,
    groups: &[&Group],
    limits: &Thresholds,
    settings: &Settings,
) -> Result<Discovery, String> {
    if records.len() < 2 {
        return Err(format!(
            "{} recording is too few: with one shake all kinds of damping look the same; give three of different \
             strength, or more",
            records.len()
        ));
    }
    let split = Split::of(records);
    let calibration = Calibration::from(groups, &split.fitted, settings.own_clocks_s);
    let problem = Problem::new(&split.fitted, known, &calibration, settings.noise)?.keeping(&settings.kept);
    let verdict = decide(&problem, limits, settings);
    // Both speak of the problem as it was before formulas were distrusted, so the fit must be that one's.
    let map = localise(&problem, &verdict.first);
    let (length, cosines) = isolability(&problem, &verdict.first, &settings.library);
    let names = settings.library.iter().map(|entry| entry.name).collect();
    let question =
        (verdict.decision == Decision::Tied).then(|| ask(&problem, &calibration, &verdict)).flatten();
    let estimates = estimates(&verdict, &settings.rules);
    let mut curves = Vec::new();
    let gap = match &split.held_out {
        Some(held_out) => {
            let (gap, drawn) = gap(held_out, known, &calibration, &problem, &verdict, settings.noise)?;
            curves = drawn;
            Some(gap)
        }
        None => None,
    };
    Ok(Discovery {
        verdict,
        split,
        known,
        rules: settings.rules,
        calibration,
        limits: limits.clone(),
        map,
        isolability: (names, length, cosines),
        estimates,
        gap,
        question,
        curves,
    })
}

/// Values of the chosen effects with 90 % intervals: the curvature of the posterior, widened by the
/// misfit that is left.
#[must_use]
pub fn estimates(verdict: &Verdict, rules: &DecisionRules) -> Vec<Estimate> {
    let fitted = &verdict.chosen;
    let covariance = fitted.covariance();
    let widen = verdict.chi2.max(1.0).sqrt();
    let one = |(i, (effect, which)): (usize, &(usize, usize))| {
        let active = &fitted.active[*effect];
        let parameter = &active.entry.parameters[*which];
        let value = active.values[*which];
        let place = fitted.theta.len() + i;
        let deviation = covariance.as_ref().map_or(f64::INFINITY, |c| c[(place, place)].max(0.0).sqrt());
        let half = rules.interval_deviations * widen * deviation;
        let (least, largest) = parameter.range;
        Estimate {
            effect: active.entry.name,
            parameter: parameter.name,
            unit: parameter.unit,
            value,
            interval: ((value - half).max(least), (value + half).min(largest)),
        }
    };
    fitted.free.iter().enumerate().map(one).collect()
}
