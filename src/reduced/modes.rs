//! The modes of an upright cylinder without viscosity.
//!
//! ```text
//! shape       phi_mn = J_m(k r)/J_m(xi) cos m theta,   k = xi/R,   J_m'(xi) = 0      (1 at the wall)
//! area        N = pi R^2/2 (1 - m^2/xi^2)  (m >= 1),   pi R^2  (m = 0)
//! mass        m = rho N/(k tanh kh)                    so that kinetic energy is m v^2/2
//! frequency   w^2 = (g k + sigma k^3/rho) tanh kh      (Lamb 1932, articles 257 and 267)
//! forcing     m v' = ... - m k tanh(kh) b A,   b = 2R/(xi^2 - 1), the part of x in the mode (1,n)
//! ```

use crate::math::tanh;
use core::f64::consts::PI;

/// Radial modes of each azimuthal order that are kept.
pub const RADIAL: usize = 3;

/// Shapes of second-order waves: (0,n), (2,n) along cos 2 theta, (2,n) along sin 2 theta.
pub const BOUND_WAVE_SHAPES: usize = 3;

/// The first zeros of J1'.
const XI_1: [f64; RADIAL] = [1.841_183_781_340_659, 5.331_442_773_525_033, 8.536_316_366_346_286];

/// The first zeros of J0' (but for 0) and of J2'.
const XI_0: [f64; RADIAL] = [3.831_705_970_207_512, 7.015_586_669_815_619, 10.173_468_135_062_722];
const XI_2: [f64; RADIAL] = [3.054_236_928_227_14, 6.706_133_194_158_459, 9.969_467_823_087_596];

/// A glass and the liquid in it at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Inner radius R, m.
    pub radius_m: f64,
    /// Depth of the liquid h, m.
    pub depth_m: f64,
    /// Density of the liquid, kg/m3.
    pub density_kg_m3: f64,
}

/// Azimuthal order and zero of one mode; n counts from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wave {
    /// (1,n): along x or y.
    First(usize),
    /// (0,n): the same all round.
    Ring(usize),
    /// (2,n): two crests at the wall.
    Saddle(usize),
}

impl Wave {
    /// Azimuthal order m and zero xi.
    #[must_use]
    pub fn order(self) -> (i32, f64) {
        let (order, zeros, n) = match self {
            Self::First(n) => (1, &XI_1, n),
            Self::Ring(n) => (0, &XI_0, n),
            Self::Saddle(n) => (2, &XI_2, n),
        };
        (order, zeros.get(n).copied().unwrap_or(zeros[0]))
    }
}

/// One mode of a filled cylinder.
///
/// ```
/// use meniscus::reduced::{Cylinder, SloshMode, Wave};
/// use meniscus::units::GRAVITY_M_S2;
///
/// // A radius of 49 mm and a depth of 78 mm: 3.047 Hz by theory, 3.00 to 3.04 Hz measured.
/// let glass = Cylinder { radius_m: 0.049, depth_m: 0.078, density_kg_m3: 998.0 };
/// let mode = SloshMode::new(&glass, Wave::First(0));
/// let hz = mode.square(GRAVITY_M_S2).sqrt() / core::f64::consts::TAU;
/// assert!((hz - 3.047).abs() < 1e-3);
/// // A glass that moves sideways drives no wave that is the same all round.
/// assert_eq!(SloshMode::new(&glass, Wave::Ring(0)).lever_m, 0.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SloshMode {
    /// Azimuthal order m.
    pub order: i32,
    /// Zero xi.
    pub xi: f64,
    /// Wave number k, 1/m.
    pub k: f64,
    /// k tanh(kh), 1/m: frequency squared over gravity.
    pub steepness: f64,
    /// Area N, m2.
    pub area_m2: f64,
    /// Mass m, kg.
    pub mass_kg: f64,
    /// Forcing length b, m; 0 for waves that a moved glass does not drive.
    pub lever_m: f64,
}

impl SloshMode {
    /// The mode of shape `wave` in `glass`.
    #[must_use]
    pub fn new(glass: &Cylinder, wave: Wave) -> Self {
        let (order, xi) = wave.order();
        let (r, k) = (glass.radius_m, xi / glass.radius_m);
        let steepness = k * tanh(k * glass.depth_m);
        let m2 = f64::from(order * order);
        let area_m2 = if order == 0 { PI * r * r } else { 0.5 * PI * r * r * (1.0 - m2 / (xi * xi)) };
        let lever_m = if order == 1 { 2.0 * r / (xi * xi - 1.0) } else { 0.0 };
        Self { order, xi, k, steepness, area_m2, mass_kg: glass.density_kg_m3 * area_m2 / steepness, lever_m }
    }

    /// Returns whether it is the first mode (1,1).
    #[must_use]
    pub fn is_first(&self) -> bool {
        self.order == 1 && self.xi == XI_1[0]
    }

    /// Frequency squared under gravity `g` (m/s2) without surface tension, 1/s2.
    #[must_use]
    pub fn square(&self, g: f64) -> f64 {
        g * self.steepness
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "a test may take the platform's functions")]
mod tests {
    use super::*;
    use crate::math::bessel_j;
    use crate::units::GRAVITY_M_S2;

    const GLASS: Cylinder = Cylinder { radius_m: 0.049, depth_m: 0.078, density_kg_m3: 998.0 };

    #[test]
    fn the_zeros_are_zeros() {
        for (order, zeros) in [(1, &XI_1), (0, &XI_0), (2, &XI_2)] {
            for xi in zeros {
                // J_m'(x) = m J_m(x)/x - J_(m+1)(x).
                let slope = f64::from(order) * bessel_j(order, *xi) / xi - bessel_j(order + 1, *xi);
                assert!(slope.abs() < 1e-13, "J{order}'({xi}) = {slope}");
            }
        }
    }

    #[test]
    fn the_first_frequency_is_that_of_the_measured_cylinder() {
        // R = 49 mm, h = 78 mm: 3.047 Hz by theory, 3.00 to 3.04 measured.
        let mode = SloshMode::new(&GLASS, Wave::First(0));
        let hz = mode.square(GRAVITY_M_S2).sqrt() / (2.0 * PI);
        assert!((hz - 3.047).abs() < 1e-3, "{hz} Hz");
        assert!((SloshMode::new(&GLASS, Wave::Ring(0)).lever_m).abs() < 1e-300);
    }

    #[test]
    fn area_and_lever_are_the_integrals_that_they_stand_for() {
        for n in 0..RADIAL {
            let mode = SloshMode::new(&GLASS, Wave::First(n));
            let (rings, r_m) = (4000, GLASS.radius_m);
            let (mut square, mut along) = (0.0, 0.0);
            for i in 0..rings {
                let r = r_m * (f64::from(i) + 0.5) / f64::from(rings);
                let shape = bessel_j(1, mode.k * r) / bessel_j(1, mode.xi);
                // int cos^2 = pi; dA = r dr.
                square += PI * shape * shape * r * r_m / f64::from(rings);
                along += PI * r * shape * r * r_m / f64::from(rings);
            }
            assert!((square / mode.area_m2 - 1.0).abs() < 1e-5, "area of {n}");
            assert!((along / square / mode.lever_m - 1.0).abs() < 1e-4, "lever of {n}");
        }
    }
}
