//! Rates of change of density and velocity: sums over pairs of neighbours.
//!
//! With `x = x_i - x_j`, `v = v_i - v_j`, `V = m/rho`, `grad W = F x`, `s = (v.x)/(r^2 + 0.01 h^2)`:
//! ```text
//! continuity   rho_i' = rho_i tr(L_i sum_j V_j F x (x) v)  +  sum_j V_j D_ij  +  what `places` calls back,
//! diffusion    D_ij = -2 delta h c0 F [ (p_j - p_i) - rho0 g.(x_j - x_i) ] / c0^2
//! momentum     m_i v_i' = -sum_j V_i V_j (p_i L_i + p_j L_j) F x  +  sum_j V_i V_j K (c_i mu_i + c_j mu_j)/2 F s x  +  m_i g
//! surface      c_i = 3 / -sum_j V_j F r^2
//! heat         each of a pair gains half of   -V_i V_j K (c_i mu_i + c_j mu_j)/2 F s v.x
//! shear rate   rate_i^2 = -(K/2) c_i sum_j V_j F s v.x   -> 2 D:D in the continuum
//! ```
//! `L` makes gradients exact up to the free surface ([`super::corrected`]). Pressure and continuity are conjugate, so the
//! pairs exchange kinetic and compressive energy exactly. Sources: diffusion, Fourtakas et al. 2019 (Computers & Fluids 190, 346); viscosity,
//! Monaghan and Gingold 1983 with K = 2 (d + 2) = 10 (Violeau 2009). `c_i` is 1 in the bulk and
//! about 2 at a free surface, where half of the neighbours are missing: without it the surface layer
//! dissipates half of what it should (glycerine's first mode 7 % too little without walls' friction).
//! The sum over an even function of direction needs no other correction. Walls are images
//! ([`super::walls`]) and have no diffusion. The friction of what is not smooth is that of
//! [`super::smooth`].

use super::corrected::{Corrected, strain, times, trace};
use super::frame::Body;
use super::kernel::Kernel;
use super::moments::Moments;
use super::neighbours::{CHUNKS, Neighbours};
use super::places::Places;
use super::smooth::{Gradients, NOISE};
use super::state::{Fluid, Particle};
use super::walls::Walls;
use crate::offline::prelude::*;
use crate::offline::recording::Glass;
use rayon::prelude::*;

/// The factor of the viscous pair force in three dimensions, 2 (d + 2).
const K: f64 = 10.0;

/// Strength of the density diffusion.
const DELTA: f64 = 0.1;

/// The largest `c_i`: a lone drop has hardly a neighbour.
const LARGEST_C: f64 = 3.0;

/// Constants and scratch memory of the sums.
#[derive(Clone, Debug)]
pub(crate) struct Forces {
    /// The kernel.
    pub(crate) kernel: Kernel,
    /// Numerical speed of sound, m/s.
    pub(crate) sound: f64,
    /// Density at zero pressure, kg/m3.
    pub(crate) rest_density: f64,
    /// Pressure on the surface above each particle, Pa, and the acceleration along x and y that stands for
    /// it (see `effects::columns`); empty where nothing presses.
    pub(crate) pressed: Vec<[f64; 3]>,
    rate_buffers: Vec<Vec<[f64; 3]>>,
    force_buffers: Vec<Vec<[f64; 5]>>,
    moments: Moments,
    gradients: Gradients,
    corrected: Corrected,
    /// What calls densities back to the places.
    pub(super) places: Places,
    /// `c_i mu_i`, Pa s.
    drag: Vec<f64>,
    /// Volume strain rate 1/s, diffusive density rate kg/m3/s, and `3/c_i`.
    pub(crate) rate: Vec<[f64; 3]>,
    /// Force N (3), dissipated power W, squared shear rate 1/s2.
    pub(crate) force: Vec<[f64; 5]>,
}

/// Separation and its square, relative velocity along it.
#[inline]
pub(crate) fn pair(a: &Particle, b: &Particle) -> ([f64; 3], f64, f64) {
    let d = [a.x[0] - b.x[0], a.x[1] - b.x[1], a.x[2] - b.x[2]];
    let r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    let dot = (a.v[0] - b.v[0]) * d[0] + (a.v[1] - b.v[1]) * d[1] + (a.v[2] - b.v[2]) * d[2];
    (d, r2, dot)
}

