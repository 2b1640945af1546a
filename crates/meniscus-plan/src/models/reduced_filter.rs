//! Kalman filter of the reduced model: profiles and the robot's motion to heights and rates of the modes.
//!
//! ```text
//! x- = f(x, u)                P- = A P A^T + Q                    f: four steps of the reduced model, A about rest
//! K  = P- C^T (C P- C^T + R)^-1     x = x- + K (z - h(x-))        C = cos theta for every height, 0 for every rate
//! ```
//! (Kalman 1960.) Along the wall all radial modes have one shape, so their sum is what a profile tells; the mean of the 21
//! residuals weighted by that shape is all of it. Second-order waves are predicted and not corrected.

use super::Watcher;
use super::reduced::{LINEAR, Linear, ReducedLiquid, ReducedLiquidState, linear, set_linear};
use meniscus::reduced::{RADIAL, ReducedState};
use meniscus::surface::{POINTS, SurfaceProfile, profile_abscissa};
use nalgebra::SVector;

/// Standard deviation of each mode's rate that the model misses in a frame, m/s: 8 % of what 1.5 m/s2 adds to the first, more of the
/// short waves.
const RATE_ERROR_M_S: [f64; RADIAL] = [3e-3, 7e-4, 5e-4];

/// Part of a profile's error that its points share, m: level, tilt and bow of the camera's view.
const SHARED_M: f64 = 1e-4;

/// The filter of a reduced liquid.
#[derive(Clone, Debug)]
pub struct ReducedWatcher {
    state: ReducedState,
    covariance: Linear,
}

impl Default for ReducedWatcher {
    /// A liquid at rest.
    fn default() -> Self {
        Self { state: ReducedState::default(), covariance: Linear::zeros() }
    }
}

impl Watcher<ReducedLiquid> for ReducedWatcher {
    fn watch(
        &mut self,
        model: &ReducedLiquid,
        profile: &SurfaceProfile,
        input: f64,
        _: f64,
    ) -> ReducedLiquidState {
        model.frame(&mut self.state, input);
        self.covariance = model.transition * self.covariance * model.transition.transpose();
        for (mode, error) in RATE_ERROR_M_S.into_iter().enumerate() {
            self.covariance[(RADIAL + mode, RADIAL + mode)] += error * error;
        }
        // Least squares of the residuals on cos theta and a level, which nobody asks for.
        let (mut weight, mut square, mut product, mut level, mut sum) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let mut noise = 0.0;
        let fill_m = model.model.glass.depth_m;
        for i in (0..POINTS).filter(|i| profile.valid[*i]) {
            let s = profile_abscissa(i);
            let expected = fill_m + model.height_m(&self.state, input, s);
            let residual = f64::from(profile.height_m[i]) - expected;
            weight += 1.0;
            square += s * s;
            product += s * residual;
            level += residual;
            sum += s;
            noise += f64::from(profile.variance_m2[i]);
        }
        let spread = square - sum * sum / f64::max(weight, 1.0);
        if weight >= 7.0 && spread > 0.5 {
            let slope = (product - sum * level / weight) / spread;
            let variance = noise / weight / spread + SHARED_M * SHARED_M;
            self.correct(slope, variance);
        }
        ReducedLiquidState { modes: self.state, covariance: self.covariance }
    }
}

impl ReducedWatcher {
    /// Corrects the modes by what their sum was off, `slope`, of this variance (m, m2).
    fn correct(&mut self, slope: f64, variance: f64) {
        let c = SVector::<f64, LINEAR>::from_fn(|i, _| if i < RADIAL { 1.0 } else { 0.0 });
        let shared = self.covariance * c;
        let gain = shared / (c.dot(&shared) + variance);
        let corrected = linear(&self.state) + gain * slope;
        set_linear(&mut self.state, &corrected);
        self.covariance -= gain * shared.transpose();
    }
}
