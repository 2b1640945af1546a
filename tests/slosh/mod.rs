//! Recordings of an ideal slosh in closed form: the modes (1,1) and (1,2) of a liquid in an upright
//! cylinder (Ibrahim, Liquid Sloshing Dynamics, 2005, section 1.2), damped, driven by the glass.
//!
//! phi_n = J1(e_n r / R) cos(theta) cosh(k_n z) / cosh(k_n h), J1'(e_n) = 0, k_n = e_n / R;
//! eta_n' = k tanh(k h) phi_n, phi_n' = -g eta_n - a c_n - 2 zeta omega phi_n, x = sum c_n J1 cos.

use meniscus::blob::KnownGroups;
use meniscus::latent::decoder::GROUP_COMPONENTS;
use meniscus::surface::{POINTS, profile_abscissa};
use meniscus::units::{FRAME_INTERVAL_S, GRAVITY_M_S2};
use meniscus_data::glass::WallShape;
use meniscus_data::recording::{
    EnergyBook, Glass, LAYERS, Lattice, Provenance, Recording, STATE, States, TRACERS, WALL_POINTS,
    group_range, wall_azimuth,
};

const GLASS: Glass = Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11, wall: WallShape::UPRIGHT };
const DENSITY: f64 = 1260.0;
const VISCOSITY: f64 = 0.5;
const DAMPING: f64 = 0.12;
/// First two zeros of J1'.
const ZEROS: [f64; 2] = [1.841_183_781_340_659, 5.331_442_773_525_033];

struct Mode {
    wave: f64,
    lift: f64,
    omega: f64,
    drive: f64,
    norm: f64,
}

impl Mode {
    fn new(zero: f64) -> Self {
        let radius = GLASS.radius_m;
        let wave = zero / radius;
        let lift = wave * (wave * GLASS.fill_m).tanh();
        let peak = libm::j1(zero);
        Self {
            wave,
            lift,
            omega: (GRAVITY_M_S2 * lift).sqrt(),
            drive: 2.0 * radius / ((zero * zero - 1.0) * peak),
            norm: 0.5 * std::f64::consts::PI * radius * radius * (1.0 - 1.0 / (zero * zero)) * peak * peak,
        }
    }

    /// The potential of unit amplitude at a point.
    fn potential(&self, [x, y, z]: [f64; 3]) -> f64 {
        let r = x.hypot(y).max(1e-12);
        libm::j1(self.wave * r) * (x / r) * (self.wave * z).cosh() / (self.wave * GLASS.fill_m).cosh()
    }

    fn gradient(&self, at: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| central(at, i, 1e-5, |p| self.potential(p)))
    }

    /// Second derivatives xx, yy, zz, xy, yz, zx.
    fn hessian(&self, at: [f64; 3]) -> [f64; 6] {
        [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]
            .map(|(i, j)| central(at, j, 1e-4, |p| central(p, i, 1e-4, |q| self.potential(q))))
    }
}

fn central(at: [f64; 3], axis: usize, step: f64, f: impl Fn([f64; 3]) -> f64) -> f64 {
    let shifted = |by: f64| {
        let mut p = at;
        p[axis] += by;
        f(p)
    };
    (shifted(step) - shifted(-step)) / (2.0 * step)
}

/// Position of the glass: smooth moves of `stroke_m` there and back, `seed` choosing their times.
fn motion(frames: usize, stroke_m: f64, seed: u64) -> Vec<f64> {
    // Minimum jerk (Flash and Hogan 1985).
    let smooth = |t: f64| {
        t.clamp(0.0, 1.0).powi(3) * (10.0 - 15.0 * t.clamp(0.0, 1.0) + 6.0 * t.clamp(0.0, 1.0).powi(2))
    };
    let draw = |k: u64| ((seed * 7919 + k) as f64 * 12.9898).sin().abs().fract();
    (0..frames)
        .map(|n| {
            let t = n as f64 * FRAME_INTERVAL_S;
            let moves = (0..8).map(|k| {
                let (start, length) =
                    (0.3 + 0.55 * k as f64 + 0.25 * draw(3 * k), 0.18 + 0.2 * draw(3 * k + 1));
                let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                sign * stroke_m * smooth((t - start) / length)
            });
            moves.sum()
        })
        .collect()
}

