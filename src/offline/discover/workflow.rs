//! The steps in order: split, calibrate, detect, localise, screen, rank, decide, ask, add, and the gap.

use super::ask::{Question, ask};
use super::calibrate::{Calibration, Group};
use super::fit::Fitted;
use super::localise::{Cell, localise};
use super::predict::{Known, predict};
use super::problem::Problem;
use super::record::{Quantity, Record};
use super::verdict::{Decision, Thresholds, Verdict, decide, isolability};
use crate::effects::{Active, Entry, LIBRARY};
use crate::offline::prelude::*;
use nalgebra::{DMatrix, DVector};

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
}

impl Default for Settings {
    fn default() -> Self {
        Self { library: LIBRARY.iter().collect(), seed: 1, noise: 1.0, own_clocks_s: None }
    }
}

/// Error on the sealed recording, m, noise subtracted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// The calibrated model as it was.
    pub untouched: f64,
    /// With the nuisances fitted again.
    pub refitted: f64,
    /// With the nuisances and a free linear correction.
    pub black_box: f64,
    /// With the effect.
    pub effect: f64,
    /// Noise that was subtracted.
    pub noise: f64,
}

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

/// Thresholds from the references: each in turn is judged by the others, and what clean glasses show is
/// not believed.
///
/// # Errors
/// In words, when a reference cannot be fitted.
pub fn thresholds(groups: &[&Group], settings: &Settings) -> Result<Thresholds, String> {
    let mut limits = Thresholds::default();
    if groups.len() < 3 {
        // Too few to judge one another: twice the gain is asked for.
        limits.gain *= 2.0;
        return Ok(limits);
    }
    for (index, group) in groups.iter().enumerate() {
        let others: Vec<&Group> =
            groups.iter().enumerate().filter(|(i, _)| *i != index).map(|(_, g)| *g).collect();
        let (records, _) = split(&group.records);
        let calibration = Calibration::from(&others, &records, settings.own_clocks_s);
        let problem = Problem::new(&records, group.known, &calibration, settings.noise)?;
        let verdict =
            decide(&problem, &settings.library, Thresholds { gain: f64::INFINITY, chi2: f64::INFINITY }, 1);
        let gain = verdict.ranking.first().map_or(0.0, |best| best.gain);
        limits.gain = limits.gain.max(1.2 * gain);
        limits.chi2 = limits.chi2.max(1.1 * verdict.chi2);
    }
    Ok(limits)
}

