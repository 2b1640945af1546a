//! Motion of the liquid in time: four waves along x, and the rings and saddles that the first one drives.
//!
//! ```text
//! m_n a_n'' = -(rho g N + sigma int |grad|^2) a_n - x'' rho int x phi - friction - line            m = rho N/(k tanh kh)
//! friction = sum tau(|v| g_i) g_i V_i   in the bulk,     sum tau_wall,j U_j A_j   at the wall
//! s_j'' + w_j^2 s_j = C_j (v1^2 + a1 v1')/kappa1 - D_j kappa_j v1^2/kappa1^2           rings and saddles (Miles 1976)
//! ```
//! Rates and heights are advanced in turn (leapfrog), friction implicitly.

use super::glass::LaboratoryGlass;
use super::shapes::Shape;
use super::waves::{ALONG, WAVES, Wave, resistance, wave};
use crate::recordings::motion_plan::MotionPlan;
use meniscus::surface::{POINTS, profile_abscissa};
use meniscus::units::FRAME_INTERVAL_S;
use std::f64::consts::TAU;

/// Steps of a frame.
const STEPS: usize = 40;

/// Pieces of the line around the wall.
const PIECES: usize = 32;

/// Deflection at which the line slides, m, and speed below which foam rubs like a liquid, m/s.
const REACH_M: f64 = 5e-4;
const SLOWEST_M_S: f64 = 1e-4;

/// Softening of the first wave, and its third harmonic.
const SOFTENING: f64 = 0.1;
const THIRD: f64 = 0.2;

/// Liquid of one glass that moves.
pub struct Solver<'a> {
    glass: &'a LaboratoryGlass,
    plan: &'a MotionPlan,
    waves: Vec<Wave>,
    height: [f64; WAVES.len()],
    rate: [f64; WAVES.len()],
    /// Strain that the bulk remembers, by wave, m.
    remembered: [f64; WAVES.len()],
    /// Deflection of the pieces of the line, m.
    caught: [f64; PIECES],
    time_s: f64,
}

impl<'a> Solver<'a> {
    /// Returns the liquid of `glass` at rest, before the path `plan`.
    #[must_use]
    pub fn new(glass: &'a LaboratoryGlass, plan: &'a MotionPlan) -> Self {
        let shapes = WAVES.map(|(order, xi)| Shape::new(order, xi, glass.radius_m, glass.fill_m));
        let waves = shapes.iter().enumerate().map(|(n, shape)| wave(glass, &shapes[0], n, *shape)).collect();
        let still = [0.0; WAVES.len()];
        Self {
            glass,
            plan,
            waves,
            height: still,
            rate: still,
            remembered: still,
            caught: [0.0; PIECES],
            time_s: 0.0,
        }
    }

    /// Returns the heights over the bottom at the points of a profile, m, and the position of the glass, m, frame by frame.
    #[must_use]
    pub fn run(mut self) -> Vec<([f64; POINTS], f64)> {
        let dt = FRAME_INTERVAL_S / STEPS as f64;
        let mut out = Vec::with_capacity(self.plan.frames());
        for frame in 0..self.plan.frames() {
            self.time_s = frame as f64 * FRAME_INTERVAL_S;
            out.push((self.profile(), self.plan.position(self.time_s)));
            for _ in 0..STEPS {
                self.step(dt);
                self.time_s += dt;
            }
        }
        out
    }

