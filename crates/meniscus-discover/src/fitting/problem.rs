//! Least-squares problem of a discovery: recordings, prior of the baseline, covariance of its error.
//!
//! ```text
//! y = f(theta, effects) + rbar + e,     e ~ N(0, C),     theta ~ N(prior)
//! C = noise (1 + 1/G) + sum_g d_g d_g^T/(G - 1) + variants of rbar + offsets
//! ```
//! `rbar` is the mean and `d_g` the scatter of the references' residuals in the same motion; the variants are rbar
//! itself, its slope in time and its ramp over the recording, because a liquid with an effect does not follow the
//! references exactly. Where it swings faster or slower, rbar goes with it ([`Problem::expected_m`]). Offsets (level, slope,
//! bow, position of the glass) are integrated out with the variance [`Calibration::offset_m2`].
//! After a correction, C gains a process of a share of that correction, channel by channel, with a correlation time of ten frames:
//! the formula of an effect is not exact either ([`Problem::with_formula_error`]).
//! Residuals are whitened by the exact Cholesky factor of C, recording by recording and channel by channel. Channels
//! are treated as independent.

use super::covariance::{CORRELATION, Ready, prepare, whitening};
use super::error::ProblemError;
use super::fit_cache::{CacheKey, FitCache};
use crate::baseline::calibrate::Calibration;
use crate::baseline::predict::{Difference, RADIUS, SHARED, model_with, predict, predict_by, reduced_model};
use crate::recordings::record::{Quantity, Record};
use crate::recordings::stated::Known;
use meniscus::reduced::effects::Active;
use meniscus::units::FRAME_INTERVAL_S;
use nalgebra::DVector;
use std::sync::Arc;

/// Recordings with a prior and covariances.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Glass and liquid as stated.
    pub known: Known,
    /// Mean of the prior: shared numbers, then a lag for each recording.
    pub mean: Vec<f64>,
    /// Its standard deviations.
    pub deviation: Vec<f64>,
    pub(super) ready: Vec<Ready>,
    /// Frequency at which the first mode of the mean baseline swings, 1/s.
    frequency: f64,
    /// Cache of fits, and the digest of all of the above.
    cache: Option<(Arc<FitCache>, u64)>,
}

impl Problem {
    /// Compares `records` with `calibration`; `noise` is a factor on the noise of the rest frames.
    ///
    /// # Errors
    /// [`ProblemError`], when a covariance cannot be factored or too little was measured.
    pub fn new(
        records: &[Record],
        known: Known,
        calibration: &Calibration,
        noise: f64,
    ) -> Result<Self, ProblemError> {
        let (mut mean, mut deviation) = (calibration.mean.to_vec(), calibration.deviation.to_vec());
        // The radius was surveyed glass by glass: what references show of theirs bounds no other one.
        deviation[RADIUS] = deviation[RADIUS].max(known.radius_error_m);
        let mut ready = Vec::new();
        for record in records {
            mean.push(calibration.lag_s);
            deviation.push(calibration.lag_deviation_s);
            ready.push(prepare(record, records.len(), calibration, noise)?);
        }
        let interval_s = records.first().map_or(FRAME_INTERVAL_S, |record| record.interval_s);
        let frequency = reduced_model(&known, &mean, &[], interval_s).swinging_frequency();
        Ok(Self { known, mean, deviation, ready, frequency, cache: None })
    }

    /// Returns the same problem with its fits in `cache`, if there is one.
    #[must_use]
    pub fn with_cache(mut self, cache: &Option<Arc<FitCache>>) -> Self {
        self.cache = cache.as_ref().map(|cache| (cache.clone(), self.digest()));
        self
    }

    /// Returns the cache of fits and this problem's digest.
    #[must_use]
    pub fn cache(&self) -> Option<(&FitCache, u64)> {
        self.cache.as_ref().map(|(cache, mine)| (cache.as_ref(), *mine))
    }

