//! What is fitted: recordings, what the baseline may be, and the covariance of what it cannot be.
//!
//! ```text
//! y = f(theta, effects) + rbar + e,     e ~ N(0, C),     theta ~ N(prior)
//! C = noise (1 + 1/G) + sum_g d_g d_g^T/(G - 1) + variants of rbar + offsets
//! ```
//! `rbar` is the mean and `d_g` the scatter of what the references leave in the same motion; the variants
//! are rbar itself, its slope in time and its ramp over the recording, because a liquid with an effect is
//! not quite where the references are. Offsets (level, slope, bow, place of the glass) are integrated out,
//! as large as [`Calibration::offset_m2`] says.
//! Once a correction is made, C gains a process of a part of that correction, channel by channel, with a
//! memory of ten frames: an effect's formula is not exact either, and the more it changes the less what is
//! left may be held against it ([`Problem::trusting`]). A quarter for what happens in the liquid, a twentieth
//! for how it is looked at and moved, which is geometry.
//! Residuals are whitened by the exact Cholesky factor of C, recording by recording and channel by channel:
//! what is left of one channel says nothing of another's.

use super::calibrate::Calibration;
use super::covariance::{MEMORY, Ready, prepare, whitening};
use super::decision_rules::DecisionRules;
use super::predict::{Known, SHARED, predict};
use super::record::{Quantity, Record};
use crate::fit_cache::{Kept, Name};
use meniscus::reduced::effects::Active;
use nalgebra::DVector;
use std::sync::Arc;

/// Recordings with a prior and covariances.
#[derive(Clone, Debug)]
pub struct Problem {
    /// What is known of glass and liquid.
    pub known: Known,
    /// Mean of the prior: shared numbers, then a lag for each recording.
    pub mean: Vec<f64>,
    /// Its standard deviations.
    pub deviation: Vec<f64>,
    pub(super) ready: Vec<Ready>,
    /// Where fits are kept, and the digest of all of the above.
    kept: Option<(Arc<Kept>, u64)>,
}

impl Problem {
    /// Puts `records` against `calibration`; `noise` is a factor on the noise that rest frames show.
    ///
    /// # Errors
    /// In words, when a covariance cannot be factored or nothing was seen.
    pub fn new(
        records: &[Record],
        known: Known,
        calibration: &Calibration,
        noise: f64,
    ) -> Result<Self, String> {
        let (mut mean, mut deviation) = (calibration.mean.to_vec(), calibration.deviation.to_vec());
        let mut ready = Vec::new();
        for record in records {
            mean.push(calibration.lag_s);
            deviation.push(calibration.lag_deviation_s);
            ready.push(prepare(record, records.len(), calibration, noise)?);
        }
        Ok(Self { known, mean, deviation, ready, kept: None })
    }

    /// The same problem with its fits in `kept`, if there is one.
    #[must_use]
    pub fn keeping(mut self, kept: &Option<Arc<Kept>>) -> Self {
        self.kept = kept.as_ref().map(|kept| (kept.clone(), self.digest()));
        self
    }

    /// Where fits are kept, and this problem's digest.
    #[must_use]
    pub fn kept(&self) -> Option<(&Kept, u64)> {
        self.kept.as_ref().map(|(kept, mine)| (kept.as_ref(), *mine))
    }

    /// A digest of everything that a fit depends on.
    fn digest(&self) -> u64 {
        let mut name = Name::new();
        let Known { radius_m, fill_m, density_kg_m3, viscosity_pa_s, told: [tilt, lift] } = self.known;
        name.add([radius_m, fill_m, density_kg_m3, viscosity_pa_s, tilt, lift]);
        name.add(self.mean.iter().chain(&self.deviation));
        for ready in &self.ready {
            let drive = &ready.record.drive;
            name.add([ready.record.interval_s, drive.rate_hz]);
            name.add(drive.along_m_s2.iter().chain(&drive.tilted_m_s2).flatten());
            name.add(drive.lift_m_s2.iter().chain(&drive.place_m));
            name.add(ready.index.iter().flat_map(|(c, f)| [*c as f64, *f as f64]));
            name.add(ready.target.iter());
            ready.whiten.iter().for_each(|whiten| name.add(whiten.iter()));
        }
        name.done()
    }

    /// The recordings.
    pub fn records(&self) -> impl Iterator<Item = &Record> {
        self.ready.iter().map(|ready| &ready.record)
    }

    /// Numbers that were seen.
    #[must_use]
    pub fn count(&self) -> usize {
        self.ready.iter().map(|ready| ready.index.len()).sum()
    }

    /// Numbers that were seen, recording by recording.
    #[must_use]
    pub fn counts(&self) -> Vec<usize> {
        self.ready.iter().map(|ready| ready.index.len()).collect()
    }

