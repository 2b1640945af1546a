//! Second-order waves: what a wave of the first mode carries with it at twice its frequency.
//!
//! ```text
//! s'' + 2 gamma s' + w^2 s = (p v1^2 + q w1^2 a1^2)/R        for s of (0,1) and (2,1)
//! ```
//! The quadratic terms of the surface conditions have this form for a standing wave (Miles 1976); p and q
//! belong to the baseline and are calibrated, because viscosity and the contact line change them. These
//! waves ride along: their energy is of fourth order in the amplitude and is left out of the books. With
//! waves along x and y, `a1^2` is `ax^2 + ay^2` for (0,1), and `ax^2 - ay^2` and `2 ax ay` for (2,1).

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
}

impl SecondOrder {
    /// Advances `waves` by `dt` seconds under a first mode whose heights and rates in the middle of the
    /// step are `a` and `v`, of frequency squared `square`.
    pub fn advance(&self, waves: &mut Second, dt: f64, square: f64, a: &[f64; 2], v: &[f64; 2]) {
        let ([ax, ay], [vx, vy]) = (*a, *v);
        let kinds = [0, 1, 1];
        let rates = [vx * vx + vy * vy, vx * vx - vy * vy, 2.0 * vx * vy];
        let heights = [ax * ax + ay * ay, ax * ax - ay * ay, 2.0 * ax * ay];
        let slots =
            waves.height.iter_mut().zip(&mut waves.rate).zip(kinds.iter().zip(rates.iter().zip(heights)));
        for ((height, rate), (kind, (vv, aa))) in slots {
            let pick = |pair: &[f64; 2]| if *kind == 0 { pair[0] } else { pair[1] };
            let [p, q] = if *kind == 0 { self.drive[0] } else { self.drive[1] };
            let push = (p * vv + q * square * aa) / self.radius_m;
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
mod tests {
    use super::*;

    #[test]
    fn a_steady_push_lifts_the_wave_to_its_static_height_and_a_planar_wave_drives_no_sine() {
        let order = SecondOrder {
            square: [900.0, 700.0],
            damping: [5.0, 5.0],
            drive: [[0.0, 0.5], [0.0, -0.25]],
            radius_m: 0.035,
        };
        let mut waves = Second::default();
        for _ in 0..4000 {
            order.advance(&mut waves, 1.0 / 240.0, 500.0, &[0.01, 0.0], &[0.0, 0.0]);
        }
        let wanted = 0.5 * 500.0 * 1e-4 / 0.035 / 900.0;
        assert!((waves.height[0] / wanted - 1.0).abs() < 1e-6, "{} for {wanted}", waves.height[0]);
        assert!(waves.height[1] < 0.0 && waves.height[2] == 0.0);
    }
}
