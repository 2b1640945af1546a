//! Sums over frames, and the residual statistics of a liquid's oscillator.

use crate::math::ln;
use serde::{Deserialize, Serialize};

/// Least variance of a reading, m2: a tenth of a millimetre of bias is in each, and a perfect profile does not count
/// for infinitely much.
const LEAST_M2: f64 = 1e-8;

/// A_r^2: the wave that even a liquid at rest is taken to have, m2.
const REST_M2: f64 = 1e-6;

/// Most that one profile may speak against a liquid, in squared residuals: a hand before the glass says nothing of it.
const MOST: f64 = 400.0;

/// Residual statistics of a liquid's oscillator on recordings of that liquid that it was not fitted to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// a: residual over the height of the wave.
    pub scale: f64,
    /// s: scatter of ln kappa from recording to recording, where kappa is the residual over what `scale` says.
    pub scatter: f64,
    /// g: independent numbers that one profile is worth. Errors of one slosh go together.
    pub numbers: f64,
}

/// Residual of one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameResidual {
    /// s - f, m.
    pub residual_m: f64,
    /// Variance of s itself, m2.
    pub noise_m2: f64,
    /// Mean of A^2 over the last second, m2.
    pub wave_m2: f64,
}

/// The sums of one liquid.
///
/// ```
/// use meniscus::identify::{Calibration, Evidence, FrameResidual};
///
/// let usual = Calibration { scale: 0.1, scatter: 0.2, numbers: 0.5 };
/// let due_m2 = usual.variance_m2(&FrameResidual { residual_m: 0.0, noise_m2: 1e-8, wave_m2: 9e-6 });
/// assert!((due_m2 - 1.1e-7).abs() < 1e-12);
///
/// // Residuals of the expected size are more likely under a factor of one than under a factor of e.
/// let mut evidence = Evidence::default();
/// (0..60).for_each(|_| evidence.add(due_m2, due_m2));
/// assert!(evidence.ln_likelihood(0.5, 0.0) > evidence.ln_likelihood(0.5, 1.0));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Evidence {
    /// Profiles that counted.
    pub profiles: u32,
    /// Sum of q.
    pub square: f64,
    /// Sum of ln S.
    pub log: f64,
}

impl Calibration {
    /// S, m2.
    #[must_use]
    pub fn variance_m2(&self, residual: &FrameResidual) -> f64 {
        residual.noise_m2.max(LEAST_M2) + self.scale * self.scale * (REST_M2 + residual.wave_m2)
    }
}

impl Evidence {
    /// Adds a residual whose square was `residual_m2`, where `variance_m2` was due.
    pub fn add(&mut self, residual_m2: f64, variance_m2: f64) {
        let square = residual_m2 / variance_m2;
        self.profiles = self.profiles.saturating_add(1);
        // What is no number is an oscillator that has run away.
        self.square += if square < MOST { square } else { MOST };
        self.log += ln(variance_m2);
    }

    /// ln of the likelihood of all profiles, if misses are kappa times what is due, up to a constant that all liquids
    /// share: `-g/2 sum (ln S + 2 ln kappa + q/kappa^2)`.
    #[must_use]
    pub fn ln_likelihood(&self, numbers: f64, ln_kappa: f64) -> f64 {
        let profiles = f64::from(self.profiles);
        let shrunk = self.square * crate::math::exp(-2.0 * ln_kappa);
        -0.5 * numbers * (self.log + 2.0 * profiles * ln_kappa + shrunk)
    }
}