    /// Returns a digest of everything that a fit depends on.
    fn digest(&self) -> u64 {
        let mut key = CacheKey::new();
        let Known { radius_m, fill_m, density_kg_m3, viscosity_pa_s, motion_share: [tilt, lift], .. } =
            self.known;
        key.add([radius_m, fill_m, density_kg_m3, viscosity_pa_s, tilt, lift]);
        key.add(self.mean.iter().chain(&self.deviation));
        for ready in &self.ready {
            let drive = &ready.record.drive;
            key.add([ready.record.interval_s, drive.rate_hz]);
            key.add(drive.along_m_s2.iter().chain(&drive.tilted_m_s2).flatten());
            key.add(drive.lift_m_s2.iter().chain(&drive.place_m));
            key.add(ready.index.iter().flat_map(|(c, f)| [*c as f64, *f as f64]));
            key.add(ready.measured.iter());
            key.add(ready.rbar.iter().flatten().flatten());
            ready.whiten.iter().for_each(|whiten| key.add(whiten.iter()));
        }
        key.finish()
    }

    /// Returns the recordings.
    pub fn records(&self) -> impl Iterator<Item = &Record> {
        self.ready.iter().map(|ready| &ready.record)
    }

    /// Returns how many numbers were measured.
    #[must_use]
    pub fn count(&self) -> usize {
        self.ready.iter().map(|ready| ready.index.len()).sum()
    }

    /// Returns how many numbers were measured, recording by recording.
    #[must_use]
    pub fn counts(&self) -> Vec<usize> {
        self.ready.iter().map(|ready| ready.index.len()).collect()
    }

    /// Returns recording, channel and frame of each whitened number.
    #[must_use]
    pub fn places(&self) -> Vec<(usize, usize, usize)> {
        let of_recording =
            |(r, ready): (usize, &Ready)| ready.index.iter().map(move |(c, f)| (r, *c, *f)).collect();
        self.ready.iter().enumerate().map(of_recording).collect::<Vec<Vec<_>>>().concat()
    }

    /// Returns the residual of recording `which` before whitening, m.
    #[must_use]
    pub fn residual_m(&self, which: usize, theta: &[f64], active: &[Active]) -> Vec<f64> {
        self.residual_with_m(which, theta, Difference { active, law: None })
    }

    /// Returns the same with any difference from the plain liquid, m.
    #[must_use]
    pub fn residual_with_m(&self, which: usize, theta: &[f64], difference: Difference<'_>) -> Vec<f64> {
        let ready = &self.ready[which];
        let expected = self.expected_m(which, theta, difference);
        let one = |((c, f), y): (&(usize, usize), &f64)| y - expected[*c][*f];
        ready.index.iter().zip(ready.measured.iter()).map(one).collect()
    }

    /// Returns the expected channels of recording `which`, m: those of the model, and what the references' residual adds.
    ///
    /// The residual follows the wave. A glass that is lifted by 1 m/s2 swings 5 % faster, and after a second has gone ahead of the
    /// references by a radian; without this the model error of its bow counts twice (`docs/discovery/README.md`). The frequency of the
    /// baseline counts as well: with an effect's alone, a model without the effect would have the residual of the wrong wave.
    #[must_use]
    pub fn expected_m(&self, which: usize, theta: &[f64], difference: Difference<'_>) -> Vec<Vec<f64>> {
        let ready = &self.ready[which];
        let model = model_with(&ready.record, &self.known, theta, difference);
        let mut expected = predict_by(&model, &ready.record, &self.known, theta[SHARED + which]);
        ready.add_rbar(&mut expected, model.swinging_frequency() / self.frequency);
        expected
    }

    /// Returns the whitened residual of recording `which`.
    fn whitened(&self, which: usize, theta: &[f64], difference: Difference<'_>) -> Vec<f64> {
        let left = self.residual_with_m(which, theta, difference);
        let mut all = Vec::with_capacity(left.len());
        let mut first = 0;
        for whiten in &self.ready[which].whiten {
            let part = DVector::from_column_slice(&left[first..first + whiten.nrows()]);
            all.extend((whiten * part).iter());
            first += whiten.nrows();
        }
        all
    }

    /// Returns the whitened residuals of all recordings, then those of the prior.
    ///
    /// Their squared norm is minus twice the logarithm of the posterior, up to a constant.
    #[must_use]
    pub fn residual(&self, theta: &[f64], active: &[Active]) -> DVector<f64> {
        self.residual_with(theta, Difference { active, law: None })
    }