    /// Where a whitened number belongs: recording, channel, frame.
    #[must_use]
    pub fn places(&self) -> Vec<(usize, usize, usize)> {
        let of = |(r, ready): (usize, &Ready)| ready.index.iter().map(move |(c, f)| (r, *c, *f)).collect();
        self.ready.iter().enumerate().map(of).collect::<Vec<Vec<_>>>().concat()
    }

    /// What is left of recording `which`, m, before whitening.
    #[must_use]
    pub fn left(&self, which: usize, theta: &[f64], active: &[Active]) -> Vec<f64> {
        let ready = &self.ready[which];
        let expected = predict(&ready.record, &self.known, theta, theta[SHARED + which], active);
        let one = |((c, f), y): (&(usize, usize), &f64)| y - expected[*c][*f];
        ready.index.iter().zip(ready.target.iter()).map(one).collect()
    }

    /// The same, whitened.
    fn whitened(&self, which: usize, theta: &[f64], active: &[Active]) -> Vec<f64> {
        let left = self.left(which, theta, active);
        let mut all = Vec::with_capacity(left.len());
        let mut first = 0;
        for whiten in &self.ready[which].whiten {
            let part = DVector::from_column_slice(&left[first..first + whiten.nrows()]);
            all.extend((whiten * part).iter());
            first += whiten.nrows();
        }
        all
    }

    /// Whitened residuals of all recordings, then those of the prior: `|.|^2` is minus twice the
    /// logarithm of the posterior but for a constant.
    #[must_use]
    pub fn residual(&self, theta: &[f64], active: &[Active]) -> DVector<f64> {
        let mut all: Vec<f64> = Vec::with_capacity(self.count() + theta.len());
        for which in 0..self.ready.len() {
            all.extend(self.whitened(which, theta, active));
        }
        for ((t, m), s) in theta.iter().zip(&self.mean).zip(&self.deviation) {
            all.push((t - m) / s);
        }
        DVector::from_vec(all)
    }

    /// The same problem where `theta` and `active` are a correction of the baseline that is trusted but for a
    /// part of what it changes.
    ///
    /// # Errors
    /// In words, when a covariance cannot be factored.
    pub fn trusting(&self, theta: &[f64], active: &[Active], rules: &DecisionRules) -> Result<Self, String> {
        let mut out = self.clone();
        let part = rules.formula_error(active);
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
                            covariance[(i, j)] += part * part * change[channel] * MEMORY.powi(apart);
                        }
                    }
                    *whiten = whitening(covariance, &record.name)?;
                }
                first += n;
            }
        }
        let kept = out.kept.take().map(|(kept, _)| kept);
        Ok(out.keeping(&kept))
    }

    /// The same problem without recording `which`, and so without its lag.
    #[must_use]
    pub fn without(&self, which: usize) -> Self {
        let mut out = Self { kept: None, ..self.clone() };
        out.ready.remove(which);
        out.mean.remove(SHARED + which);
        out.deviation.remove(SHARED + which);
        out.keeping(&self.kept.as_ref().map(|(kept, _)| kept.clone()))
    }

    /// Whitened misfit `|.|^2` of recording `which` where everything but its lag, which is taken at its mean,
    /// was learnt without it: `theta` and `active` are those of [`Self::without`].
    #[must_use]
    pub fn foretold(&self, which: usize, theta: &[f64], active: &[Active]) -> f64 {
        let mut theta = theta.to_vec();
        theta.insert(SHARED + which, self.mean[SHARED + which]);
        let whitened = self.whitened(which, &theta, active);
        whitened.iter().map(|r| r * r).sum()
    }

    /// The same problem with data drawn from the model: `theta` and `active` are the truth, errors are drawn
    /// from the covariances.
    #[must_use]
    pub fn redraw(&self, theta: &[f64], active: &[Active], mut normal: impl FnMut() -> f64) -> Self {
        let mut out = Self { kept: None, ..self.clone() };
        for (which, ready) in out.ready.iter_mut().enumerate() {
            let expected = predict(&ready.record, &self.known, theta, theta[SHARED + which], active);
            let n = ready.index.len();
            let mut error: Vec<f64> = Vec::with_capacity(n);
            for covariance in &ready.covariance {
                let z = DVector::from_fn(covariance.nrows(), |_, _| normal());
                let drawn = covariance.clone().cholesky().map_or(z.clone(), |factor| factor.l() * &z);
                error.extend(drawn.iter());
            }
            let one = |i: usize| expected[ready.index[i].0][ready.index[i].1] + error[i];
            ready.target = DVector::from_fn(n, |i, _| one(i));
        }
        out
    }
}
