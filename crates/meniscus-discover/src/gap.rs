//! The gap on the sealed recording: what each model leaves of it, noise subtracted.

use super::calibrate::Calibration;
use super::fit::Fitted;
use super::predict::{Known, SHARED, predict};
use super::problem::Problem;
use super::record::{Quantity, Record};
use super::verdict::Verdict;
use meniscus::reduced::effects::Active;
use nalgebra::{DMatrix, DVector};

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

/// What `expected`, channel by channel (m), leaves of `record` behind its rest: root mean square over the surface, m.
#[must_use]
pub fn left_m(record: &Record, expected: &[Vec<f64>]) -> f64 {
    let mut sum = 0.0;
    for (channel, said) in record.channels.iter().zip(expected) {
        let seen = channel.value.iter().zip(said).skip(record.rest_frames);
        let squares: Vec<f64> = seen.filter_map(|(z, said)| z.map(|z| (z - said).powi(2))).collect();
        sum += weight(channel.quantity) * squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    }
    sum.sqrt()
}

/// The same with the noise of `noise_m` subtracted.
#[must_use]
pub fn gap_to(record: &Record, expected: &[Vec<f64>], noise_m: f64) -> f64 {
    (left_m(record, expected).powi(2) - noise_m * noise_m).max(0.0).sqrt()
}

/// Errors on the sealed recording; the lag is that of the prior, or, where clocks are the recordings' own,
/// fitted for each model on the sealed recording. With them the curves of the sealed recording: time (s),
/// measured, untouched and with the effect (slope or peak, m).
///
/// # Errors
/// In words, when the sealed recording cannot be used.
pub fn gap(
    sealed: &Record,
    known: Known,
    calibration: &Calibration,
    problem: &Problem,
    verdict: &Verdict,
    noise: f64,
) -> Result<(Gap, Vec<[f64; 4]>), String> {
    let one = Problem::new(std::slice::from_ref(sealed), known, calibration, noise)?;
    let shared = |fitted: &Fitted| {
        let mut theta = fitted.theta[..SHARED].to_vec();
        theta.push(calibration.lag_s);
        theta
    };
    let own = |theta: Vec<f64>, active: &[Active]| {
        if calibration.lag_deviation_s < 0.01 {
            return theta;
        }
        let at = |lag: f64| {
            let mut tried = theta.clone();
            tried[SHARED] = lag;
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
    let lag = SHARED;
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
    let lag = SHARED;
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
    let mut theta = fitted.theta[..SHARED].to_vec();
    theta.push(calibration.lag_s);
    let spread: f64 = sealed
        .channels
        .iter()
        .map(|c| weight(c.quantity) * calibration.noise_of(c.quantity).sigma_m.powi(2))
        .sum();
    Ok((error(&one, &theta, &fitted.active) - spread).max(0.0).sqrt())
}