    fn step(&mut self, dt: f64) {
        let liquid = self.glass.liquid;
        let before = self.rate[0];
        let line = self.line_forces(dt);
        let pushed = self.acceleration();
        let apparent = self.apparent_viscosity();
        for (n, wave) in self.waves.iter_mut().enumerate() {
            let (a, v) = (self.height[n], self.rate[n]);
            let mut force = -wave.stiffness * a - wave.driven_kg * pushed - line[n];
            if n == 0 {
                let turned = wave.stiffness * 8.0 / 3.0 * SOFTENING * a * a * a / self.glass.radius_m.powi(2);
                let frequency = (wave.stiffness / wave.mass_kg).sqrt();
                let law = self.glass.law.map_or(0.0, |law| law.acceleration_m_s2(a, v, frequency));
                force += turned - wave.mass_kg * law;
            } else if n >= ALONG {
                let turns = (self.rate[0] - before) / dt;
                let (a1, v1) = (self.height[0], self.rate[0]);
                let [c, d] = wave.second;
                let steep = 1.0 + self.glass.differs[2];
                force += wave.mass_kg * steep * (c * (v1 * v1 + a1 * turns) - d * v1 * v1);
            }
            force -= liquid.modulus_pa * wave.strain_m * self.remembered[n];
            let v = &mut self.rate[n];
            // The friction of the bulk at the rate before, implicit in the rate.
            let resists = match wave.bulk.as_slice() {
                [] => apparent * wave.strain_m,
                pieces => pieces.iter().map(|piece| resistance(&liquid, piece, *v)).sum(),
            };
            *v = (*v + dt * force / wave.mass_kg) / (1.0 + dt * resists / wave.mass_kg);
            let rate = *v;
            let layers = wave.wall.iter_mut().map(|(patch, layer)| {
                patch.area_m2 * patch.speed * layer.advance(&liquid, patch.speed * rate, dt)
            });
            *v -= dt * layers.sum::<f64>() / wave.mass_kg;
            self.height[n] += dt * *v;
            self.remembered[n] = (self.remembered[n] + dt * *v) / (1.0 + dt / liquid.relaxation_s);
        }
    }

    /// Returns the acceleration of the glass, m/s2.
    fn acceleration(&self) -> f64 {
        let h = 1e-4;
        let x = |t: f64| self.plan.position(t);
        (x(self.time_s + h) - 2.0 * x(self.time_s) + x(self.time_s - h)) / (h * h)
    }

    /// Returns the viscosity that the first wave makes in the mean over the bulk, Pa s.
    fn apparent_viscosity(&self) -> f64 {
        let (first, liquid) = (&self.waves[0], &self.glass.liquid);
        if first.bulk.is_empty() {
            return liquid.viscosity(1.0);
        }
        first.bulk.iter().map(|piece| resistance(liquid, piece, self.rate[0])).sum::<f64>() / first.strain_m
    }

    /// Returns the force of the line on each wave, N, after its pieces moved on by `dt`.
    fn line_forces(&mut self, dt: f64) -> [f64; WAVES.len()] {
        let line = self.glass.line;
        let mut out = [0.0; WAVES.len()];
        if line == super::glass::Line::default() {
            return out;
        }
        let piece_m = TAU * self.glass.radius_m / PIECES as f64;
        for (i, caught) in self.caught.iter_mut().enumerate() {
            let angle = (i as f64 + 0.5) * TAU / PIECES as f64;
            let shapes = WAVES.map(|(order, _)| (f64::from(order) * angle).cos());
            let along =
                |of: &[f64; WAVES.len()]| of.iter().zip(shapes).map(|(x, shape)| x * shape).sum::<f64>();
            let (up, speed) = (along(&self.height), along(&self.rate));
            *caught = (*caught + dt * speed).clamp(-REACH_M, REACH_M);
            let rubs = line.foam * speed * speed.abs().max(SLOWEST_M_S).powf(-1.0 / 3.0);
            let force = line.spring_n_m2 * up + line.sliding_n_m * *caught / REACH_M + rubs;
            out.iter_mut().zip(shapes).for_each(|(out, shape)| *out += piece_m * force * shape);
        }
        out
    }

