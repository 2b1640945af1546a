//! First mode of a liquid in a moved glass, with six numbers that distinguish liquids.
//!
//! ```text
//! y = s + b X,     y'' = -2 gamma (y' - b X') - w^2 (1 - 2 kappa A^2/A_1^2) (y - b X)
//! gamma(A) = gamma_0 + gamma_y / (1 + A/A_0) + gamma_b A^2/A_1^2,      A^2 = s^2 + s'^2/w^2
//! ```
//! s is the height of the mode at the wall, X the position of the glass. Written in y the motion enters by its position and
//! needs no second difference, which would be noise. The decay has three parts: what is the same at any height, what a
//! yield stress adds where little moves (by equivalent linearisation it falls as 1/A: `crate::reduced`), and what waves
//! lose that steepen or break. Frequencies fall with the square of the height (Miles 1976; Bauerlein and
//! Avila 2021).

use crate::units::FRAME_INTERVAL_S;
use serde::{Deserialize, Serialize};

/// A_0: below this height a yield stress counts in full, m.
const LOW_M: f64 = 1e-3;

/// A_1: the height for which kappa and gamma_b are stated, m.
const HIGH_M: f64 = 1e-2;

/// Height beyond which softening and decay grow no more, m: nothing was fitted there.
const HIGHEST_M: f64 = 3e-2;

/// Least share of w^2 that softening leaves.
const SOFTEST: f64 = 0.2;

/// Steps a frame; at 480 a second a wave of 4 Hz is off by a thousandth of its period after a second.
const STEPS: u32 = 8;

/// Six numbers of a liquid in a glass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tone {
    /// w: frequency of a low wave, 1/s.
    pub frequency: f64,
    /// gamma_0: decay at any height, 1/s.
    pub decay: f64,
    /// gamma_y: what a yield stress adds to it at rest, 1/s.
    pub yielding: f64,
    /// gamma_b: what is added at a height of 10 mm, 1/s.
    pub breaking: f64,
    /// kappa: share of the frequency that a height of 10 mm takes away.
    pub softening: f64,
    /// b: height for a glass that jumps aside by one, static slope over w^2.
    pub lever: f64,
}

/// State of a mode.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Swing {
    /// s: height at the wall, m.
    pub height_m: f64,
    /// y': its rate and b times the speed of the glass, m/s.
    pub rate_m_s: f64,
}

/// Even change of a position or of a height over some frames, metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// Value at the first frame.
    pub from_m: f64,
    /// Value at the last frame.
    pub to_m: f64,
}

impl Tone {
    /// Advances `swing` by `frames` frame intervals of an evenly moving glass, whose position is `glass`.
    ///
    /// ```
    /// use meniscus::identify::{Change, Swing, Tone};
    ///
    /// let water =
    ///     Tone { frequency: 22.5, decay: 0.5, yielding: 0.0, breaking: 0.0, softening: 0.0, lever: 1.5 };
    /// // Two seconds in a glass at rest: the wave has lost most of its height, exp(-2 s 0.5/s).
    /// let mut swing = Swing { height_m: 1e-3, rate_m_s: 0.0 };
    /// water.advance(&mut swing, Change::default(), 120);
    /// let amplitude = water.amplitude2_m2(&swing, 0.0).sqrt();
    /// assert!((amplitude / 1e-3 - (-1.0_f64).exp()).abs() < 0.02);
    /// ```
    pub fn advance(&self, swing: &mut Swing, glass: Change, frames: u32) {
        let Change { from_m, to_m } = glass;
        let steps = frames.max(1).saturating_mul(STEPS);
        let dt = FRAME_INTERVAL_S / f64::from(STEPS);
        let way = (to_m - from_m) / f64::from(steps);
        let pace = self.lever * way / dt;
        let square = self.frequency * self.frequency;
        let mut y = swing.height_m + self.lever * from_m;
        let mut rate = swing.rate_m_s;
        for step in 0..steps {
            let place = from_m + way * (f64::from(step) + 0.5);
            let s = y + 0.5 * dt * rate - self.lever * place;
            let moving = rate - pace;
            let amplitude2 = (s * s + moving * moving / square).min(HIGHEST_M * HIGHEST_M);
            let high = amplitude2 / (HIGH_M * HIGH_M);
            let low = 1.0 + crate::math::sqrt(amplitude2) / LOW_M;
            let gamma = self.decay + self.yielding / low + self.breaking * high;
            let stiff = square * (1.0 - 2.0 * self.softening * high).max(SOFTEST);
            // Half a way, a kick, half a way (Stoermer 1907); the friction implicit: stable however thick the liquid.
            let before = rate;
            rate = (rate - dt * stiff * s + 2.0 * dt * gamma * pace) / (1.0 + 2.0 * dt * gamma);
            y += 0.5 * dt * (before + rate);
        }
        *swing = Swing { height_m: y - self.lever * to_m, rate_m_s: rate };
    }

