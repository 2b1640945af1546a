//! Rates of change of density and velocity, from the sums over pairs of [`continuity`] and [`momentum`].
//!
//! Pressure and continuity are conjugate, so the pairs exchange kinetic and compressive energy exactly, but for rounding. Walls are images
//! ([`crate::walls`]).

mod continuity;
mod friction;
mod legendre;
mod links;
mod momentum;

pub(crate) use friction::Friction;
pub(crate) use legendre::{Factors, MOST, nearest_part, needed, reach};

use crate::corrections::{Corrected, Gradients, Moments, NOISE, PositionDensity, completion};
use crate::frame::Body;
use crate::particles::lanes::{Lane, Single, row};
use crate::particles::{CHUNKS, Fluid, Kernel, LIGHT, Neighbours, Particle, retain};
use crate::walls::{Sticking, Walls};
use continuity::{Continuity, DELTA};
use meniscus_data::recording::Glass;
use momentum::Momentum;
use rayon::prelude::*;

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
    /// Largest rate at which sound lets a particle swing, 1/s ([`crate::corrections::corrected`]).
    pub(crate) fastest: f64,
    /// Whether liquid splashes, so that what the particles see changes fast.
    pub(crate) splash: bool,
    rate_buffers: Vec<Vec<Single<4>>>,
    force_buffers: Vec<Vec<Single<8>>>,
    /// Particles and images as the sums read them.
    particle: Vec<Single<8>>,
    image: Vec<Single<8>>,
    moments: Moments,
    gradients: Gradients,
    corrected: Corrected,
    /// Density of the positions, and its recall.
    pub(super) position_density: PositionDensity,
    /// `c_i mu_i`, Pa s.
    drag: Vec<f64>,
    /// Friction of a liquid that is too thick for an explicit step.
    pub(crate) friction: Option<Friction>,
    /// Volume strain rate 1/s, diffusive density rate kg/m3/s, and `3/c_i`.
    pub(crate) rate: Vec<[f64; 3]>,
    /// Force N (3), dissipated power W, squared shear rate 1/s2.
    pub(crate) force: Vec<[f64; 5]>,
}

/// Fills `out` with the particles in single precision.
fn rounded(particles: &[Particle], out: &mut Vec<Single<8>>) {
    particles.par_iter().with_min_len(LIGHT).map(|p| row(p, p.p)).collect_into_vec(out);
}

impl Forces {
    /// Sums for `particles` particles.
    pub(crate) fn new(kernel: Kernel, sound: f64, rest_density: f64, particles: usize) -> Self {
        Self {
            kernel,
            sound,
            rest_density,
            pressed: Vec::new(),
            fastest: 0.0,
            splash: false,
            rate_buffers: vec![Vec::new(); CHUNKS],
            force_buffers: vec![Vec::new(); CHUNKS],
            particle: Vec::new(),
            image: Vec::new(),
            moments: Moments::new(particles),
            gradients: Gradients::new(particles),
            corrected: Corrected::new(particles),
            position_density: PositionDensity::new(particles),
            drag: vec![0.0; particles],
            friction: None,
            rate: vec![[0.0, 0.0, 3.0]; particles],
            force: vec![[0.0; 5]; particles],
        }
    }

    /// Keeps the particles that are in `keep`.
    pub(crate) fn retain(&mut self, keep: &[bool]) {
        let Self { pressed, moments, gradients, corrected, position_density, drag, rate, force, .. } = self;
        // The next density rates come before the surface presses anew.
        retain(pressed, keep);
        moments.retain(keep);
        retain(&mut gradients.g, keep);
        corrected.retain(keep);
        position_density.retain(keep);
        retain(drag, keep);
        retain(rate, keep);
        retain(force, keep);
    }

    /// Fills `rate` from the present positions, velocities and pressures under the body force `body`.
    pub(crate) fn density_rates(&mut self, lists: &Neighbours, liquid: &Fluid, walls: &Walls, body: &Body) {
        self.corrected.press(&self.pressed);
        rounded(&liquid.particle, &mut self.particle);
        rounded(&walls.image, &mut self.image);
        let pairs = Continuity {
            kernel: self.kernel.single(),
            lists,
            particle: &self.particle,
            image: &self.image,
            matrix: &self.corrected.pressed,
            body,
            rest_density: self.rest_density,
            diffusion: f32::of(-2.0 * DELTA * self.kernel.h / self.sound),
        };
        lists.sum(&mut self.rate_buffers, &mut self.rate, &pairs);
        for (rate, recall) in self.rate.iter_mut().zip(&self.position_density.recall) {
            rate[1] += recall;
        }
    }

