//! Gap on the held-out recording: error of each model on it, noise subtracted.

use crate::baseline::calibrate::Calibration;
use crate::baseline::predict::{Difference, SHARED, predict};
use crate::decision::assessment::Assessment;
use crate::fitting::error::ProblemError;
use crate::fitting::fit::Fitted;
use crate::fitting::problem::Problem;
use crate::recordings::record::{Channel, Quantity, Record};
use crate::recordings::stated::Known;
use meniscus::reduced::DrawnLaw;
use meniscus::reduced::effects::Active;
use nalgebra::{DMatrix, DVector};

/// Standard deviation of the lag from which each recording has a clock of its own, s.
const OWN_CLOCK_DEVIATION_S: f64 = 0.01;

/// Errors of the surface on the held-out recording, m, noise subtracted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Calibrated model as it was.
    pub untouched: f64,
    /// Model with its nuisances fitted again.
    pub refitted: f64,
    /// Model with its nuisances and a free linear correction.
    pub black_box: f64,
    /// Model with the effect.
    pub effect: f64,
    /// Noise that was subtracted.
    pub noise: f64,
}

/// Returns the weight of a channel in the error of the surface: mean square of its shape over the profile.
fn weight(quantity: Quantity) -> f64 {
    match quantity {
        Quantity::Level | Quantity::Peak => 1.0,
        Quantity::Slope => 0.297,
        Quantity::Bow => 0.25,
        Quantity::Place => 0.0,
    }
}

/// Returns the mean square error of the surface on the held-out recording, m2.
fn error(problem: &Problem, theta: &[f64], difference: Difference<'_>) -> f64 {
    let record = problem.records().next().cloned();
    let Some(record) = record else { return f64::NAN };
    let left = problem.residual_with_m(0, theta, difference);
    let mut sum = 0.0;
    let frames = record.frames() as f64;
    for ((_, c, f), e) in problem.places().iter().zip(left) {
        if *f >= record.rest_frames {
            sum += weight(record.channels[*c].quantity) * e * e;
        }
    }
    sum / (frames - record.rest_frames as f64)
}

/// Returns the root mean square error of `expected` (m, by channel) over the surface of `record` after its rest, m.
#[must_use]
pub fn left_m(record: &Record, expected: &[Vec<f64>]) -> f64 {
    let mut sum = 0.0;
    for (channel, series) in record.channels.iter().zip(expected) {
        let seen = channel.value.iter().zip(series).skip(record.rest_frames);
        let squares: Vec<f64> = seen.filter_map(|(z, expected)| z.map(|z| (z - expected).powi(2))).collect();
        sum += weight(channel.quantity) * squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    }
    sum.sqrt()
}

/// Returns the same error with the noise of `noise_m` subtracted, m.
#[must_use]
pub fn gap_to(record: &Record, expected: &[Vec<f64>], noise_m: f64) -> f64 {
    (left_m(record, expected).powi(2) - noise_m * noise_m).max(0.0).sqrt()
}

/// Gap with the curves that show it.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredGap {
    /// Errors.
    pub gap: Gap,
    /// Curves of the slope, or of the peak: time (s), measured, untouched and with the effect (m).
    pub curves: Vec<[f64; 4]>,
}

/// Returns the gap on the held-out recording.
///
/// The lag is that of the prior. Where each recording has a clock of its own, it is fitted for each model on the
/// held-out recording.
///
/// # Errors
/// [`ProblemError`], when the held-out recording cannot be used.
pub fn gap(
    held_out: &Record,
    calibration: &Calibration,
    problem: &Problem,
    assessment: &Assessment,
    noise: f64,
) -> Result<MeasuredGap, ProblemError> {
    let one = Problem::new(std::slice::from_ref(held_out), problem.known, calibration, noise)?;
    let (plain_fit, chosen_fit) = (&assessment.search.plain, assessment.chosen());
    let nothing = Difference::default();
    let active = effects(&chosen_fit.active);
    let untouched = own_lag(&one, calibration, one.mean.clone(), nothing);
    let plain = own_lag(&one, calibration, shared(&plain_fit.theta, calibration), nothing);
    let chosen = own_lag(&one, calibration, shared(&chosen_fit.theta, calibration), active);
    let noise_m2 = noise_m2(held_out, calibration);
    let after = |square: f64| (square - noise_m2).max(0.0).sqrt();
    let gap = Gap {
        untouched: after(error(&one, &untouched, nothing)),
        refitted: after(error(&one, &plain, nothing)),
        black_box: after(black_box(problem, plain_fit, &one, &plain)),
        effect: after(error(&one, &chosen, active)),
        noise: noise_m2.sqrt(),
    };
    let (before, with) = (one.expected_m(0, &untouched, nothing), one.expected_m(0, &chosen, active));
    Ok(MeasuredGap { gap, curves: curves(held_out, &before, &with) })
}

