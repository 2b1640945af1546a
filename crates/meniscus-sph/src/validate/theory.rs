//! Slosh in an upright cylinder without viscosity, and the decay that a thin wall layer gives it.
//!
//! ```text
//! potential   phi = J1(k r) cos(azimuth) cosh(k z),    k R = xi, the zeros of J1'
//! frequency   w^2 = g k tanh(k h)                                        (Lamb 1932, article 257)
//! decay       (1/2R) sqrt(nu w/2) [ (1 + xi^-2)/(1 - xi^-2) + 2 k R (1 - h/R)/sinh(2 k h) ] + 2 nu k^2
//! ```
//! The decay is the work of the boundary layers of wall and bottom (Case and Parkinson 1957) and of
//! the bulk, for a contact line that slides freely. It holds while the layer is thin.

use meniscus::units::GRAVITY_M_S2;
use meniscus_data::recording::Glass;
use std::f64::consts::TAU;

/// The first two zeros of J1'.
const XI: [f64; 2] = [1.841_183_781_340_659, 5.331_442_773_525_033];

/// A damped oscillation `A e^(-decay t) cos(2 pi hz t + phase)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tone {
    /// Frequency, Hz.
    pub hz: f64,
    /// Decay, 1/s.
    pub decay: f64,
}

/// An antisymmetric mode of one azimuthal period without viscosity.
#[derive(Clone, Copy, Debug)]
pub struct Mode {
    glass: Glass,
    xi: f64,
}

impl Mode {
    /// The first mode of `glass`.
    #[must_use]
    pub fn first(glass: Glass) -> Self {
        Self { glass, xi: XI[0] }
    }

    /// The second mode of `glass`.
    #[must_use]
    pub fn second(glass: Glass) -> Self {
        Self { glass, xi: XI[1] }
    }

    /// Wave number, 1/m.
    #[must_use]
    pub fn wave_number(&self) -> f64 {
        self.xi / self.glass.radius_m
    }

    /// Frequency, Hz.
    #[must_use]
    pub fn hz(&self) -> f64 {
        let k = self.wave_number();
        (GRAVITY_M_S2 * k * (k * self.glass.fill_m).tanh()).sqrt() / TAU
    }

    /// Decay by boundary layers and bulk in a liquid of kinematic viscosity `nu` (m2/s), 1/s.
    #[must_use]
    pub fn layer_decay(&self, nu: f64) -> f64 {
        let (r, h, k) = (self.glass.radius_m, self.glass.fill_m, self.wave_number());
        let side = (1.0 + self.xi.powi(-2)) / (1.0 - self.xi.powi(-2));
        let bottom = 2.0 * k * r * (1.0 - h / r) / (2.0 * k * h).sinh();
        (nu * TAU * self.hz() / 2.0).sqrt() / (2.0 * r) * (side + bottom) + 2.0 * nu * k * k
    }

    /// Gradient of the potential at a place, scaled to a vertical part of 1 at the top of the wall.
    #[must_use]
    pub fn velocity(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let k = self.wave_number();
        let r = x.hypot(y).max(1e-9);
        let (cos, sin) = (x / r, y / r);
        let over = libm::j1(k * r) / (k * r);
        let slope = libm::j0(k * r) - over;
        let scale = 1.0 / (libm::j1(self.xi) * (k * self.glass.fill_m).sinh());
        let (radial, around) = (slope * cos * (k * z).cosh(), -over * sin * (k * z).cosh());
        let up = libm::j1(k * r) * cos * (k * z).sinh();
        [scale * (radial * cos - around * sin), scale * (radial * sin + around * cos), scale * up]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_data::glass::WallShape;

    #[test]
    fn the_modes_have_their_known_frequencies_and_touch_no_wall() {
        let glass = Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11, wall: WallShape::UPRIGHT };
        let (first, second) = (Mode::first(glass), Mode::second(glass));
        assert!((first.hz() - 3.613).abs() < 1e-3, "{} Hz", first.hz());
        assert!((first.layer_decay(0.950 / 1261.0) - 6.59).abs() < 0.01);
        assert!((second.hz() / first.hz() - (XI[1] / XI[0]).sqrt()).abs() < 2e-3);
        for mode in [first, second] {
            let [x, y, z] = mode.velocity([0.6 * 0.035, 0.8 * 0.035, 0.05]);
            assert!((0.6 * x + 0.8 * y).abs() < 1e-9 && z.abs() > 1e-3);
            assert!((mode.velocity([0.035, 0.0, 0.07])[2] - 1.0).abs() < 1e-9);
        }
    }
}