/// Potential, its gradient and its Hessian (xx, yy, zz, xy, yz, zx) of one mode at one tracer.
type Pattern = (f64, [f64; 3], [f64; 6]);

/// Motion of the two modes, with heat and work since the start.
#[derive(Default)]
struct Motion {
    eta: [f64; 2],
    phi: [f64; 2],
    heat: f64,
    work: f64,
}

impl Motion {
    /// Integrates one frame interval in small parts, while the acceleration goes linearly from `before` to `after`.
    fn advance(&mut self, modes: &[Mode; 2], before: f64, after: f64) {
        const PARTS: usize = 40;
        for part in 0..PARTS {
            let dt = FRAME_INTERVAL_S / PARTS as f64;
            let now = before + (after - before) * (part as f64 + 0.5) / PARTS as f64;
            for (k, m) in modes.iter().enumerate() {
                let friction = 2.0 * DAMPING * m.omega;
                self.phi[k] += dt * (-GRAVITY_M_S2 * self.eta[k] - now * m.drive - friction * self.phi[k]);
                self.eta[k] += dt * m.lift * self.phi[k];
                let weight = DENSITY * m.norm * m.lift * self.phi[k] * dt;
                self.heat += weight * friction * self.phi[k];
                self.work -= weight * now * m.drive;
            }
        }
    }

    /// Height of the surface over (x, y), m.
    fn surface(&self, modes: &[Mode; 2], x: f64, y: f64) -> f64 {
        modes.iter().zip(self.eta).map(|(m, e)| e * m.potential([x, y, GLASS.fill_m])).sum::<f64>()
            + GLASS.fill_m
    }

    /// Energies of the two modes together.
    fn energy(&self, modes: &[Mode; 2]) -> EnergyBook {
        let sum = |f: &dyn Fn(&Mode, usize) -> f64| {
            modes.iter().enumerate().map(|(k, m)| 0.5 * DENSITY * m.norm * f(m, k)).sum::<f64>()
        };
        EnergyBook {
            kinetic: sum(&|m, k| m.lift * self.phi[k] * self.phi[k]),
            potential: sum(&|_, k| GRAVITY_M_S2 * self.eta[k] * self.eta[k]),
            internal: self.heat,
            work: self.work,
            spilled: 0.0,
        }
    }

    /// Full state on the tracers of `lattice` under the acceleration `a`.
    fn state(&self, modes: &[Mode; 2], lattice: &Lattice, patterns: &[[Pattern; 2]], a: f64) -> Vec<f32> {
        let mass = DENSITY * std::f64::consts::PI * GLASS.radius_m.powi(2) * GLASS.fill_m;
        let mut state = vec![0.0_f32; STATE];
        for (i, pattern) in patterns.iter().enumerate() {
            let column = i / LAYERS;
            let [x, _, z] = lattice.tracer(column, i % LAYERS, GLASS.fill_m);
            let [cx, cy] = lattice.columns[column];
            let place = lattice.tracer(column, i % LAYERS, self.surface(modes, cx, cy));
            let (mut velocity, mut normal, mut shear) = ([0.0; 3], [0.0; 3], [0.0; 3]);
            // -p = rho (phi' + a x) without its hydrostatic part; stress = -p + 2 mu grad grad phi.
            let mut tension = DENSITY * a * x - DENSITY * GRAVITY_M_S2 * (GLASS.fill_m - z);
            for (k, (m, (potential, gradient, hessian))) in modes.iter().zip(pattern).enumerate() {
                let rate = -GRAVITY_M_S2 * self.eta[k] - a * m.drive - 2.0 * DAMPING * m.omega * self.phi[k];
                tension += DENSITY * rate * potential;
                for axis in 0..3 {
                    velocity[axis] += self.phi[k] * gradient[axis];
                    normal[axis] += 2.0 * VISCOSITY * self.phi[k] * hessian[axis];
                    shear[axis] += 2.0 * VISCOSITY * self.phi[k] * hessian[3 + axis];
                }
            }
            normal.iter_mut().for_each(|s| *s += tension);
            let values: [&[f64]; 5] = [&place, &velocity, &[self.heat / mass], &normal, &shear];
            for (group, values) in values.into_iter().enumerate() {
                let start = group_range(group).start + i * GROUP_COMPONENTS[group];
                state[start..].iter_mut().zip(values).for_each(|(s, v)| *s = *v as f32);
            }
        }
        state
    }
}

