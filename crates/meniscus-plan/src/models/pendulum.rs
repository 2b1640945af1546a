//! The liquid as a linear pendulum, as published planners have it.
//!
//! ```text
//! a'' + 2 zeta w a' + w^2 a = -(R/g) w^2 x''           a: height at the wall, R x''/g under a steady acceleration
//! ```
//! The step is exact for an acceleration that is constant over a frame. Nothing is known of its errors.

use super::{FrameForecast, FrameInput, SurfaceModel};
use crate::wall::WALL;
use meniscus::surface::profile_abscissa;
use meniscus::units::{FRAME_INTERVAL_S, GRAVITY_M_S2};

/// A pendulum that stands for the first mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pendulum {
    /// Frequency w, 1/s.
    pub frequency: f64,
    /// Damping ratio zeta, below 1.
    pub damping: f64,
    /// Radius R of the glass, m.
    pub radius_m: f64,
    /// Height of the rim over the liquid at rest, m.
    pub room_m: f64,
}

impl SurfaceModel for Pendulum {
    /// Height at s = 1 (m) and its rate (m/s).
    type State = [f64; 2];

    const INPUT: FrameInput = FrameInput::Mean;

    fn rest(&self) -> [f64; 2] {
        [0.0; 2]
    }

    fn advance(&self, state: &mut [f64; 2], input: f64) {
        let (w, zeta, dt) = (self.frequency, self.damping, FRAME_INTERVAL_S);
        let balance = -self.static_m() * input;
        let turn = w * (1.0 - zeta * zeta).sqrt();
        let [a, v] = [state[0] - balance, state[1]];
        let (sin, cos) = (turn * dt).sin_cos();
        let fade = (-zeta * w * dt).exp();
        let across = (v + zeta * w * a) / turn;
        let next = fade * (a * cos + across * sin);
        let rate = fade * (across * turn * cos - a * turn * sin) - zeta * w * next;
        *state = [next + balance, rate];
    }

    fn look(&self, state: &[f64; 2], _: f64) -> FrameForecast {
        let shape = |i: usize| match i {
            0 => -1.0,
            _ if i == WALL - 1 => 1.0,
            _ => profile_abscissa(i - 1),
        };
        FrameForecast { wall_m: std::array::from_fn(|i| state[0] * shape(i)), half_width_m: 0.0 }
    }

    fn room_m(&self) -> f64 {
        self.room_m
    }

    fn static_m(&self) -> f64 {
        self.radius_m / GRAVITY_M_S2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A thousand small explicit steps are the other code.
    #[test]
    fn a_step_is_the_solution_of_its_equation() {
        let pendulum = Pendulum { frequency: 22.0, damping: 0.2, radius_m: 0.035, room_m: 0.04 };
        let (mut state, mut fine) = ([0.003, -0.02], [0.003, -0.02]);
        for input in [1.0, -2.0, 0.5] {
            pendulum.advance(&mut state, input);
            let h = FRAME_INTERVAL_S / 20_000.0;
            for _ in 0..20_000 {
                let [a, v]: [f64; 2] = fine;
                let pull = -484.0 * (a + 0.035 / GRAVITY_M_S2 * input) - 2.0 * 0.2 * 22.0 * v;
                fine = [a + h * (v + 0.5 * h * pull), v + h * pull];
            }
            assert!(
                (state[0] - fine[0]).abs() < 1e-6 && (state[1] - fine[1]).abs() < 1e-4,
                "{state:?} {fine:?}"
            );
        }
    }
}