    /// Forms anew what the particles see, in a glass with the rim at `rim_m`.
    fn look(&mut self, lists: &Neighbours, liquid: &Fluid, walls: &Walls, rim_m: f64, jitters: bool) {
        let (kernel, rest, sound) = (self.kernel, self.rest_density, self.sound);
        self.moments.form(&kernel, lists, liquid, walls, |p| rest + p / (sound * sound));
        let seen = self.moments.seen();
        let Self { corrected, position_density, gradients, fastest, .. } = self;
        rayon::join(
            || {
                // Within a kernel of the rim a particle lacks neighbours above the wall, too.
                corrected.update(seen.clone(), &liquid.particle, rim_m - kernel.support2.sqrt());
                *fastest = corrected.fastest(seen.clone(), sound);
            },
            || {
                position_density.update(seen.clone(), kernel.h, liquid);
                if jitters {
                    gradients.update(seen.clone());
                }
            },
        );
    }

    /// Fills `force` (without the body force) from the present state of the liquid in `glass`, to whose walls it sticks as
    /// `sticking` says, after a step of `dt` seconds.
    pub(crate) fn forces(
        &mut self,
        lists: &Neighbours,
        liquid: &Fluid,
        walls: &mut Walls,
        glass: &Glass,
        sticking: Sticking,
        dt: f64,
    ) {
        let Fluid { particle, viscosity, .. } = liquid;
        for ((drag, mu), [_, _, seen]) in self.drag.iter_mut().zip(viscosity).zip(&self.rate) {
            *drag = mu * completion(*seen);
        }
        let noise = NOISE * self.kernel.h * self.sound * self.rest_density;
        let jitters = viscosity.iter().any(|mu| *mu < noise);
        if self.moments.due(dt, self.splash) {
            self.look(lists, liquid, walls, glass.rim_m, jitters);
        }
        self.corrected.weigh(particle, &self.drag);
        if let Some(friction) = &mut self.friction {
            // The stages need the maps anyway.
            let maps = friction.maps();
            walls.map(glass, liquid, sticking, maps);
            walls.rub_by(maps, particle);
        } else {
            walls.rub(glass, liquid, sticking);
        }
        walls.press(glass, particle, &self.corrected.l);
        rounded(particle, &mut self.particle);
        let pairs = Momentum {
            kernel: self.kernel.single(),
            lists,
            particle: &self.particle,
            walls,
            pressure: &self.corrected.pressure,
            drag: &self.drag,
            gradients: &self.gradients,
            noise: jitters.then_some(f32::of(noise)),
            rubs: f32::from(u8::from(self.friction.is_none())),
            soft: f32::of(0.01 * self.kernel.h * self.kernel.h),
        };
        lists.sum(&mut self.force_buffers, &mut self.force, &pairs);
        if let Some(friction) = &mut self.friction {
            friction.form(&pairs, &liquid.mass);
        }
        for (force, [_, _, seen]) in self.force.iter_mut().zip(&self.rate) {
            force[4] *= completion(*seen);
        }
    }

    /// Accelerations of the particles under `body` and under what presses on the surface, from the last `forces`.
    pub(crate) fn accelerations(&self, liquid: &mut Fluid, body: &Body) {
        let Fluid { particle, acceleration, mass, .. } = liquid;
        let parts = acceleration.par_iter_mut().zip(mass).zip(&self.force).zip(particle).enumerate();
        parts.with_min_len(LIGHT).for_each(|(i, (((a, m), f), p))| {
            let g = if body.turns() { body.at(&p.x, &p.v) } else { body.uniform };
            let [_, a_x, a_y] = self.pressed.get(i).copied().unwrap_or_default();
            *a = [f[0] / *m + g[0] + a_x, f[1] / *m + g[1] + a_y, f[2] / *m + g[2]];
        });
    }
}