/// `c_i` from `-sum_j V_j F r^2`.
pub(crate) fn completion(seen: f64) -> f64 {
    (3.0 / seen).clamp(0.0, LARGEST_C)
}

impl Forces {
    /// Sums for `particles` particles.
    pub(crate) fn new(kernel: Kernel, sound: f64, rest_density: f64, particles: usize) -> Self {
        Self {
            kernel,
            sound,
            rest_density,
            pressed: Vec::new(),
            rate_buffers: vec![Vec::new(); CHUNKS],
            force_buffers: vec![Vec::new(); CHUNKS],
            moments: Moments::new(particles),
            gradients: Gradients::new(particles),
            corrected: Corrected::new(particles),
            places: Places::new(particles),
            drag: vec![0.0; particles],
            rate: vec![[0.0, 0.0, 3.0]; particles],
            force: vec![[0.0; 5]; particles],
        }
    }

    /// Fills `rate` from the present positions, velocities and pressures under the body force `body`.
    pub(crate) fn density_rates(&mut self, lists: &Neighbours, liquid: &Fluid, walls: &Walls, body: &Body) {
        let kernel = self.kernel;
        let diffusion = -2.0 * DELTA * kernel.h / self.sound;
        let (rest_density, pressed) = (self.rest_density, &self.pressed);
        let (particle, matrix) = (&liquid.particle, &self.corrected.l);
        lists.sum(&mut self.rate_buffers, &mut self.rate, |i, out| {
            let (a, l) = (&particle[i], &matrix[i]);
            let lift = body.still(&a.x).map(|g| rest_density * g);
            let mut own = [0.0; 3];
            for &j in lists.liquid.row(i) {
                let b = &particle[j as usize];
                let (d, r2, _) = pair(a, b);
                let f = kernel.slope(r2);
                let t = strain(f, &d, a, b);
                let rest = lift[0] * d[0] + lift[1] * d[1] + lift[2] * d[2];
                // What presses on the surface is balanced by a gradient of p as the weight is.
                let above = if pressed.is_empty() { 0.0 } else { pressed[j as usize][0] - pressed[i][0] };
                let flux = diffusion * f * (b.p - a.p + rest + above);
                own[0] += b.volume * trace(l, &t);
                own[1] += b.volume * flux;
                own[2] -= b.volume * f * r2;
                let other = &mut out[j as usize];
                other[0] += a.volume * trace(&matrix[j as usize], &t);
                other[1] -= a.volume * flux;
                other[2] -= a.volume * f * r2;
            }
            for &w in lists.wall.row(i) {
                let b = &walls.image[w as usize];
                let (d, r2, _) = pair(a, b);
                let f = kernel.slope(r2);
                own[0] += b.volume * trace(l, &strain(f, &d, a, b));
                own[2] -= b.volume * f * r2;
            }
            for (o, s) in out[i].iter_mut().zip(own) {
                *o += s;
            }
        });
        for (rate, recall) in self.rate.iter_mut().zip(&self.places.recall) {
            rate[1] += recall;
        }
    }

    /// Forms what the particles see anew when it is due after a step of `dt` seconds.
    fn look(&mut self, lists: &Neighbours, liquid: &Fluid, walls: &Walls, dt: f64, jitters: bool) {
        if !self.moments.due(dt) {
            return;
        }
        let (kernel, rest, sound2) = (self.kernel, self.rest_density, self.sound * self.sound);
        self.moments.form(&kernel, lists, liquid, walls, |p| rest + p / sound2);
        let seen = self.moments.seen();
        self.corrected.update(seen.clone());
        self.places.update(seen.clone(), kernel.h, liquid);
        if jitters {
            self.gradients.update(seen);
        }
    }