    /// Returns the same with any difference from the plain liquid.
    #[must_use]
    pub fn residual_with(&self, theta: &[f64], difference: Difference<'_>) -> DVector<f64> {
        let mut all: Vec<f64> = Vec::with_capacity(self.count() + theta.len());
        for which in 0..self.ready.len() {
            all.extend(self.whitened(which, theta, difference));
        }
        for ((t, m), s) in theta.iter().zip(&self.mean).zip(&self.deviation) {
            all.push((t - m) / s);
        }
        DVector::from_vec(all)
    }

    /// Returns the same problem with the model error of the formulas of `active` added to its covariances.
    ///
    /// The error is `share` of what `theta` and `active` change of the baseline's prediction.
    ///
    /// # Errors
    /// [`ProblemError`], when a covariance cannot be factored.
    pub fn with_formula_error(
        &self,
        theta: &[f64],
        active: &[Active],
        share: f64,
    ) -> Result<Self, ProblemError> {
        let mut out = self.clone();
        for (which, ready) in out.ready.iter_mut().enumerate() {
            let record = &ready.record;
            let before = predict(record, &self.known, &self.mean, self.mean[SHARED + which], &[]);
            let after = predict(record, &self.known, theta, theta[SHARED + which], active);
            let change: Vec<f64> = before
                .iter()
                .zip(&after)
                .map(|(b, a)| b.iter().zip(a).map(|(b, a)| (b - a).powi(2)).sum::<f64>() / b.len() as f64)
                .collect();
            let mut first = 0;
            for (covariance, whiten) in ready.covariance.iter_mut().zip(&mut ready.whiten) {
                let n = covariance.nrows();
                let index = &ready.index[first..first + n];
                let channel = index[0].0;
                if record.channels[channel].quantity != Quantity::Place {
                    for j in 0..n {
                        for i in 0..n {
                            let apart = index[i].1.abs_diff(index[j].1) as i32;
                            covariance[(i, j)] += share * share * change[channel] * CORRELATION.powi(apart);
                        }
                    }
                    *whiten = whitening(covariance, record, channel)?;
                }
                first += n;
            }
        }
        let cache = out.cache.take().map(|(cache, _)| cache);
        Ok(out.with_cache(&cache))
    }

    /// Returns the same problem without recording `which` and its lag.
    #[must_use]
    pub fn without(&self, which: usize) -> Self {
        let mut out = Self { cache: None, ..self.clone() };
        out.ready.remove(which);
        out.mean.remove(SHARED + which);
        out.deviation.remove(SHARED + which);
        out.with_cache(&self.cache.as_ref().map(|(cache, _)| cache.clone()))
    }

    /// Returns the squared norm of the whitened residual of recording `which`, which was predicted without it.
    ///
    /// `theta` and `difference` were fitted to [`Self::without`]; the recording's lag is taken at its prior mean.
    #[must_use]
    pub fn held_out_misfit(&self, which: usize, theta: &[f64], difference: Difference<'_>) -> f64 {
        let mut theta = theta.to_vec();
        theta.insert(SHARED + which, self.mean[SHARED + which]);
        let whitened = self.whitened(which, &theta, difference);
        whitened.iter().map(|r| r * r).sum()
    }

    /// Returns the same problem with data drawn from the model: `theta` and `active` are the truth, errors are drawn from
    /// the covariances.
    #[must_use]
    pub fn redraw(&self, theta: &[f64], active: &[Active], mut normal: impl FnMut() -> f64) -> Self {
        let mut out = Self { cache: None, ..self.clone() };
        for (which, ready) in out.ready.iter_mut().enumerate() {
            let expected = self.expected_m(which, theta, Difference { active, law: None });
            let n = ready.index.len();
            let mut error: Vec<f64> = Vec::with_capacity(n);
            for covariance in &ready.covariance {
                let z = DVector::from_fn(covariance.nrows(), |_, _| normal());
                let drawn = covariance.clone().cholesky().map_or(z.clone(), |factor| factor.l() * &z);
                error.extend(drawn.iter());
            }
            let one = |i: usize| expected[ready.index[i].0][ready.index[i].1] + error[i];
            ready.measured = DVector::from_fn(n, |i, _| one(i));
        }
        out
    }
}
