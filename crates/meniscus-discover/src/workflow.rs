//! The steps in order: split, calibrate, detect, localise, screen, rank, decide, ask, add, and the gap.

use super::ask::{Question, ask};
use super::calibrate::{Calibration, Group};
use super::evidence::isolability;
use super::gap::{Gap, gap};
use super::localise::{Cell, localise};
use super::predict::Known;
use super::problem::Problem;
use super::record::Record;
use super::thresholds::Thresholds;
use super::verdict::{Decision, Verdict, decide};
use crate::fit_cache::Kept;
use meniscus::reduced::effects::{Entry, LIBRARY, Stated};
use std::sync::Arc;

/// How a discovery is made.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Effects that may be named.
    pub library: Vec<&'static Entry>,
    /// Seed of the bootstrap.
    pub seed: u64,
    /// Factor on the noise that rest frames show; 1 unless it is to be misjudged.
    pub noise: f64,
    /// Deviation of each recording's own clock, s, where it has one.
    pub own_clocks_s: Option<f64>,
    /// Where fits are kept, so that an interrupted discovery goes on.
    pub kept: Option<Arc<Kept>>,
}

impl Default for Settings {
    fn default() -> Self {
        Self { library: LIBRARY.iter().collect(), seed: 1, noise: 1.0, own_clocks_s: None, kept: None }
    }
}

/// A parameter with its interval.
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
    /// Interval that should hold the truth in 90 % of cases, SI.
    pub interval: (f64, f64),
    /// Coordinate in the reduced model, and its interval.
    pub coordinate: (f64, (f64, f64)),
}

/// Everything about one discovery.
#[derive(Clone, Debug)]
pub struct Discovery {
    /// The decision and what led to it.
    pub verdict: Verdict,
    /// Names of the recordings that were fitted, and of the sealed one.
    pub fitted: Vec<String>,
    /// Name of the sealed one.
    pub sealed: Option<String>,
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

/// The recordings to fit and the sealed one: of four or more, the second strongest stays sealed, so that
/// it lies inside of what was fitted.
#[must_use]
pub fn split(records: &[Record]) -> (Vec<Record>, Option<Record>) {
    if records.len() < 4 {
        return (records.to_vec(), None);
    }
    let strength = |record: &Record| {
        record.drive.along_m_s2.iter().flatten().map(|a| a * a).sum::<f64>()
            / record.drive.along_m_s2.len() as f64
    };
    let mut order: Vec<usize> = (0..records.len()).collect();
    order.sort_by(|a, b| strength(&records[*b]).total_cmp(&strength(&records[*a])));
    let sealed = order[1];
    let kept = records.iter().enumerate().filter(|(i, _)| *i != sealed).map(|(_, r)| r.clone()).collect();
    (kept, Some(records[sealed].clone()))
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
    let (fit, sealed) = split(records);
    let calibration = Calibration::from(groups, &fit, settings.own_clocks_s);
    let problem = Problem::new(&fit, known, &calibration, settings.noise)?.keeping(&settings.kept);
    let verdict = decide(&problem, &settings.library, limits, settings.seed);
    // Both speak of the problem as it was before formulas were distrusted, so the fit must be that one's.
    let map = localise(&problem, &verdict.first);
    let (length, cosines) = isolability(&problem, &verdict.first, &settings.library);
    let names = settings.library.iter().map(|entry| entry.name).collect();
    let question =
        (verdict.decision == Decision::Tied).then(|| ask(&problem, &calibration, &verdict)).flatten();
    let estimates = estimates(&verdict, &known.stated());
    let mut curves = Vec::new();
    let gap = match &sealed {
        Some(sealed) => {
            let (gap, drawn) = gap(sealed, known, &calibration, &problem, &verdict, settings.noise)?;
            curves = drawn;
            Some(gap)
        }
        None => None,
    };
    Ok(Discovery {
        verdict,
        fitted: fit.iter().map(|r| r.name.clone()).collect(),
        sealed: sealed.map(|r| r.name),
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

/// Returns the values of the chosen effects, counted from `stated`, with 90 % intervals: the curvature of the posterior, widened by the
/// misfit that is left.
#[must_use]
pub fn estimates(verdict: &Verdict, stated: &Stated) -> Vec<Estimate> {
    let fitted = &verdict.chosen;
    let covariance = fitted.covariance();
    let widen = verdict.chi2.max(1.0).sqrt();
    let one = |(i, (effect, which)): (usize, &(usize, usize))| {
        let active = &fitted.active[*effect];
        let parameter = &active.entry.parameters[*which];
        let value = active.values[*which];
        let place = fitted.theta.len() + i;
        let deviation = covariance.as_ref().map_or(f64::INFINITY, |c| c[(place, place)].max(0.0).sqrt());
        let half = 1.645 * widen * deviation;
        let (least, largest) = parameter.range;
        let interval = ((value - half).max(least), (value + half).min(largest));
        let si = |coordinate: f64| parameter.to_value(coordinate, stated);
        Estimate {
            effect: active.entry.name,
            parameter: parameter.name,
            unit: parameter.unit,
            value: si(value),
            interval: (si(interval.0), si(interval.1)),
            coordinate: (value, interval),
        }
    };
    fitted.free.iter().enumerate().map(one).collect()
}
