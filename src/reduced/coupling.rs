//! Coupling of the first mode to another wave: by its own square, and where the glass leans.
//!
//! The operator that takes the potential psi on the surface to its rising is `G0 + G1(eta)`, `G1 = -div(eta grad) - G0 eta G0`
//! (Craig and Sulem 1993), and `psi' = -g eta - |grad psi|^2/2 + (G0 psi)^2/2` to second order (Zakharov 1968). Between
//! the modes 1 = (1,1) and j, with `kappa = k tanh kh`, `N_j = int phi_j^2` and `x` in place of `phi_1` for a lean,
//! ```text
//! C_j = (int phi_1 grad phi_1.grad phi_j - kappa_1 kappa_j int phi_1^2 phi_j)/N_j
//! D_j = (int |grad phi_1|^2 phi_j - kappa_1^2 int phi_1^2 phi_j)/(2 N_j)
//! s_j'' + w_j^2 s_j = C_j (v1^2/kappa_1 + a1 psi1') - D_j kappa_j v1^2/kappa_1^2,      psi1' = v1'/kappa_1
//! ```
//! and a wave that nothing but gravity turns has `psi1' = -w1^2 a1/kappa_1`, so that `p = R (C - D kappa_j/kappa_1)/kappa_1` and
//! `q = -R C/kappa_1` in the letters of `bound_waves.rs`.

use super::modes::{RADIAL, Wave};

/// Integrals over the surface of a glass of radius one, where the shapes phi are one at the wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coupling {
    /// `int x grad phi_1.grad phi_j/N_j` and `int x phi_1 phi_j/N_j`.
    lean: [f64; 2],
    /// `int phi_1 grad phi_1.grad phi_j/N_j` and `int phi_1^2 phi_j/N_j`.
    own: [f64; 2],
    /// `int |grad phi_1|^2 phi_j/N_j`.
    flow: f64,
}

/// Of (0,n), then of (2,n) along cos 2 theta.
const COUPLINGS: [[Coupling; RADIAL]; 2] = [
    [
        Coupling { lean: [0.780_667, 0.141_730], own: [1.060_887, 0.144_515], flow: -0.570_988 },
        Coupling { lean: [0.158_884, 0.025_048], own: [0.056_103, 0.002_280], flow: -0.048_373 },
        Coupling { lean: [0.070_018, 0.010_665], own: [0.022_300, 0.000_431], flow: -0.020_841 },
    ],
    [
        Coupling { lean: [1.877_006, 0.432_817], own: [2.351_122, 0.504_080], flow: -0.642_311 },
        Coupling { lean: [0.132_155, 0.028_161], own: [-0.074_052, -0.003_293], flow: 0.062_888 },
        Coupling { lean: [0.052_944, 0.011_167], own: [-0.024_933, -0.000_502], flow: 0.023_232 },
    ],
];

impl Coupling {
    /// Of the first mode with `wave`; with a wave (1,n), which it does not push, nothing.
    #[must_use]
    pub(super) fn with(wave: Wave) -> Self {
        let of = |kind: usize, n: usize| COUPLINGS.get(kind).and_then(|all| all.get(n)).copied();
        match wave {
            Wave::First(_) => None,
            Wave::Ring(n) => of(0, n),
            Wave::Saddle(n) => of(1, n),
        }
        .unwrap_or(Self { lean: [0.0; 2], own: [0.0; 2], flow: 0.0 })
    }

    /// B of a lean, 1/m: between waves of steepness `kappa` (1/m), first and driven, in a glass of `radius_m`.
    #[must_use]
    pub(super) fn lean(&self, kappa: [f64; 2], radius_m: f64) -> f64 {
        self.lean[0] / radius_m - kappa[0] * kappa[1] * self.lean[1] * radius_m
    }

    /// C of the wave's own height, 1/m2.
    #[must_use]
    pub(super) fn own(&self, kappa: [f64; 2], radius_m: f64) -> f64 {
        self.own[0] / (radius_m * radius_m) - kappa[0] * kappa[1] * self.own[1]
    }

