//! Fit of the baseline to a group of references.

use super::error::ProblemError;
use super::fit::fit;
use super::fit_cache::FitCache;
use super::problem::Problem;
use crate::baseline::calibrate::{Calibration, LAG_S};
use crate::baseline::group::Group;
use crate::baseline::predict::{SHARED, predict};
use crate::recordings::record::{Channel, Record};
use crate::recordings::split::Split;
use crate::recordings::stated::Known;
use std::sync::Arc;

impl Group {
    /// Fits the baseline alone to `records`; with `own_clocks_s`, each has a clock of its own with this standard
    /// deviation.
    ///
    /// # Errors
    /// [`ProblemError`], when they cannot be fitted.
    pub fn new(known: Known, records: Vec<Record>, own_clocks_s: Option<f64>) -> Result<Self, ProblemError> {
        Self::cached(known, records, own_clocks_s, &None)
    }

    /// Fits the same with the fit in `cache`.
    ///
    /// # Errors
    /// [`ProblemError`], when they cannot be fitted.
    pub fn cached(
        known: Known,
        records: Vec<Record>,
        own_clocks_s: Option<f64>,
        cache: &Option<Arc<FitCache>>,
    ) -> Result<Self, ProblemError> {
        let blind = Calibration::blind(&records, own_clocks_s.unwrap_or(LAG_S));
        let problem = Problem::new(&records, known, &blind, 1.0)?.with_cache(cache);
        let theta = fit(&problem, &problem.mean, &[], &[]).theta;
        let residuals_of = |(which, record): (usize, &Record)| {
            residuals(record, &predict(record, &known, &theta, theta[SHARED + which], &[]))
        };
        let residual_m = records.iter().enumerate().map(residuals_of).collect();
        let split = Split::of(&records);
        Ok(Self { known, records, split, theta, residual_m })
    }
}

/// Returns measured less expected values, m; zero where nothing was measured.
fn residuals(record: &Record, expected: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let series = |channel: &Channel, expected: &Vec<f64>| {
        channel.value.iter().zip(expected).map(|(y, e)| y.map_or(0.0, |y| y - e)).collect()
    };
    record.channels.iter().zip(expected).map(|(c, e)| series(c, e)).collect()
}
