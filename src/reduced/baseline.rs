//! Calibration of the reduced model: offsets and factors of its modes, and its second order.

use super::modes::RADIAL;

/// Calibration of the plain model on reference recordings of a known liquid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Baseline {
    /// Relative offsets of the frequencies of the modes (1,n).
    pub frequency: [f64; RADIAL],
    /// Factors on the damping of the modes (1,n).
    pub damping: [f64; RADIAL],
    /// Factors on the forcing of the modes (1,n).
    pub lever: [f64; RADIAL],
    /// Softening kappa: `w = w1 (1 - kappa A^2/R^2)` at amplitude A (Bauerlein and Avila 2021).
    pub detuning: f64,
    /// Coefficients p and q of the second-order waves (0,1) and (2,1): their forcing is `(p v1^2 + q w1^2 a1^2)/R`. `None`
    /// takes those of an inviscid standing wave: 0.62 and -0.02, 0.80 and 0.26 in deep liquid.
    pub drive: Option<[[f64; 2]; 2]>,
    /// Share of the contact line that a sticking wall holds: 1 holds it, 0 lets it slide, see `finite_layer`.
    pub held_line: f64,
}

impl Default for Baseline {
    /// Linear theory, and the second order of an inviscid standing wave.
    fn default() -> Self {
        Self {
            frequency: [0.0; RADIAL],
            damping: [1.0; RADIAL],
            lever: [1.0; RADIAL],
            detuning: 0.0,
            drive: None,
            held_line: 1.0,
        }
    }
}
