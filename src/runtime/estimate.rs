//! Estimate of a turn, beside the full field in the caller's buffer.

use super::budget::Stages;
use super::mode::Mode;
use crate::blob::{FieldGroup, KnownGroups};
use crate::latent::generic::{Audit, LATENTS};
use crate::surface::POINTS;
use crate::uncertainty::intervals::Interval;
use crate::uncertainty::latent_covariance::LatentCovariance;
use serde::{Deserialize, Serialize};

/// Result of a turn. `firmware-config/SPEC.md` has its bytes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Validity of the estimate.
    pub mode: Mode,
    /// x after the correction.
    pub latent: [f64; LATENTS],
    /// P: error covariance of x after the correction.
    pub covariance: LatentCovariance,
    /// The 21 heights of the surface, metres above the inner bottom.
    pub surface_m: [f32; POINTS],
    /// Half-widths of heights and field that hold nine times out of ten.
    pub interval: Interval,
    /// Acceleration of the glass that entered the port, m/s2.
    pub acceleration_m_s2: f32,
    /// Input of this instant that the decoder used: read off the window, or the one above.
    pub port: f32,
    /// H(x): slosh energy, joules.
    pub slosh_j: f64,
    /// s: heat since the start, joules.
    pub heat_j: f64,
    /// Change of H by the correction with the measurement, joules; not part of the laws' books.
    pub corrected_j: f64,
    /// Books of the predicting step, in units of H.
    pub audit: Audit,
    /// Whether the full field was written this turn.
    pub field_fresh: bool,
    /// Time of each stage.
    pub stages: Stages,
}

impl Estimate {
    /// Returns the estimate for a consumer: half-widths, energies and books of groups outside of `known` are not numbers.
    ///
    /// The work of the glass is known with the slosh energy that it goes into. The residual of the step stays: it is the rounding
    /// of the arithmetic.
    #[must_use]
    pub fn known_only(mut self, known: KnownGroups) -> Self {
        for (half, group) in self.interval.field.iter_mut().zip(FieldGroup::ALL) {
            if !known.contains(group) {
                *half = f32::NAN;
            }
        }
        if !known.slosh_energy() {
            (self.slosh_j, self.corrected_j, self.audit.work) = (f64::NAN, f64::NAN, f64::NAN);
        }
        if !known.heat() {
            (self.heat_j, self.audit.heat) = (f64::NAN, f64::NAN);
        }
        self
    }
}