    /// Coefficients p and q of a wave that nothing but gravity turns.
    #[must_use]
    pub(super) fn drive(&self, kappa: [f64; 2], radius_m: f64) -> [f64; 2] {
        let own = self.own(kappa, radius_m);
        let flow = 0.5 * (self.flow / (radius_m * radius_m) - kappa[0] * kappa[0] * self.own[1]);
        [radius_m * (own - flow * kappa[1] / kappa[0]) / kappa[0], -radius_m * own / kappa[0]]
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "a test may take the platform's functions")]
mod tests {
    use super::*;
    use crate::math::bessel_j;
    use crate::reduced::{Cylinder, SloshMode};
    use core::f64::consts::PI;

    #[test]
    fn the_couplings_are_the_integrals_that_they_stand_for() {
        let glass = Cylinder { radius_m: 1.0, depth_m: 2.0, density_kg_m3: 1.0 };
        let shape = |wave: Wave, r: f64| {
            let (order, xi) = wave.order();
            bessel_j(order, xi * r) / bessel_j(order, xi)
        };
        let slope = |wave: Wave, r: f64| (shape(wave, r + 1e-5) - shape(wave, r - 1e-5)) / 2e-5;
        const RINGS: u32 = 2000;
        for wave in [Wave::Ring, Wave::Saddle].into_iter().flat_map(|kind| (0..RADIAL).map(kind)) {
            let mut sums = [0.0; 5];
            for i in 0..RINGS {
                let r = (f64::from(i) + 0.5) / f64::from(RINGS);
                let first = Wave::First(0);
                let (a, b) = (shape(wave, r), shape(first, r));
                let (da, db) = (slope(wave, r), slope(first, r));
                // int cos^2 = pi; int cos^2 cos 2 = pi/2, int cos (2 sin 2 sin) = pi; dA = r dr, x = r cos.
                let (along, around) = if wave.order().0 == 0 { (PI, 0.0) } else { (0.5 * PI, PI) };
                // int |grad phi_1|^2: cos^2 phi'^2 + sin^2 phi^2/r^2, and sin^2 = 1 - cos^2.
                let across = if wave.order().0 == 0 { PI } else { -0.5 * PI };
                let parts = [
                    along * da * db * r * r + around * a * b,
                    along * a * b * r * r,
                    along * b * da * db * r + around * b * b * a / r,
                    along * b * b * a * r,
                    (along * db * db + across * b * b / (r * r)) * a * r,
                ];
                sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part / f64::from(RINGS));
            }
            let area = SloshMode::new(&glass, wave).area_m2;
            let Coupling { lean, own, flow } = Coupling::with(wave);
            for (sum, stated) in sums.iter().zip([lean[0], lean[1], own[0], own[1], flow]) {
                assert!((sum / area - stated).abs() < 1e-5, "{wave:?}: {} for {stated}", sum / area);
            }
        }
    }

    /// The numbers that `Baseline` and the calibration of a discovery state of deep liquid.
    #[test]
    fn deep_liquid_drives_its_second_order_as_stated() {
        let drive = |wave: Wave| Coupling::with(wave).drive([1.841_184, wave.order().1], 1.0);
        let near = |found: [f64; 2], stated: [f64; 2]| {
            found.iter().zip(stated).all(|(found, stated)| (found - stated).abs() < 0.005)
        };
        let (ring, saddle) = (drive(Wave::Ring(0)), drive(Wave::Saddle(0)));
        assert!(near(ring, [0.62, -0.02]) && near(saddle, [0.80, 0.26]), "{ring:?} {saddle:?}");
    }

    #[test]
    fn a_standing_wave_in_a_channel_has_the_second_harmonic_of_stokes() {
        // Deep water, phi_1 = cos x and phi_2 = cos 2x over a length of pi: to second order a standing wave is
        // a cos wt cos x + a^2/2 cos^2 wt cos 2x (Rayleigh 1915).
        let (g, a) = (9.81, 0.01);
        let coupling = Coupling { lean: [0.0; 2], own: [1.0, 0.5], flow: -0.5 };
        let [p, q] = coupling.drive([1.0, 2.0], 1.0);
        // v1^2 = g a^2 (1 - cos 2wt)/2, a1^2 = a^2 (1 + cos 2wt)/2, and w2^2 = 2 g.
        let steady = g * a * a * (p + q) / 2.0 / (2.0 * g);
        let double = g * a * a * (q - p) / 2.0 / (2.0 * g - 4.0 * g);
        assert!(
            (steady - a * a / 4.0).abs() < 1e-12 && (double - a * a / 4.0).abs() < 1e-12,
            "{steady} {double}"
        );
    }
}