    fn profile(&self) -> [f64; POINTS] {
        let first: f64 = self.height[..ALONG].iter().sum();
        let rings: f64 = self.height[ALONG..ALONG + 2].iter().sum();
        let saddles: f64 = self.height[ALONG + 2..].iter().sum();
        let third = THIRD * self.height[0].powi(3) / self.glass.radius_m.powi(2);
        std::array::from_fn(|i| {
            let s = profile_abscissa(i);
            let second = rings + saddles * (2.0 * s * s - 1.0);
            self.glass.fill_m + first * s + second + third * (4.0 * s * s * s - 3.0 * s)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the heights at the edge, frame by frame, less the fill.
    fn edge(glass: &LaboratoryGlass, plan: &MotionPlan) -> Vec<f64> {
        Solver::new(glass, plan).run().iter().map(|(heights, _)| heights[POINTS - 1] - glass.fill_m).collect()
    }

    /// Returns frequency and damping of the waves after a weak jolt, from the zero crossings and the extremes between.
    fn ringing(glass: &LaboratoryGlass) -> [f64; 2] {
        let plan = MotionPlan::jolt(0.3, 0.05, 3.4);
        let z = edge(glass, &plan);
        let crossings: Vec<f64> = (60..z.len() - 1)
            .filter(|n| z[*n] * z[n + 1] < 0.0)
            .map(|n| n as f64 + z[n] / (z[n] - z[n + 1]))
            .collect();
        let (begin, end) = (crossings[0], crossings[crossings.len() - 1]);
        let half = (end - begin) / (crossings.len() - 1) as f64 * FRAME_INTERVAL_S;
        let largest = |from: f64, to: f64| {
            z[from.ceil() as usize..to as usize].iter().fold(0.0_f64, |most, z| most.max(z.abs()))
        };
        let (early, late) =
            (largest(crossings[0], crossings[2]), largest(crossings[crossings.len() - 3], end));
        [std::f64::consts::PI / half, (early / late).ln() / ((crossings.len() - 3) as f64 * half)]
    }

    #[test]
    fn a_thin_liquid_rings_as_theory_says() {
        let glass = LaboratoryGlass::plain(0.01);
        let [frequency, damping] = ringing(&glass);
        // The layer takes `rho sqrt(nu w/2) S/(2 m)`, S of |u|^2 over the side and the bottom (Case and Parkinson 1957).
        let (xi, nu) = (1.841_183_8_f64, 0.01 / 1100.0);
        let (k, kh) = (xi / 0.04, xi * 2.0);
        let free = (9.80665 * k * kh.tanh()).sqrt();
        let (sinh, double) = (kh.sinh().powi(2), (2.0 * kh).sinh());
        let area = 0.5 * std::f64::consts::PI * 0.04 * 0.04 * (1.0 - 1.0 / (xi * xi));
        let (along, up) = (0.5 * kh + 0.25 * double, 0.25 * double - 0.5 * kh);
        let side = std::f64::consts::PI * 0.04 / (k * sinh) * (along / (xi * xi) + up);
        let wetted = side + area / sinh;
        let layer = (0.5 * nu * free).sqrt() * wetted * k * kh.tanh() / (2.0 * area);
        assert!((frequency / (free - layer) - 1.0).abs() < 0.01, "{frequency}");
        assert!((damping / (layer + 2.0 * nu * k * k) - 1.0).abs() < 0.15, "{damping}");
    }

    #[test]
    fn a_wall_that_slips_lets_the_wave_ring_faster_and_a_drag_ends_it_sooner() {
        let [plain, fades] = ringing(&LaboratoryGlass::plain(0.05));
        let mut slips = LaboratoryGlass::plain(0.05);
        slips.liquid.slip_m = 0.003;
        let [faster, slower] = ringing(&slips);
        // The layer's lowering falls to 1/(1 + 2 s + 2 s^2) of 0.50, its damping to (1 + 2 s)/(1 + 2 s + 2 s^2), s = 1.45.
        assert!((faster - plain - 0.44).abs() < 0.03, "{plain} to {faster}");
        assert!((fades - slower - 0.26).abs() < 0.04, "{fades} to {slower}");
        let mut foams = LaboratoryGlass::plain(0.05);
        foams.line.foam = 0.03;
        let [_, sooner] = ringing(&foams);
        assert!(sooner > 1.2 * fades, "{fades} to {sooner}");
    }
}
