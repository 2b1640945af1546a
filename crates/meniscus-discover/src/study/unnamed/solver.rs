//! Modes of a glass, integrated by the classical Runge-Kutta method: a truth that shares no code with the reduced model.
//!
//! ```text
//! a_n'' = -w_n^2 a_n - 2 gamma_n a_n' - k_n tanh(k_n h) b_n x'' - [n = 1] (f(a) + D(a, v))/m
//! w_n^2 = g k tanh(kh) less the layer,    gamma_n = 1.1 sqrt(nu w/2)/R + 1.8 nu k^2,    b = 2R/(xi^2 - 1)
//! f also softens by itself:  w_1^2 a (1 - 8/3 kappa a^2/R^2)
//! q'' = -w_q^2 q - 2 gamma q' + (p v^2 + r w_1^2 a^2)/R        the ring (0,1) and the saddle (2,1)
//! wall(s) = s sum a_n + q_0 + q_2 (2 s^2 - 1) + c a_1^3/R^2 (4 s^3 - 3 s)
//! ```
//! (Lamb 1932; Case and Parkinson 1957 for the layer.) It has a fourth mode, a third harmonic, other dampings and other
//! second-order numbers than the reduced model, and a glass differs from the next by parts of a per cent, as packings do.

use super::laws::{FirstMode, HiddenLaw};
use crate::recordings::motion_plan::MotionPlan;
use meniscus::surface::{POINTS, profile_abscissa};
use meniscus::units::FRAME_INTERVAL_S;

/// Radius of every glass, m.
pub const RADIUS_M: f64 = 0.035;
/// Depth of the liquid in it, m.
pub const DEPTH_M: f64 = 0.070;
/// Density of the liquid, kg/m3.
pub const DENSITY_KG_M3: f64 = 1261.0;

const GRAVITY: f64 = 9.80665;

/// Zeros of J1', of J0' and of J2'.
const ZEROS: [f64; 4] = [1.841_183_8, 5.331_442_8, 8.536_316_4, 11.706_004_9];
const RING: f64 = 3.831_706;
const SADDLE: f64 = 3.054_236_9;

/// Steps of a frame.
const STEPS: usize = 40;

/// Softening of the first mode, second-order numbers p and r of ring and saddle, and the third harmonic.
const SOFTENING: f64 = 0.12;
const SECOND: [[f64; 2]; 2] = [[0.45, -0.55], [0.55, -0.45]];
const THIRD: f64 = 0.25;

/// One glass: a liquid, and by how much it differs from the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glass {
    /// Viscosity, Pa s.
    pub viscosity_pa_s: f64,
    /// Parts of the frequencies, of the dampings and of the second order by which it differs.
    pub differs: [f64; 3],
}

/// Frequency, damping, and force for each m/s2 of the glass, of one mode.
#[derive(Clone, Copy, Debug, Default)]
struct Mode {
    frequency: f64,
    damping: f64,
    driven: f64,
}

impl Glass {
    /// Returns the mode with the zero `xi`; `driven` is whether a moved glass drives it.
    fn mode(&self, xi: f64, driven: bool) -> Mode {
        let (k, nu) = (xi / RADIUS_M, self.viscosity_pa_s / DENSITY_KG_M3);
        let steep = k * (k * DEPTH_M).tanh();
        let plain = (GRAVITY * steep).sqrt();
        let layer = (0.5 * nu * plain).sqrt() / RADIUS_M;
        let [frequency, damping, _] = self.differs;
        Mode {
            frequency: (plain - 0.8 * layer) * (1.0 + frequency),
            damping: (1.1 * layer + 1.8 * nu * k * k) * (1.0 + damping),
            driven: if driven { steep * 2.0 * RADIUS_M / (xi * xi - 1.0) } else { 0.0 },
        }
    }

    /// Returns its first mode.
    #[must_use]
    pub fn first_mode(&self) -> FirstMode {
        let xi = ZEROS[0];
        let k = xi / RADIUS_M;
        let area = 0.5 * std::f64::consts::PI * RADIUS_M * RADIUS_M * (1.0 - 1.0 / (xi * xi));
        let mass_kg = DENSITY_KG_M3 * area / (k * (k * DEPTH_M).tanh());
        FirstMode { frequency: self.mode(xi, true).frequency, mass_kg }
    }

    /// Returns the heights over the fill at the points of a profile, m, and the position of the glass, m, frame by frame, on
    /// the path `plan` under the hidden `law`.
    #[must_use]
    pub fn run(&self, plan: &MotionPlan, law: Option<&HiddenLaw>) -> Vec<([f64; POINTS], f64)> {
        let solver = Solver {
            modes: ZEROS.map(|xi| self.mode(xi, true)),
            second: [self.mode(RING, false), self.mode(SADDLE, false)],
            steep: 1.0 + self.differs[2],
            law,
            plan,
        };
        let dt = FRAME_INTERVAL_S / STEPS as f64;
        let mut state = State::default();
        let mut out = Vec::with_capacity(plan.frames());
        for frame in 0..plan.frames() {
            let time = frame as f64 * FRAME_INTERVAL_S;
            out.push((solver.wall(&state), plan.position(time)));
            (0..STEPS).for_each(|n| solver.advance(&mut state, time + n as f64 * dt, dt));
        }
        out
    }
}

