//! Disagreement of the estimated surface with the heights that were seen, and the scale of the intervals that follows from it.
//!
//! Conformal factors hold where the liquid moves as in the recordings that they were set on. A livelier slosh, or another liquid, has
//! larger errors, and the camera sees them. With r the measured less the estimated height and h its half-width before scaling,
//!
//! ```text
//! c   = sum_i r_i r_i' / sum_i (h_i / 1.645)^2          ' one turn before
//! rho = rho + a (c - rho)                               a = 0.3 upwards, 0.03 downwards
//! m   = sqrt(max(1, rho / theta))                       factor on the half-widths of heights, q, v, sigma, tau and forecasts
//! ```
//! The camera's noise differs from frame to frame and drops out of the mean of r r', while an error of the model lasts for several
//! frames. So m asks nothing of the variances that the camera states. theta is what rho stays below in nine of ten turns of the
//! recordings that the factors were set on, and [`ErrorFactors::LEAST_DISAGREEMENT`] at least. An adaptation of
//! conformal intervals to a shift of the data: Gibbs and Candes, Adv. Neural Inf. Process. Syst. 34 (2021) 1660.
//! The heat has books of its own, and its width stays. Of a forecast m scales what comes from the model, not the accelerations that
//! nobody planned ([`crate::uncertainty::intervals`]).

use crate::math::sqrt;
use crate::surface::{POINTS, SurfaceProfile};
use crate::uncertainty::error_factors::ErrorFactors;
use crate::uncertainty::intervals::{ENERGY, Interval};

/// Half-widths of 90 % over standard deviations of a normal distribution.
const HALF_OVER_STD: f64 = 1.645;

/// Weights a of a new turn in rho where it lies above, and where it lies below: a width grows in some turns and shrinks in some seconds.
const RATES: [f64; 2] = [0.3, 0.03];

/// Least theta of any blob, against a hostile one: errors as large as stated are a rho of one.
const LEAST_THETA: f64 = 1.0;

/// Largest c of a turn: a finger before the camera is no reason to know nothing for a minute.
const LARGEST: f64 = 100.0;

/// rho, and r of the last turn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Disagreement {
    rho: f64,
    /// r; not a number where no height was seen.
    residual_m: [f64; POINTS],
}

impl Default for Disagreement {
    fn default() -> Self {
        Self { rho: 0.0, residual_m: [f64::NAN; POINTS] }
    }
}

impl Disagreement {
    /// Takes the heights of a turn, its estimate and the half-widths before scaling. rho stays where it is not `tracking`.
    pub(crate) fn update(
        &mut self,
        seen: Option<&SurfaceProfile>,
        surface_m: &[f32; POINTS],
        half_m: &[f32; POINTS],
        tracking: bool,
    ) {
        let (mut product, mut expected, mut now) = (0.0, 0.0, [f64::NAN; POINTS]);
        if let Some(profile) = seen {
            let points = profile.valid.iter().zip(&profile.height_m).zip(surface_m).zip(half_m);
            for (((((valid, z), said), half), before), now) in points.zip(&self.residual_m).zip(&mut now) {
                if !valid {
                    continue;
                }
                *now = f64::from(*z) - f64::from(*said);
                let std = f64::from(*half) / HALF_OVER_STD;
                if before.is_finite() {
                    product += *now * before;
                    expected += std * std;
                }
            }
        }
        self.residual_m = now;
        let c = product / expected;
        if tracking && c.is_finite() {
            let c = c.min(LARGEST);
            let [up, down] = RATES;
            self.rho += (if c > self.rho { up } else { down }) * (c - self.rho);
        }
    }

    /// Returns rho.
    pub(crate) fn rho(&self) -> f64 {
        self.rho
    }

    /// Returns m of a model with `factors`.
    pub(crate) fn scale(&self, factors: &ErrorFactors) -> f64 {
        let theta = f64::from(factors.disagreement).max(LEAST_THETA);
        sqrt((self.rho / theta).max(1.0))
    }

