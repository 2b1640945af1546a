//! Recordings of an ideal slosh in closed form: the modes (1,1) and (1,2) of a liquid in an upright
//! cylinder (Ibrahim, Liquid Sloshing Dynamics, 2005, section 1.2), damped, driven by the glass.
//!
//! phi_n = J1(e_n r / R) cos(theta) cosh(k_n z) / cosh(k_n h), J1'(e_n) = 0, k_n = e_n / R;
//! eta_n' = k tanh(k h) phi_n, phi_n' = -g eta_n - a c_n - 2 zeta omega phi_n, x = sum c_n J1 cos.

use meniscus::latent::decoder::GROUP_COMPONENTS;
use meniscus::surface::{POINTS, profile_abscissa};
use meniscus::units::{FRAME_INTERVAL_S, GRAVITY_M_S2};
use meniscus_data::recording::{
    COLUMNS, EnergyBook, Glass, LAYERS, Lattice, Provenance, Recording, STATE, States, TRACERS, WALL_POINTS,
    group_range, wall_azimuth,
};

const GLASS: Glass = Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11, taper: 0.0 };
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

/// A recording of `frames` frames.
pub(crate) fn recording(frames: usize, stroke_m: f64, seed: u64) -> Recording {
    let modes = ZEROS.map(Mode::new);
    let lattice = Lattice::new(&GLASS);
    let tracers: Vec<[f64; 3]> = (0..COLUMNS)
        .flat_map(|c| (0..LAYERS).map(move |l| (c, l)))
        .map(|(c, l)| lattice.tracer(c, l, GLASS.fill_m))
        .collect();
    let patterns: Vec<_> = modes
        .iter()
        .map(|m| tracers.iter().map(|&p| (m.potential(p), m.gradient(p), m.hessian(p))).collect::<Vec<_>>())
        .collect();
    let glass_x_m = motion(frames, stroke_m, seed);
    let at = |n: isize| glass_x_m[n.clamp(0, frames as isize - 1) as usize];
    let acceleration_m_s2: Vec<f64> = (0..frames as isize)
        .map(|n| (at(n + 1) - 2.0 * at(n) + at(n - 1)) / FRAME_INTERVAL_S.powi(2))
        .collect();

    let mass = DENSITY * std::f64::consts::PI * GLASS.radius_m.powi(2) * GLASS.fill_m;
    let mut out = Recording {
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
        glass_x_m: glass_x_m.clone(),
        acceleration_m_s2: acceleration_m_s2.clone(),
        glass_y_m: vec![0.0; frames],
        glass_z_m: vec![0.0; frames],
        tilt_rad: vec![0.0; frames],
        column_m: Vec::new(),
        wall_m: Vec::new(),
        profile_m: Vec::new(),
        energy: Vec::new(),
        states: States::Full(Vec::new()),
    };
    let mut full = Vec::with_capacity(frames * STATE);
    let (mut eta, mut phi, mut heat, mut work) = ([0.0; 2], [0.0; 2], 0.0, 0.0);
    for (n, &a) in acceleration_m_s2.iter().enumerate() {
        // Between frames n - 1 and n the acceleration goes linearly from one to the other.
        let before = if n == 0 { a } else { acceleration_m_s2[n - 1] };
        const PARTS: usize = 40;
        for part in 0..if n == 0 { 0 } else { PARTS } {
            let (dt, now) =
                (FRAME_INTERVAL_S / PARTS as f64, before + (a - before) * (part as f64 + 0.5) / PARTS as f64);
            for (k, m) in modes.iter().enumerate() {
                let friction = 2.0 * DAMPING * m.omega;
                phi[k] += dt * (-GRAVITY_M_S2 * eta[k] - now * m.drive - friction * phi[k]);
                eta[k] += dt * m.lift * phi[k];
                let weight = DENSITY * m.norm * m.lift * phi[k] * dt;
                heat += weight * friction * phi[k];
                work -= weight * now * m.drive;
            }
        }
        let surface = |x: f64, y: f64| -> f64 {
            modes.iter().zip(eta).map(|(m, e)| e * m.potential([x, y, GLASS.fill_m])).sum::<f64>()
                + GLASS.fill_m
        };
        out.column_m.extend(lattice.columns.iter().map(|c| surface(c[0], c[1]) as f32));
        let wall = |angle: f64| surface(GLASS.radius_m * angle.cos(), GLASS.radius_m * angle.sin()) as f32;
        out.wall_m.extend((0..WALL_POINTS).map(|k| wall(wall_azimuth(k))));
        out.profile_m.extend((0..POINTS).map(|k| wall(-profile_abscissa(k).acos())));
        let energy = |f: &dyn Fn(&Mode, usize) -> f64| {
            modes.iter().enumerate().map(|(k, m)| 0.5 * DENSITY * m.norm * f(m, k)).sum::<f64>()
        };
        out.energy.push(EnergyBook {
            kinetic: energy(&|m, k| m.lift * phi[k] * phi[k]),
            potential: energy(&|_, k| GRAVITY_M_S2 * eta[k] * eta[k]),
            internal: heat,
            work,
        });

        let mut state = vec![0.0_f32; STATE];
        for (i, &[x, _, z]) in tracers.iter().enumerate() {
            let column = i / LAYERS;
            let [cx, cy] = lattice.columns[column];
            let place = lattice.tracer(column, i % LAYERS, surface(cx, cy));
            let (mut velocity, mut normal, mut shear) = ([0.0; 3], [0.0; 3], [0.0; 3]);
            // -p = rho (phi' + a x) without its hydrostatic part; stress = -p + 2 mu grad grad phi.
            let mut tension = DENSITY * a * x - DENSITY * GRAVITY_M_S2 * (GLASS.fill_m - z);
            for (k, m) in modes.iter().enumerate() {
                let (potential, gradient, hessian) = &patterns[k][i];
                let rate = -GRAVITY_M_S2 * eta[k] - a * m.drive - 2.0 * DAMPING * m.omega * phi[k];
                tension += DENSITY * rate * potential;
                for axis in 0..3 {
                    velocity[axis] += phi[k] * gradient[axis];
                    normal[axis] += 2.0 * VISCOSITY * phi[k] * hessian[axis];
                    shear[axis] += 2.0 * VISCOSITY * phi[k] * hessian[3 + axis];
                }
            }
            normal.iter_mut().for_each(|s| *s += tension);
            let values: [&[f64]; 5] = [&place, &velocity, &[heat / mass], &normal, &shear];
            for (group, values) in values.into_iter().enumerate() {
                let start = group_range(group).start + i * GROUP_COMPONENTS[group];
                state[start..].iter_mut().zip(values).for_each(|(s, v)| *s = *v as f32);
            }
        }
        full.extend_from_slice(&state);
    }
    assert_eq!(full.len(), frames * TRACERS * 13);
    out.states = States::Full(full);
    out
}