/// Returns the difference that `active` make.
fn effects(active: &[Active]) -> Difference<'_> {
    Difference { active, law: None }
}

/// Returns the curves of the slope, or of the peak, of `held_out` with the predictions `before` and `with`.
fn curves(held_out: &Record, before: &[Vec<f64>], with: &[Vec<f64>]) -> Vec<[f64; 4]> {
    let c = held_out
        .channels
        .iter()
        .position(|c| matches!(c.quantity, Quantity::Slope | Quantity::Peak))
        .unwrap_or(0);
    let row = |f: usize| {
        let seen = held_out.channels[c].value[f].unwrap_or(f64::NAN);
        [f as f64 * held_out.interval_s, seen, before[c][f], with[c][f]]
    };
    (0..held_out.frames()).map(row).collect()
}

/// Error on the held-out recording with a drawn law.
#[derive(Clone, Debug, PartialEq)]
pub struct LawGap {
    /// Error with the law, m, noise subtracted.
    pub law_m: f64,
    /// Curves of the slope: time (s), measured, untouched and with the law (m).
    pub curves: Vec<[f64; 4]>,
}

/// Returns the error of `law`, fitted to `problem` with the baseline's numbers `theta`, on the held-out recording.
///
/// # Errors
/// [`ProblemError`], when the held-out recording cannot be used.
pub fn law_gap(
    held_out: &Record,
    calibration: &Calibration,
    problem: &Problem,
    fitted: (&[f64], &DrawnLaw),
    noise: f64,
) -> Result<LawGap, ProblemError> {
    let (theta, law) = fitted;
    let one = Problem::new(std::slice::from_ref(held_out), problem.known, calibration, noise)?;
    let difference = Difference { active: &[], law: Some(law) };
    let untouched = own_lag(&one, calibration, one.mean.clone(), Difference::default());
    let theta = own_lag(&one, calibration, shared(theta, calibration), difference);
    let left = error(&one, &theta, difference) - noise_m2(held_out, calibration);
    let before = one.expected_m(0, &untouched, Difference::default());
    let with = one.expected_m(0, &theta, difference);
    Ok(LawGap { law_m: left.max(0.0).sqrt(), curves: curves(held_out, &before, &with) })
}

/// Returns the shared numbers of the fitted `theta` with the lag of the prior.
fn shared(theta: &[f64], calibration: &Calibration) -> Vec<f64> {
    let mut theta = theta[..SHARED].to_vec();
    theta.push(calibration.lag_s);
    theta
}

/// Returns `theta` with the lag that fits the held-out recording best, where it has a clock of its own.
fn own_lag(
    one: &Problem,
    calibration: &Calibration,
    theta: Vec<f64>,
    difference: Difference<'_>,
) -> Vec<f64> {
    if calibration.lag_deviation_s < OWN_CLOCK_DEVIATION_S {
        return theta;
    }
    let at = |lag: f64| {
        let mut tried = theta.clone();
        tried[SHARED] = lag;
        (error(one, &tried, difference), tried)
    };
    let lags = (-60..=60).map(|i| f64::from(i) * 0.01);
    lags.map(at).min_by(|a, b| a.0.total_cmp(&b.0)).map_or(theta.clone(), |best| best.1)
}

/// Returns the mean square noise of the surface of `record`, m2.
fn noise_m2(record: &Record, calibration: &Calibration) -> f64 {
    let of_channel = |c: &Channel| weight(c.quantity) * calibration.noise_of(c.quantity).sigma_m.powi(2);
    record.channels.iter().map(of_channel).sum()
}

/// Returns the mean square error on the held-out recording with a correction without a name, m2.
///
/// In each channel the residual is fitted by ridge regression on the expected values of the last frames, on the
/// recordings that were fitted.
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
            let left = problem.residual_m(which, &plain.theta, &[]);
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
    for ((_, c, f), e) in one.places().iter().zip(one.residual_m(0, theta, &[])) {
        if *f >= record.rest_frames {
            let x = DVector::from_vec(features(&expected, *c, *f));
            sum += weight(record.channels[*c].quantity) * (e - x.dot(&weights[*c])).powi(2);
        }
    }
    sum / (record.frames() - record.rest_frames) as f64
}

/// Returns the error of one fit on `held_out`, m, noise subtracted.
///
/// # Errors
/// [`ProblemError`], when the held-out recording cannot be used.
pub fn gap_of(
    held_out: &Record,
    known: Known,
    calibration: &Calibration,
    fitted: &Fitted,
    noise: f64,
) -> Result<f64, ProblemError> {
    let one = Problem::new(std::slice::from_ref(held_out), known, calibration, noise)?;
    let theta = shared(&fitted.theta, calibration);
    Ok((error(&one, &theta, effects(&fitted.active)) - noise_m2(held_out, calibration)).max(0.0).sqrt())
}