/// Heights and rates: four modes along x, then ring and saddle.
#[derive(Clone, Copy, Debug, Default)]
struct State {
    height: [f64; 6],
    rate: [f64; 6],
}

impl State {
    fn plus(&self, slope: &Self, dt: f64) -> Self {
        let mut out = *self;
        out.height.iter_mut().zip(slope.height).for_each(|(x, d)| *x += dt * d);
        out.rate.iter_mut().zip(slope.rate).for_each(|(x, d)| *x += dt * d);
        out
    }
}

struct Solver<'a> {
    modes: [Mode; 4],
    second: [Mode; 2],
    steep: f64,
    law: Option<&'a HiddenLaw>,
    plan: &'a MotionPlan,
}

impl Solver<'_> {
    fn slope(&self, state: &State, time: f64) -> State {
        let h = 1e-4;
        let x = |t: f64| self.plan.position(t);
        let pushed = (x(time + h) - 2.0 * x(time) + x(time - h)) / (h * h);
        let mut rate = [0.0; 6];
        for (i, mode) in self.modes.iter().enumerate() {
            let w2 = mode.frequency * mode.frequency;
            rate[i] = -w2 * state.height[i] - 2.0 * mode.damping * state.rate[i] - mode.driven * pushed;
        }
        let (a, v) = (state.height[0], state.rate[0]);
        let w2 = self.modes[0].frequency.powi(2);
        rate[0] += w2 * a * 8.0 / 3.0 * SOFTENING * a * a / (RADIUS_M * RADIUS_M);
        if let Some(law) = self.law {
            rate[0] -= law.acceleration_m_s2(a, v, self.modes[0].frequency);
        }
        for (i, (mode, [p, r])) in self.second.iter().zip(SECOND).enumerate() {
            let (q, qv) = (state.height[4 + i], state.rate[4 + i]);
            let driven = self.steep * (p * v * v + r * w2 * a * a) / RADIUS_M;
            rate[4 + i] = driven - mode.frequency.powi(2) * q - 2.0 * mode.damping * qv;
        }
        State { height: state.rate, rate }
    }

    fn advance(&self, state: &mut State, time: f64, dt: f64) {
        let one = self.slope(state, time);
        let two = self.slope(&state.plus(&one, 0.5 * dt), time + 0.5 * dt);
        let three = self.slope(&state.plus(&two, 0.5 * dt), time + 0.5 * dt);
        let four = self.slope(&state.plus(&three, dt), time + dt);
        for (slope, weight) in [(one, 1.0), (two, 2.0), (three, 2.0), (four, 1.0)] {
            *state = state.plus(&slope, weight * dt / 6.0);
        }
    }

    fn wall(&self, state: &State) -> [f64; POINTS] {
        let along: f64 = state.height[..4].iter().sum();
        let third = THIRD * state.height[0].powi(3) / (RADIUS_M * RADIUS_M);
        std::array::from_fn(|i| {
            let s = profile_abscissa(i);
            let (ring, saddle) = (state.height[4], state.height[5] * (2.0 * s * s - 1.0));
            along * s + ring + saddle + third * (4.0 * s * s * s - 3.0 * s)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GLASS: Glass = Glass { viscosity_pa_s: 0.2, differs: [0.0; 3] };

    #[test]
    fn a_jolt_leaves_a_wave_of_the_first_frequency_that_decays_as_it_should() {
        let plan = MotionPlan::jolt(0.28, 0.6, 3.0);
        let run = GLASS.run(&plan, None);
        let edge: Vec<f64> = run.iter().map(|(heights, _)| heights[POINTS - 1]).collect();
        // Zero crossings after the jolt, two frames of which lie half a period apart.
        let crossings: Vec<f64> = (50..170)
            .filter(|n| edge[*n] * edge[n + 1] < 0.0)
            .map(|n| n as f64 + edge[n] / (edge[n] - edge[n + 1]))
            .collect();
        let half = (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64;
        let found = std::f64::consts::PI / (half * FRAME_INTERVAL_S);
        let mode = GLASS.mode(ZEROS[0], true);
        assert!((found / mode.frequency - 1.0).abs() < 0.03, "{found} {}", mode.frequency);
        let peak = |from: usize| edge[from..from + 20].iter().fold(0.0_f64, |m, z| m.max(z.abs()));
        let (early, late) = (peak(50), peak(110));
        let wanted = (-mode.damping).exp();
        assert!((late / early / wanted - 1.0).abs() < 0.15, "{} for {wanted}", late / early);
        assert!(run[..20].iter().all(|(heights, x)| heights.iter().all(|z| z.abs() < 1e-6) && *x == 0.0));
    }
}
