//! Second-order waves: what a wave of the first mode carries with it at twice its frequency, and in a tilted
//! glass at its own.
//!
//! ```text
//! s'' + 2 gamma s' + w^2 s = (p v1^2 + q w1^2 a1^2)/R + B t v1'/kappa1        for s of (0,1) and (2,1)
//! ```
//! The quadratic terms of the surface conditions have this form for a standing wave (Miles 1976); p and q
//! belong to the baseline and are calibrated, because viscosity and the contact line change them. These
//! waves ride along: their energy is of fourth order in the amplitude and is left out of the books. With
//! waves along x and y, `a1^2` is `ax^2 + ay^2` for (0,1), and `ax^2 - ay^2` and `2 ax ay` for (2,1).
//!
//! In a glass that leans by t = tan theta the surface at rest is `t x` over the round cross-section: one side is
//! deeper than the other, and a wave along it does not stay in its mode. To first order in t the operator that
//! takes the potential on the surface to its rising is `G0 + G1, G1 = -div(t x grad) - G0 t x G0` (Craig and Sulem
//! 1993), and between the modes m and n
//! ```text
//! B = (int x grad phi_m.grad phi_n - kappa_m kappa_n int x phi_m phi_n)/N_m,      kappa = k tanh kh
//! ```
//! where `v1'/kappa1 = -g a1 + b f` is how fast the potential of the first mode changes: gravity and the push.
//! A camera that is rolled shows the same surface at rest and not this.

use crate::math::{sqrt, tan};

/// Second-order waves that are kept: (0,1), (2,1) along cos 2 theta, (2,1) along sin 2 theta.
pub const SECOND: usize = 3;

/// Heights at the wall and rates of the second-order waves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Second {
    /// Heights, m.
    pub height: [f64; SECOND],
    /// Rates, m/s.
    pub rate: [f64; SECOND],
}

/// How strongly the first mode drives them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondOrder {
    /// Frequency squared of (0,1) and (2,1), 1/s2.
    pub square: [f64; 2],
    /// Damping gamma, 1/s.
    pub damping: [f64; 2],
    /// Coefficients p and q of (0,1) and (2,1).
    pub drive: [[f64; 2]; 2],
    /// Radius R, m.
    pub radius_m: f64,
    /// What a lean along x does to (0,1) and (2,1): `B t`, 1/m.
    pub lean: [f64; 2],
}

/// `R int x grad phi_m.grad phi_n/N_m` and `int x phi_m phi_n/(N_m R)` of (0,1) and of (2,1) with (1,1), where
/// the shapes phi are one at the wall.
const LEANS: [[f64; 2]; 2] = [[0.780_667, 0.141_730], [1.877_006, 0.432_817]];

/// B of (0,1) and (2,1) with (1,1), 1/m, for their steepnesses kappa (1/m) in a glass of `radius_m`.
#[must_use]
pub fn leaning(first: f64, waves: [f64; 2], radius_m: f64) -> [f64; 2] {
    let one = |[bent, thick]: [f64; 2], kappa: f64| bent / radius_m - first * kappa * thick * radius_m;
    let [ring, saddle] = LEANS;
    [one(ring, waves[0]), one(saddle, waves[1])]
}