/// A recording of `frames` frames.
pub(crate) fn recording(frames: usize, stroke_m: f64, seed: u64) -> Recording {
    let modes = ZEROS.map(Mode::new);
    let lattice = Lattice::new(&GLASS);
    let tracers: Vec<[f64; 3]> =
        (0..TRACERS).map(|i| lattice.tracer(i / LAYERS, i % LAYERS, GLASS.fill_m)).collect();
    let pattern =
        |&p: &[f64; 3]| [0, 1].map(|k| (modes[k].potential(p), modes[k].gradient(p), modes[k].hessian(p)));
    let patterns: Vec<[Pattern; 2]> = tracers.iter().map(pattern).collect();
    let glass_x_m = motion(frames, stroke_m, seed);
    let at = |n: isize| glass_x_m[n.clamp(0, frames as isize - 1) as usize];
    let acceleration_m_s2: Vec<f64> = (0..frames as isize)
        .map(|n| (at(n + 1) - 2.0 * at(n) + at(n - 1)) / FRAME_INTERVAL_S.powi(2))
        .collect();
    let mut out = still(frames, stroke_m, seed);
    let mut full = Vec::with_capacity(frames * STATE);
    let mut liquid = Motion::default();
    for (n, &a) in acceleration_m_s2.iter().enumerate() {
        if n > 0 {
            liquid.advance(&modes, acceleration_m_s2[n - 1], a);
        }
        out.column_m.extend(lattice.columns.iter().map(|c| liquid.surface(&modes, c[0], c[1]) as f32));
        let wall = |angle: f64| {
            liquid.surface(&modes, GLASS.radius_m * angle.cos(), GLASS.radius_m * angle.sin()) as f32
        };
        out.wall_m.extend((0..WALL_POINTS).map(|k| wall(wall_azimuth(k))));
        out.profile_m.extend((0..POINTS).map(|k| wall(-profile_abscissa(k).acos())));
        out.energy.push(liquid.energy(&modes));
        full.extend_from_slice(&liquid.state(&modes, &lattice, &patterns, a));
    }
    assert_eq!(full.len(), frames * TRACERS * 13);
    Recording { glass_x_m, acceleration_m_s2, states: States::Full(full), ..out }
}

/// A recording of `frames` frames without any motion or state yet.
fn still(frames: usize, stroke_m: f64, seed: u64) -> Recording {
    Recording {
        glass: GLASS,
        provenance: Provenance {
            liquid: String::from("ideal"),
            density_kg_m3: DENSITY,
            motion: format!("smooth moves of {stroke_m} m"),
            seed,
            command: String::from("cargo test"),
            spacing_m: 0.0,
            pivot_m: [0.0; 2],
            effects: Vec::new(),
        },
        glass_x_m: vec![0.0; frames],
        acceleration_m_s2: vec![0.0; frames],
        glass_y_m: vec![0.0; frames],
        glass_z_m: vec![0.0; frames],
        tilt_rad: vec![0.0; frames],
        column_m: Vec::new(),
        wall_m: Vec::new(),
        profile_m: Vec::new(),
        energy: Vec::new(),
        spilled_m3: vec![0.0; frames],
        states: States::Full(Vec::new()),
        known: KnownGroups::ALL,
    }
}
