//! What theory alone says of the surface when the motion of the glass is known: the linear baseline.
//!
//! Modes (1, n) of an upright circular cylinder of radius R and depth h, driven by the acceleration A
//! along x. With xi_n the zeros of J1' and k = xi / R:
//!
//! ```text
//! w^2 = g k tanh(k h)                                        a'' + 2 gamma a' + w^2 a = -w^2 b A / g
//! b = 2 R / (xi^2 - 1)                                       surface at the wall: z = h + cos(theta) sum a_n
//! gamma = (1 / 2R) sqrt(nu w / 2) [ (1 + xi^-2) / (1 - xi^-2) + 2 k R (1 - h/R) / sinh(2 k h) ] + 2 nu k^2
//! ```
//! Lamb, Hydrodynamics (1932), art. 257; damping after Case and Parkinson, J. Fluid Mech. 2 (1957) 172,
//! plus the bulk term. The damping formula is for thin boundary layers; in glycerine it is a stretch.

use super::recording::Recording;
use crate::offline::prelude::*;
use crate::surface::{POINTS, profile_abscissa};
use crate::units::{FRAME_INTERVAL_S, GRAVITY_M_S2};

/// First zeros of J1'.
const ZEROS: [f64; 3] = [1.841_183_781, 5.331_442_774, 8.536_316_366];

/// Steps of the integration in one frame interval; the fastest mode turns by 0.05 rad in one.
const SUBSTEPS: usize = 32;

/// One mode.
#[derive(Clone, Copy, Debug)]
struct Mode {
    /// w, rad/s.
    angular: f64,
    /// gamma, 1/s.
    damping: f64,
    /// b, m.
    drive_m: f64,
    /// a and a'.
    state: [f64; 2],
}

/// The profiles that theory gives for a recording's motion, from rest; frames x [`POINTS`], metres.
/// `viscosity_pa_s` is the liquid's.
#[must_use]
pub fn linear_theory(recording: &Recording, viscosity_pa_s: f64) -> Vec<f32> {
    let glass = &recording.glass;
    let nu = viscosity_pa_s / recording.provenance.density_kg_m3;
    let mut modes = ZEROS.map(|xi| mode(xi, glass.radius_m, glass.fill_m, nu));
    let mut profiles = Vec::with_capacity(recording.frames() * POINTS);
    for &acceleration in &recording.acceleration_m_s2 {
        let wall: f64 = modes.iter().map(|mode| mode.state[0]).sum();
        profiles.extend((0..POINTS).map(|point| (glass.fill_m + profile_abscissa(point) * wall) as f32));
        for mode in &mut modes {
            mode.advance(acceleration);
        }
    }
    profiles
}

/// The mode of zero `xi`.
fn mode(xi: f64, radius: f64, depth: f64, nu: f64) -> Mode {
    let k = xi / radius;
    let angular = (GRAVITY_M_S2 * k * (k * depth).tanh()).sqrt();
    let square = xi.powi(-2);
    let bottom = 2.0 * xi * (1.0 - depth / radius) / (2.0 * k * depth).sinh();
    let walls = (nu * angular / 2.0).sqrt() / (2.0 * radius) * ((1.0 + square) / (1.0 - square) + bottom);
    let drive_m = 2.0 * radius / (xi * xi - 1.0);
    Mode { angular, damping: walls + 2.0 * nu * k * k, drive_m, state: [0.0; 2] }
}

impl Mode {
    /// One frame interval under a constant acceleration (kick, drift, with the damping implicit).
    fn advance(&mut self, acceleration: f64) {
        let dt = FRAME_INTERVAL_S / SUBSTEPS as f64;
        let stiffness = self.angular * self.angular;
        for _ in 0..SUBSTEPS {
            let [a, rate] = self.state;
            let force = -stiffness * (a + self.drive_m * acceleration / GRAVITY_M_S2);
            let rate = (rate + dt * force) / (1.0 + 2.0 * dt * self.damping);
            self.state = [a + dt * rate, rate];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_mode_of_the_glass_is_where_theory_has_it() {
        let mode = mode(ZEROS[0], 0.035, 0.070, 0.0);
        let hertz = mode.angular / std::f64::consts::TAU;
        assert!((hertz - 3.613).abs() < 2e-3, "{hertz} Hz");
        assert_eq!(mode.damping, 0.0);
    }

    #[test]
    fn a_steady_acceleration_ends_in_a_slope_of_a_over_g() {
        let mut modes = ZEROS.map(|xi| mode(xi, 0.035, 0.070, 1e-3));
        for mode in &mut modes {
            (0..600).for_each(|_| mode.advance(1.0));
        }
        let wall: f64 = modes.iter().map(|mode| mode.state[0]).sum();
        // Three modes carry 93.7 % of the slope; the rest of the sum over 2 / (xi^2 - 1) is missing.
        let slope = -wall / 0.035 * GRAVITY_M_S2;
        assert!((slope - 0.937).abs() < 2e-3, "{slope}");
    }

    #[test]
    fn a_free_mode_decays_at_its_rate() {
        let mut mode = mode(ZEROS[0], 0.035, 0.070, 1e-5);
        mode.state = [1e-3, 0.0];
        let energy = |mode: &Mode| mode.state[0].powi(2) + (mode.state[1] / mode.angular).powi(2);
        let before = energy(&mode);
        (0..120).for_each(|_| mode.advance(0.0));
        let rate = (before / energy(&mode)).ln() / (2.0 * 120.0 * FRAME_INTERVAL_S);
        assert!((rate / mode.damping - 1.0).abs() < 0.05, "{rate} against {}", mode.damping);
    }
}