impl SecondOrder {
    /// Advances `waves` by `dt` seconds under a first mode whose heights and rates in the middle of the
    /// step are `a` and `v`, of frequency squared `square`, and whose potential changes by `turns` (m2/s2).
    pub fn advance(&self, waves: &mut Second, dt: f64, square: f64, [a, v, turns]: [&[f64; 2]; 3]) {
        let ([ax, ay], [vx, vy], [tx, ty]) = (*a, *v, *turns);
        let kinds = [0, 1, 1];
        let rates = [vx * vx + vy * vy, vx * vx - vy * vy, 2.0 * vx * vy];
        let heights = [ax * ax + ay * ay, ax * ax - ay * ay, 2.0 * ax * ay];
        let leans = [tx, tx, ty];
        let pushes = rates.iter().zip(heights).zip(leans);
        let slots = waves.height.iter_mut().zip(&mut waves.rate).zip(kinds.iter().zip(pushes));
        for ((height, rate), (kind, ((vv, aa), along))) in slots {
            let pick = |pair: &[f64; 2]| if *kind == 0 { pair[0] } else { pair[1] };
            let [p, q] = if *kind == 0 { self.drive[0] } else { self.drive[1] };
            let push = (p * vv + q * square * aa) / self.radius_m + pick(&self.lean) * along;
            let (w2, gamma) = (pick(&self.square), pick(&self.damping));
            // Implicit in the middle, with the stiffness that keeps the frequency exact.
            let tangent = tan(0.5 * dt * sqrt(w2));
            let stiff = 4.0 * tangent * tangent / (dt * dt);
            let middle = (2.0 * *rate / dt - stiff * *height + push * stiff / w2)
                / (2.0 / dt + 0.5 * stiff * dt + 2.0 * gamma);
            *height += dt * middle;
            *rate = 2.0 * middle - *rate;
        }
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "a test may take the platform's functions")]
mod tests {
    use super::*;
    use crate::math::bessel_j;
    use crate::slosh::{Cylinder, Mode, Wave};
    use core::f64::consts::PI;

    #[test]
    fn the_leans_are_the_integrals_that_they_stand_for() {
        let glass = Cylinder { radius_m: 1.0, depth_m: 2.0, density_kg_m3: 1.0 };
        let shape = |wave: Wave, r: f64| {
            let (order, xi) = wave.order();
            bessel_j(order, xi * r) / bessel_j(order, xi)
        };
        let slope = |wave: Wave, r: f64| (shape(wave, r + 1e-5) - shape(wave, r - 1e-5)) / 2e-5;
        const RINGS: u32 = 2000;
        for (wave, [bent, thick]) in [Wave::Ring, Wave::Saddle].into_iter().zip(LEANS) {
            let (mut gradients, mut products) = (0.0, 0.0);
            for i in 0..RINGS {
                let r = (f64::from(i) + 0.5) / f64::from(RINGS);
                let first = Wave::First(0);
                let (a, b) = (shape(wave, r), shape(first, r));
                let (da, db) = (slope(wave, r), slope(first, r));
                // int cos^2 = pi; int cos^2 cos 2 = pi/2, int cos (2 sin 2 sin) = pi; dA = r dr, x = r cos.
                let (along, around) = if wave.order().0 == 0 { (PI, 0.0) } else { (0.5 * PI, PI) };
                products += along * a * b * r * r / f64::from(RINGS);
                gradients += (along * da * db * r * r + around * a * b) / f64::from(RINGS);
            }
            let area = Mode::new(&glass, wave).area_m2;
            assert!((gradients / area - bent).abs() < 1e-5, "{}", gradients / area);
            assert!((products / area - thick).abs() < 1e-5, "{}", products / area);
        }
    }

    #[test]
    fn a_steady_push_lifts_the_wave_to_its_static_height_and_a_planar_wave_drives_no_sine() {
        let order = SecondOrder {
            square: [900.0, 700.0],
            damping: [5.0, 5.0],
            drive: [[0.0, 0.5], [0.0, -0.25]],
            radius_m: 0.035,
            lean: [0.0; 2],
        };
        let mut waves = Second::default();
        for _ in 0..4000 {
            order.advance(&mut waves, 1.0 / 240.0, 500.0, [&[0.01, 0.0], &[0.0; 2], &[0.0; 2]]);
        }
        let wanted = 0.5 * 500.0 * 1e-4 / 0.035 / 900.0;
        assert!((waves.height[0] / wanted - 1.0).abs() < 1e-6, "{} for {wanted}", waves.height[0]);
        assert!(waves.height[1] < 0.0 && waves.height[2] == 0.0);
    }
}
