//! One recording with the covariance of what the baseline cannot be, channel by channel.

use super::calibrate::Calibration;
use super::record::Record;
use nalgebra::{DMatrix, DVector};

/// Memory from frame to frame of what a formula is off by.
pub(super) const MEMORY: f64 = 0.9;

/// One recording, ready to be compared.
#[derive(Clone, Debug)]
pub(super) struct Ready {
    pub(super) record: Record,
    /// The covariance C of each channel, m2, in the order of the index.
    pub(super) covariance: Vec<DMatrix<f64>>,
    /// Channel and frame of each number that was seen.
    pub(super) index: Vec<(usize, usize)>,
    /// What was measured less `rbar`, m.
    pub(super) target: DVector<f64>,
    /// Inverse of the lower Cholesky factor of each.
    pub(super) whiten: Vec<DMatrix<f64>>,
}

/// `record`, one of `beside` of the same glass, ready to be compared.
pub(super) fn prepare(
    record: &Record,
    beside: usize,
    calibration: &Calibration,
    noise: f64,
) -> Result<Ready, String> {
    let matched = calibration.matched(record);
    let mut index = Vec::new();
    let mut target = Vec::new();
    for (c, channel) in record.channels.iter().enumerate() {
        for (f, value) in channel.value.iter().enumerate() {
            if let Some(value) = value {
                index.push((c, f));
                target
                    .push(value - matched.as_ref().map_or(0.0, |m| m.mean[c].get(f).copied().unwrap_or(0.0)));
            }
        }
    }
    if index.len() < 50 {
        return Err(format!(
            "{}: only {} numbers were seen; give a longer recording",
            record.name,
            index.len()
        ));
    }
    let references = matched.as_ref().map_or(0, |m| m.scatter.len());
    let more = if references > 0 { 1.0 + 1.0 / references as f64 } else { 1.0 };
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
            white + 0.7 * s2 * model.memory.powi(apart) + offset + misfit * MEMORY.powi(apart)
        });
        if let Some(matched) = &matched {
            let mut add = |of: &dyn Fn(usize) -> f64, weight: f64| {
                let v = DVector::from_fn(n, |i, _| of(block[i].1));
                covariance.ger(weight, &v, &v, 1.0);
            };
            let at = |series: &[Vec<f64>], f: usize| series[c].get(f).copied().unwrap_or(0.0);
            for scatter in &matched.scatter {
                add(&|f| at(scatter, f), 1.5 / (references.max(2) - 1) as f64);
            }
            let frames = record.frames() as f64;
            add(&|f| at(&matched.mean, f), 0.15 * 0.15);
            add(&|f| at(&matched.mean, f) * f as f64 / frames, 0.15 * 0.15);
            // A shift of rbar by 3 ms.
            let slope = |f: usize| at(&matched.mean, f + 1) - at(&matched.mean, f.saturating_sub(1));
            add(&slope, (0.003 / (2.0 * record.interval_s)).powi(2));
        }
        whiten.push(whitening(&covariance, &record.name)?);
        covariances.push(covariance);
    }
    Ok(Ready {
        record: record.clone(),
        covariance: covariances,
        index,
        target: DVector::from_vec(target),
        whiten,
    })
}

/// Inverse of the lower Cholesky factor.
pub(super) fn whitening(covariance: &DMatrix<f64>, name: &str) -> Result<DMatrix<f64>, String> {
    let n = covariance.nrows();
    let factor = covariance
        .clone()
        .cholesky()
        .ok_or_else(|| format!("{name}: the covariance of its residuals cannot be factored"))?;
    factor
        .l()
        .solve_lower_triangular(&DMatrix::identity(n, n))
        .ok_or_else(|| format!("{name}: the covariance of its residuals is singular"))
}
