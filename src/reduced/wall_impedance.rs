//! Impedance of the layer at a wall, on which the liquid may slip and which may be of a viscoelastic liquid.
//!
//! Stokes's layer has the complex depth `delta/(1 + i)`, `delta = sqrt(2 nu/w)`, and passes the stress
//! `(1 + i) mu U/delta` on to the wall. The real part damps and the imaginary part lowers the frequency. With a Maxwell stress of
//! modulus G and time lambda beside the viscous one the viscosity is complex, and a slip by the length b divides what passes
//! (Navier 1823; Bird, Armstrong and Hassager 1987):
//! ```text
//! mu (1 + zeta),   zeta = (G lambda/mu)/(1 + i w lambda),   r = sqrt(1 + zeta)
//! impedance over mu/delta   (1 + i) r/(1 + (1 + i) s/r),    s = b/delta
//! ```
//! Without relaxation `damping (1 + 2 s)/(1 + 2 s + 2 s^2)`, `lowering 1/(1 + 2 s + 2 s^2)`. An elastic layer lowers less, and may
//! raise the frequency. All of it is for shear waves that fade before they have crossed the glass.

use crate::math::sqrt;

/// Maxwell stress: a modulus that relaxes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Maxwell {
    /// Modulus G, Pa; 0 is none.
    pub modulus_pa: f64,
    /// Relaxation time lambda, s.
    pub time_s: f64,
}

impl Maxwell {
    /// Returns real part and imaginary part of zeta beside a viscosity (Pa s), at the frequency `w` (1/s).
    pub(super) fn over(&self, viscosity_pa_s: f64, w: f64) -> [f64; 2] {
        if self.modulus_pa <= 0.0 || viscosity_pa_s <= 0.0 {
            return [0.0; 2];
        }
        let x = w * self.time_s;
        let real = self.modulus_pa * self.time_s / viscosity_pa_s / (1.0 + x * x);
        [real, -x * real]
    }
}

/// Layer at a wall, without dimension.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallLayer {
    /// Slip length over the layer's depth.
    pub(super) slip: f64,
    /// Real part and imaginary part of zeta.
    pub(super) relaxing: [f64; 2],
}

/// Parts of an impedance over `mu/delta`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Impedance {
    /// Part in phase with the rate, which damps.
    pub(super) damping: f64,
    /// Part that lowers the frequency.
    pub(super) lowering: f64,
}

/// Root `r = a - i b` of `1 + zeta`, and its size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Root {
    pub(super) a: f64,
    pub(super) b: f64,
    pub(super) size: f64,
}

impl WallLayer {
    /// Returns r: the layer is |r| times as deep as without relaxation. zeta is below the real axis.
    pub(super) fn root(&self) -> Root {
        let [real, imaginary] = [1.0 + self.relaxing[0], self.relaxing[1]];
        let square = sqrt(real * real + imaginary * imaginary);
        Root { a: sqrt(0.5 * (square + real)), b: sqrt((0.5 * (square - real)).max(0.0)), size: sqrt(square) }
    }

    /// Returns the impedance.
    pub(super) fn impedance(&self) -> Impedance {
        let Root { a, b, size } = self.root();
        // (1 + i) r over 1 + (1 + i) s/r, where 1/r = (a + i b)/|r|^2.
        let (top, turned) = (a + b, a - b);
        let slip = self.slip / (size * size);
        let (below, across) = (1.0 + slip * (a - b), slip * (a + b));
        let square = below * below + across * across;
        Impedance {
            damping: (top * below + turned * across) / square,
            lowering: (turned * below - top * across) / square,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Complex;

    #[test]
    fn slip_and_relaxation_have_the_complex_impedance_of_the_layer() {
        let one_i = Complex::new(1.0, 1.0);
        for slip in [0.0, 0.2, 0.65, 1.3, 3.0] {
            for (strength, x) in [(0.0, 1.0), (0.5, 0.3), (4.0, 1.3), (50.0, 8.0)] {
                let zeta = Complex::new(strength, 0.0) / Complex::new(1.0, x);
                let root = (zeta + 1.0).sqrt();
                let wanted = one_i * root / (one_i * slip / root + 1.0);
                let found = WallLayer { slip, relaxing: [zeta.re, zeta.im] }.impedance();
                assert!((found.damping - wanted.re).abs() < 1e-12, "damping at {slip} and {zeta}");
                assert!((found.lowering - wanted.im).abs() < 1e-12, "lowering at {slip} and {zeta}");
            }
        }
    }

    #[test]
    fn a_stress_that_relaxes_at_once_is_a_viscosity_and_none_is_none() {
        assert_eq!(Maxwell::default().over(0.2, 20.0), [0.0; 2]);
        let fast = Maxwell { modulus_pa: 1e6, time_s: 1e-6 };
        let [real, imaginary] = fast.over(0.5, 20.0);
        assert!((real - 2.0).abs() < 1e-6 && imaginary.abs() < 1e-3);
        let found = WallLayer { slip: 0.0, relaxing: [real, 0.0] }.impedance();
        assert!((found.damping * found.damping - 3.0).abs() < 1e-6, "{found:?}");
        assert!(WallLayer { slip: 0.0, relaxing: [0.1, -9.0] }.impedance().lowering < 0.4);
    }
}