/// One discovery on `records` of a liquid of which `known` is said, against `groups` of references.
///
/// # Errors
/// In words, when recordings are too few or cannot be fitted.
pub fn discover(
    records: &[Record],
    known: Known,
    groups: &[&Group],
    limits: Thresholds,
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
    let problem = Problem::new(&fit, known, &calibration, settings.noise)?;
    let verdict = decide(&problem, &settings.library, limits, settings.seed);
    let map = localise(&problem, &verdict.plain);
    let (length, cosines) = isolability(&problem, &verdict.plain, &settings.library);
    let names = settings.library.iter().map(|entry| entry.name).collect();
    let question =
        (verdict.decision == Decision::Tied).then(|| ask(&problem, &calibration, &verdict)).flatten();
    let estimates = estimates(&verdict);
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
        limits,
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
pub fn estimates(verdict: &Verdict) -> Vec<Estimate> {
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

/// Weight of a channel in the error of the surface: mean square of its shape over the profile.
fn weight(quantity: Quantity) -> f64 {
    match quantity {
        Quantity::Level | Quantity::Peak => 1.0,
        Quantity::Slope => 0.297,
        Quantity::Bow => 0.25,
        Quantity::Place => 0.0,
    }
}

/// What `theta` and `active` leave of the sealed recording: mean square of the surface's error, m2.
fn error(problem: &Problem, theta: &[f64], active: &[Active]) -> f64 {
    let record = problem.records().next().cloned();
    let Some(record) = record else { return f64::NAN };
    let left = problem.left(0, theta, active);
    let mut sum = 0.0;
    let frames = record.frames() as f64;
    for ((_, c, f), e) in problem.places().iter().zip(left) {
        if *f >= record.rest_frames {
            sum += weight(record.channels[*c].quantity) * e * e;
        }
    }
    sum / (frames - record.rest_frames as f64)
}

/// Errors on the sealed recording; the lag is that of the prior, or, where clocks are the recordings' own,
/// fitted for each model on the sealed recording.
fn gap(
    sealed: &Record,
    known: Known,
    calibration: &Calibration,
    problem: &Problem,
    verdict: &Verdict,
    noise: f64,
) -> Result<(Gap, Vec<[f64; 4]>), String> {
    let one = Problem::new(std::slice::from_ref(sealed), known, calibration, noise)?;
    let shared = |fitted: &Fitted| {
        let mut theta = fitted.theta[..super::predict::SHARED].to_vec();
        theta.push(calibration.lag_s);
        theta
    };
    let own = |theta: Vec<f64>, active: &[Active]| {
        if calibration.lag_deviation_s < 0.01 {
            return theta;
        }
        let at = |lag: f64| {
            let mut tried = theta.clone();
            tried[super::predict::SHARED] = lag;
            (error(&one, &tried, active), tried)
        };
        let lags = (-60..=60).map(|i| f64::from(i) * 0.01);
        lags.map(at).min_by(|a, b| a.0.total_cmp(&b.0)).map_or(theta.clone(), |best| best.1)
    };
    let spread: f64 = sealed
        .channels
        .iter()
        .map(|c| weight(c.quantity) * calibration.noise_of(c.quantity).sigma_m.powi(2))
        .sum();
    let after = |square: f64| (square - spread).max(0.0).sqrt();
    let untouched = own(one.mean.clone(), &[]);
    let plain = own(shared(&verdict.plain), &[]);
    let chosen = own(shared(&verdict.chosen), &verdict.chosen.active);
    let active = &verdict.chosen.active;
    let gap = Gap {
        untouched: after(error(&one, &untouched, &[])),
        refitted: after(error(&one, &plain, &[])),
        black_box: after(black_box(problem, &verdict.plain, &one, &plain)),
        effect: after(error(&one, &chosen, active)),
        noise: spread.sqrt(),
    };
    let c = sealed
        .channels
        .iter()
        .position(|c| matches!(c.quantity, Quantity::Slope | Quantity::Peak))
        .unwrap_or(0);
    let lag = super::predict::SHARED;
    let before = predict(sealed, &known, &untouched, untouched[lag], &[]);
    let with = predict(sealed, &known, &chosen, chosen[lag], active);
    let mean = calibration.matched(sealed).map(|left| left.mean[c].clone()).unwrap_or_default();
    let curves = (0..sealed.frames())
        .map(|f| {
            let more = mean.get(f).copied().unwrap_or(0.0);
            let seen = sealed.channels[c].value[f].unwrap_or(f64::NAN);
            [f as f64 * sealed.interval_s, seen, before[c][f] + more, with[c][f] + more]
        })
        .collect();
    Ok((gap, curves))
}

/// A correction without a name: in each channel the residual is fitted by ridge regression on the expected
/// values of the last frames, on the recordings that were fitted; mean square that it leaves of the
/// sealed one, m2.
fn black_box(problem: &Problem, plain: &Fitted, one: &Problem, theta: &[f64]) -> f64 {
    const PAST: usize = 6;
    let features = |expected: &[Vec<f64>], c: usize, f: usize| -> Vec<f64> {
        let past = (0..PAST).map(|k| expected[c][f.saturating_sub(2 * k)]);
        past.chain([1e-3, expected[c][f] * expected[c][f].abs() * 50.0]).collect()
    };
    let Some(channels) = one.records().next().map(|r| r.channels.len()) else { return f64::NAN };
    let lag = super::predict::SHARED;
    let mut weights = Vec::new();
    for c in 0..channels {
        let mut square = DMatrix::<f64>::identity(PAST + 2, PAST + 2) * 1e-6;
        let mut right = DVector::<f64>::zeros(PAST + 2);
        for (which, record) in problem.records().enumerate() {
            let expected = predict(record, &problem.known, &plain.theta, plain.theta[lag + which], &[]);
            let left = problem.left(which, &plain.theta, &[]);
            let mine = problem.places().into_iter().filter(|(r, ..)| *r == which);
            for ((_, channel, f), e) in mine.zip(left) {
                if channel == c {
                    let x = DVector::from_vec(features(&expected, c, f));
                    square += &x * x.transpose();
                    right += x * e;
                }
            }
        }
        weights
            .push(square.cholesky().map(|factor| factor.solve(&right)).unwrap_or(DVector::zeros(PAST + 2)));
    }
    let Some(record) = one.records().next() else { return f64::NAN };
    let expected = predict(record, &one.known, theta, theta[lag], &[]);
    let mut sum = 0.0;
    for ((_, c, f), e) in one.places().iter().zip(one.left(0, theta, &[])) {
        if *f >= record.rest_frames {
            let x = DVector::from_vec(features(&expected, *c, *f));
            sum += weight(record.channels[*c].quantity) * (e - x.dot(&weights[*c])).powi(2);
        }
    }
    sum / (record.frames() - record.rest_frames) as f64
}

/// Error of one fit on `sealed`, m, noise subtracted.
///
/// # Errors
/// In words, when the sealed recording cannot be used.
pub fn gap_of(
    sealed: &Record,
    known: Known,
    calibration: &Calibration,
    fitted: &Fitted,
    noise: f64,
) -> Result<f64, String> {
    let one = Problem::new(std::slice::from_ref(sealed), known, calibration, noise)?;
    let mut theta = fitted.theta[..super::predict::SHARED].to_vec();
    theta.push(calibration.lag_s);
    let spread: f64 = sealed
        .channels
        .iter()
        .map(|c| weight(c.quantity) * calibration.noise_of(c.quantity).sigma_m.powi(2))
        .sum();
    Ok((error(&one, &theta, &fitted.active) - spread).max(0.0).sqrt())
}
