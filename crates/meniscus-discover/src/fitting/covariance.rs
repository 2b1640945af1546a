//! One recording with the covariance of the baseline's error, channel by channel.

use super::error::ProblemError;
use crate::baseline::calibrate::Calibration;
use crate::recordings::record::Record;
use nalgebra::{DMatrix, DVector};

/// Correlation from frame to frame of a formula's error.
pub(super) const CORRELATION: f64 = 0.9;

/// Fewest numbers that a recording has to hold.
const LEAST_NUMBERS: usize = 50;

/// One recording, ready to be compared.
#[derive(Clone, Debug)]
pub(super) struct Ready {
    pub(super) record: Record,
    /// The covariance C of each channel, m2, in the order of the index.
    pub(super) covariance: Vec<DMatrix<f64>>,
    /// Channel and frame of each number that was measured.
    pub(super) index: Vec<(usize, usize)>,
    /// Measured values, m.
    pub(super) measured: DVector<f64>,
    /// `rbar` by channel and frame, m; none without references in the motion.
    pub(super) rbar: Option<Vec<Vec<f64>>>,
    /// Inverse of the lower Cholesky factor of each.
    pub(super) whiten: Vec<DMatrix<f64>>,
}

impl Ready {
    /// Adds `rbar` to the `expected` channels, where the first mode swings `stretch` times as fast as in the references.
    pub(super) fn add_rbar(&self, expected: &mut [Vec<f64>], stretch: f64) {
        for (expected, rbar) in expected.iter_mut().zip(self.rbar.iter().flatten()) {
            let here = followed(rbar, self.record.rest_frames, stretch);
            expected.iter_mut().zip(here).for_each(|(expected, rbar)| *expected += rbar);
        }
    }
}

/// Returns the `series` of a slosh that begins in frame `start` as it is where that swings `stretch` times as fast.
///
/// Most of the model error is a wave, and belongs to a phase of the slosh: `r(t0 + (t - t0) stretch)`.
fn followed(series: &[f64], start: usize, stretch: f64) -> Vec<f64> {
    let last = series.len().saturating_sub(1);
    let at = |frame: usize| {
        let late = frame.saturating_sub(start) as f64;
        let place = (frame as f64 + late * (stretch - 1.0)).clamp(0.0, last as f64);
        let (low, part) = (place as usize, place.fract());
        series[low] + part * (series[(low + 1).min(last)] - series[low])
    };
    (0..series.len()).map(at).collect()
}

/// Prepares `record`, one of `beside` of the same glass.
pub(super) fn prepare(
    record: &Record,
    beside: usize,
    calibration: &Calibration,
    noise: f64,
) -> Result<Ready, ProblemError> {
    let matched = calibration.matched(record);
    let mut index = Vec::new();
    let mut measured = Vec::new();
    for (c, channel) in record.channels.iter().enumerate() {
        for (f, value) in channel.value.iter().enumerate() {
            if let Some(value) = value {
                index.push((c, f));
                measured.push(*value);
            }
        }
    }
    if index.len() < LEAST_NUMBERS {
        return Err(ProblemError::TooFewNumbers {
            recording: record.name.clone(),
            numbers: index.len(),
            least: LEAST_NUMBERS,
        });
    }
    let references = matched.as_ref().map_or(0, |m| m.scatter.len());
    let more = matched.as_ref().map_or(1.0, |m| 1.0 + m.leverage);
    let (mut covariances, mut whiten) = (Vec::new(), Vec::new());
    for block in index.chunk_by(|a, b| a.0 == b.0) {
        let (c, n) = (block[0].0, block.len());
        let kind = record.channels[c].quantity;
        let model = calibration.noise_of(kind);
        let s2 = model.sigma_m * model.sigma_m * noise * noise * more;
        let offset = calibration.offset_m2(kind, beside);
        let misfit = if references == 0 { calibration.misfit_m(kind).powi(2) } else { 0.0 };
        let mut covariance = DMatrix::from_fn(n, n, |i, j| {
            let apart = block[i].1.abs_diff(block[j].1) as i32;
            let white = if i == j { 0.3 * s2 + 1e-10 } else { 0.0 };
            white + 0.7 * s2 * model.correlation.powi(apart) + offset + misfit * CORRELATION.powi(apart)
        });
        if let Some(matched) = &matched {
            let mut add = |of: &dyn Fn(usize) -> f64, weight: f64| {
                let v = DVector::from_fn(n, |i, _| of(block[i].1));
                covariance.ger(weight, &v, &v, 1.0);
            };
            let at = |series: &[Vec<f64>], f: usize| series[c].get(f).copied().unwrap_or(0.0);
            // A viscosity at the edge of the references' is judged by less of them than one in their middle.
            let edge = more / (1.0 + 1.0 / references as f64);
            for scatter in &matched.scatter {
                add(&|f| at(scatter, f), 1.5 * edge / (references.max(2) - 1) as f64);
            }
            let frames = record.frames() as f64;
            add(&|f| at(&matched.mean, f), 0.15 * 0.15);
            add(&|f| at(&matched.mean, f) * f as f64 / frames, 0.15 * 0.15);
            // A shift of rbar by 3 ms.
            let slope = |f: usize| at(&matched.mean, f + 1) - at(&matched.mean, f.saturating_sub(1));
            add(&slope, (0.003 / (2.0 * record.interval_s)).powi(2));
        }
        whiten.push(whitening(&covariance, record, c)?);
        covariances.push(covariance);
    }
    Ok(Ready {
        record: record.clone(),
        covariance: covariances,
        index,
        measured: DVector::from_vec(measured),
        rbar: matched.map(|matched| matched.mean),
        whiten,
    })
}

/// Returns the inverse of the lower Cholesky factor of the covariance of one channel.
pub(super) fn whitening(
    covariance: &DMatrix<f64>,
    record: &Record,
    channel: usize,
) -> Result<DMatrix<f64>, ProblemError> {
    let n = covariance.nrows();
    let factor = covariance.clone().cholesky();
    let inverse = factor.and_then(|factor| factor.l().solve_lower_triangular(&DMatrix::identity(n, n)));
    inverse.ok_or_else(|| ProblemError::Covariance {
        recording: record.name.clone(),
        channel: record.channels[channel].quantity.words(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_residual_swings_as_fast_as_the_slosh_and_stays_where_that_has_not_begun() {
        const START: usize = 20;
        let slosh = |pace: f64| -> Vec<f64> {
            let at = |f: usize| if f < START { 0.5 } else { 0.5 + (pace * (f - START) as f64).sin() };
            (0..130).map(at).collect()
        };
        let slow = slosh(0.2);
        assert_eq!(followed(&slow, START, 1.0), slow);
        for stretch in [0.9, 0.97, 1.05] {
            let (found, wanted) = (followed(&slow, START, stretch), slosh(0.2 * stretch));
            // What lies behind the end of the references stays at their last value.
            let seen = START + ((130 - START) as f64 / stretch.max(1.0)) as usize - 1;
            let off = (0..seen).map(|f| (found[f] - wanted[f]).abs()).fold(0.0, f64::max);
            let kept = (0..seen).map(|f| (slow[f] - wanted[f]).abs()).fold(0.0, f64::max);
            assert!(off < 0.006 && kept > 0.5, "{stretch}: {off}, and {kept} unchanged");
            assert_eq!(found[..START], slow[..START]);
        }
    }
}