    /// Fills `force` (without the body force) from the present state of the liquid in `glass`, after a step of `dt` seconds.
    pub(crate) fn forces(
        &mut self,
        lists: &Neighbours,
        liquid: &Fluid,
        walls: &mut Walls,
        glass: &Glass,
        dt: f64,
    ) {
        let kernel = self.kernel;
        let soft = 0.01 * kernel.h * kernel.h;
        let Fluid { particle, viscosity, .. } = liquid;
        for ((drag, mu), [_, _, seen]) in self.drag.iter_mut().zip(viscosity).zip(&self.rate) {
            *drag = mu * completion(*seen);
        }
        let noise = NOISE * kernel.h * self.sound * self.rest_density;
        let jitters = viscosity.iter().any(|mu| *mu < noise);
        self.look(lists, liquid, walls, dt, jitters);
        self.corrected.weigh(particle);
        walls.press(glass, particle, &self.corrected.l);
        let Self { gradients, drag, corrected, .. } = self;
        let pressure = &corrected.pressure;
        lists.sum(&mut self.force_buffers, &mut self.force, |i, out| {
            let a = &particle[i];
            let mut own = [0.0; 5];
            for &j in lists.liquid.row(i) {
                let b = &particle[j as usize];
                let (d, r2, dot) = pair(a, b);
                let f = kernel.slope(r2);
                let (both, inverse) = (a.volume * b.volume * f, 1.0 / (r2 + soft));
                let mu = 0.5 * (drag[i] + drag[j as usize]);
                let mut rub = K * mu * dot * inverse;
                if jitters && mu < noise {
                    rub += K * (noise - mu) * (dot - gradients.share(i, j as usize, &d)) * inverse;
                }
                let heat = -0.5 * both * rub * dot;
                let shear = -0.5 * K * f * dot * dot * inverse;
                let (p, q) = (&pressure[i], &pressure[j as usize]);
                let press = times(&std::array::from_fn(|k| p[k] + q[k]), &d);
                let push: [f64; 3] = std::array::from_fn(|k| both * (rub * d[k] - press[k]));
                own[0] += push[0];
                own[1] += push[1];
                own[2] += push[2];
                own[3] += heat;
                own[4] += b.volume * shear;
                let other = &mut out[j as usize];
                other[0] -= push[0];
                other[1] -= push[1];
                other[2] -= push[2];
                other[3] += heat;
                other[4] += a.volume * shear;
            }
            for &w in lists.wall.row(i) {
                let b = &walls.image[w as usize];
                let (d, r2, _) = pair(a, b);
                let f = kernel.slope(r2);
                let both = a.volume * b.volume * f;
                let own_speed = a.v[0] * d[0] + a.v[1] * d[1] + a.v[2] * d[2];
                let u = &walls.rubbing[w as usize];
                let dot = own_speed - (u[0] * d[0] + u[1] * d[1] + u[2] * d[2]);
                let sliding = dot / (r2 + soft);
                let rub = both * K * drag[i] * sliding;
                let (press, image) = (times(&pressure[i], &d), times(&walls.pressure[w as usize], &d));
                // The wall stands still, so the power of its friction is heat; so is what a round
                // mirror does not give back of the power of pressure.
                own[3] -= rub * own_speed;
                for k in 0..3 {
                    own[k] += rub * d[k] - both * (press[k] + image[k]);
                    own[3] += both * (image[k] * a.v[k] + press[k] * b.v[k]);
                }
                own[4] -= 0.5 * K * b.volume * f * sliding * dot;
            }
            for (o, s) in out[i].iter_mut().zip(own) {
                *o += s;
            }
        });
        for (force, [_, _, seen]) in self.force.iter_mut().zip(&self.rate) {
            force[4] *= completion(*seen);
        }
    }

    /// Accelerations of the particles under `body`, from the last `forces`.
    pub(crate) fn accelerations(&self, liquid: &mut Fluid, body: &Body) {
        let Fluid { particle, acceleration, mass, .. } = liquid;
        let parts = acceleration.par_iter_mut().zip(&*mass).zip(&self.force).zip(&*particle);
        parts.with_min_len(512).for_each(|(((a, m), f), p)| {
            let g = if body.turns() { body.at(&p.x, &p.v) } else { body.uniform };
            *a = [f[0] / m + g[0], f[1] / m + g[1], f[2] / m + g[2]];
        });
    }
}