    /// Scales the half-widths of an estimate of a model with `factors`.
    pub(crate) fn scaled(&self, factors: &ErrorFactors, mut interval: Interval) -> Interval {
        let scale = self.scale(factors);
        let field = interval.field.iter_mut().enumerate();
        let of_field = field.filter(|(group, _)| *group != ENERGY).map(|(_, half)| half);
        for half in interval.surface_m.iter_mut().chain(of_field) {
            *half = (scale * f64::from(*half)) as f32;
        }
        interval
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Micros;

    const SAID: [f32; POINTS] = [0.07; POINTS];
    const HALF: [f32; POINTS] = [1.645e-4; POINTS];

    /// Factors with theta at its least.
    fn factors() -> ErrorFactors {
        ErrorFactors { disagreement: ErrorFactors::LEAST_DISAGREEMENT, ..ErrorFactors::uncalibrated(0.1) }
    }

    fn seen(error_m: impl Fn(usize) -> f32) -> SurfaceProfile {
        SurfaceProfile {
            height_m: core::array::from_fn(|i| 0.07 + error_m(i)),
            variance_m2: [1e-8; POINTS],
            valid: [true; POINTS],
            glass_x_m: None,
            sequence: 0,
            captured: Micros(0),
        }
    }

    /// Errors that last widen the intervals by as much as they are larger; noise that alternates does not, however large.
    #[test]
    fn lasting_errors_widen_and_noise_does_not() {
        let (mut lasting, mut noisy) = (Disagreement::default(), Disagreement::default());
        for turn in 0..60 {
            let sign = if turn % 2 == 0 { 1.0 } else { -1.0 };
            lasting.update(Some(&seen(|_| 3e-4)), &SAID, &HALF, true);
            noisy.update(Some(&seen(|_| sign * 1e-3)), &SAID, &HALF, true);
        }
        assert!(
            (lasting.scale(&factors()) - sqrt(9.0 / f64::from(ErrorFactors::LEAST_DISAGREEMENT))).abs()
                < 0.02,
            "{}",
            lasting.scale(&factors())
        );
        assert_eq!(noisy.scale(&factors()), 1.0);
        let interval = Interval { surface_m: HALF, field: [1.0; 5] };
        let wide = lasting.scaled(&factors(), interval);
        assert!((f64::from(wide.surface_m[3] / HALF[3]) - lasting.scale(&factors())).abs() < 1e-5);
        assert_eq!(wide.field[ENERGY], 1.0);
        assert!(wide.field.iter().filter(|half| **half > 2.0).count() == 4);
        // Neither a draft nor a model with such errors on its own recordings widens, and a hostile theta widens no more than one of 1.
        let with = |disagreement: f32| lasting.scale(&ErrorFactors { disagreement, ..factors() });
        assert_eq!((with(f32::MAX), with(9.5)), (1.0, 1.0));
        assert_eq!((with(0.0), with(f32::NAN)), (with(1.0), with(1.0)));
    }

    /// Errors as large as stated leave the widths, and a width comes back within seconds of the last large error.
    #[test]
    fn widths_stay_where_the_model_is_right_and_come_back() {
        let mut disagreement = Disagreement::default();
        for _ in 0..60 {
            disagreement.update(Some(&seen(|_| 1e-4)), &SAID, &HALF, true);
        }
        assert_eq!(disagreement.scale(&factors()), 1.0);
        for _ in 0..10 {
            disagreement.update(Some(&seen(|_| 1e-3)), &SAID, &HALF, true);
        }
        assert!(disagreement.scale(&factors()) > 6.0);
        for _ in 0..180 {
            disagreement.update(Some(&seen(|_| 1e-4)), &SAID, &HALF, true);
        }
        assert!(disagreement.scale(&factors()) < 1.05, "{}", disagreement.scale(&factors()));
    }

    /// No height, a height that is no number, and a turn that does not track change nothing.
    #[test]
    fn what_was_not_seen_counts_nothing() {
        let mut disagreement = Disagreement::default();
        for _ in 0..5 {
            disagreement.update(Some(&seen(|_| 1e-2)), &SAID, &HALF, false);
            disagreement.update(None, &SAID, &HALF, true);
            disagreement.update(Some(&seen(|_| f32::NAN)), &SAID, &HALF, true);
            disagreement.update(Some(&seen(|_| 1e-2)), &SAID, &[0.0; POINTS], true);
        }
        assert_eq!(disagreement.scale(&factors()), 1.0);
    }
}