    /// Swing whose height changed by `height` within `frames`, in a glass at `speed_m_s`: the rate is that of the middle
    /// of the change, advanced to its end by the acceleration w^2 s.
    #[must_use]
    pub fn caught(&self, height: Change, frames: u32, speed_m_s: f64) -> Swing {
        let Change { from_m, to_m } = height;
        let time_s = f64::from(frames.max(1)) * FRAME_INTERVAL_S;
        let middle = (to_m - from_m) / time_s;
        let bent = 0.25 * time_s * self.frequency * self.frequency * (from_m + to_m);
        Swing { height_m: to_m, rate_m_s: middle - bent + self.lever * speed_m_s }
    }

    /// A^2 of a swing in a glass that moves at `speed_m_s`, m2.
    #[must_use]
    pub fn amplitude2_m2(&self, swing: &Swing, speed_m_s: f64) -> f64 {
        let moving = (swing.rate_m_s - self.lever * speed_m_s) / self.frequency;
        swing.height_m * swing.height_m + moving * moving
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::exp;

    const WATER: Tone =
        Tone { frequency: 22.5, decay: 0.5, yielding: 0.0, breaking: 0.0, softening: 0.0, lever: 1.5 };

    fn rung(tone: &Tone, frames: u32) -> Swing {
        let mut swing = Swing { height_m: 1e-3, rate_m_s: 0.0 };
        tone.advance(&mut swing, Change { from_m: 0.01, to_m: 0.01 }, frames);
        swing
    }

    #[test]
    fn a_free_wave_has_its_decay_and_frequency() {
        // After a whole number of periods of sqrt(w^2 - gamma^2) the height is exp(-gamma t).
        let tone = Tone { frequency: 20.0 * core::f64::consts::PI / 3.0, ..WATER };
        let swing = rung(&tone, 60 * 3 / 2);
        // 1.5 s are five periods of 0.3 s.
        let due = 1e-3 * exp(-0.5 * 1.5);
        assert!((swing.height_m / due - 1.0).abs() < 0.02, "{swing:?}, {due}");
    }

    #[test]
    fn a_steady_push_tilts_the_surface_by_b_over_w_squared() {
        let thick = Tone { decay: 20.0, ..WATER };
        let place = |frame: u32| 0.5 * 2.0 * (f64::from(frame) / 60.0) * (f64::from(frame) / 60.0);
        let mut swing = Swing::default();
        (0..120).for_each(|n| thick.advance(&mut swing, Change { from_m: place(n), to_m: place(n + 1) }, 1));
        let due = -1.5 * 2.0 / (22.5 * 22.5);
        // The glass goes evenly between frames, and the corners of its way push 3 % more; a fitted lever takes that in.
        assert!((swing.height_m / due - 1.0).abs() < 0.05, "{} for {due}", swing.height_m);
    }

    #[test]
    fn a_gap_ends_where_its_frames_would_have() {
        let (mut whole, mut parts) = (rung(&WATER, 10), rung(&WATER, 10));
        WATER.advance(&mut whole, Change { from_m: 0.0, to_m: 0.004 }, 4);
        (0..4).for_each(|n| {
            let at = |n: u32| 0.001 * f64::from(n);
            WATER.advance(&mut parts, Change { from_m: at(n), to_m: at(n + 1) }, 1);
        });
        assert!((whole.height_m - parts.height_m).abs() < 1e-9, "{whole:?} {parts:?}");
    }

    #[test]
    fn a_yield_stress_stops_low_waves_and_a_thick_liquid_stays_finite() {
        let yields = Tone { yielding: 30.0, ..WATER };
        let after = |height_m: f64| {
            let mut swing = Swing { height_m, rate_m_s: 0.0 };
            yields.advance(&mut swing, Change { from_m: 0.0, to_m: 0.0 }, 17);
            crate::math::sqrt(yields.amplitude2_m2(&swing, 0.0)) / height_m
        };
        assert!(after(1e-4) < 0.6 * after(1e-2), "{} {}", after(1e-4), after(1e-2));
        let honey = rung(&Tone { decay: 300.0, ..WATER }, 600);
        assert!(honey.height_m > 0.0 && honey.height_m < 1e-3, "{honey:?}");
    }
}
