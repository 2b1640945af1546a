//! Changes that a step makes to each particle by itself: kick, drift, density, heat.
//!
//! Particles are taken in pieces of a fixed number, and the sums of the pieces are added in order: the same bits from any number of
//! threads.

use crate::Simulator;
use crate::particles::{Fluid, LIGHT, PIECE, Particle};
use crate::walls::hold;
use rayon::prelude::*;

/// Sums of a kick over the particles of a piece.
#[derive(Clone, Copy, Debug, Default)]
struct Kicked {
    /// Momentum in the middle of the kick, kg m/s.
    momentum: [f64; 3],
    /// Power of the forces in the frame of a glass that turns, W.
    turned: f64,
}

/// `x += dt v`.
fn drift(p: &mut Particle, dt: f64) {
    for (x, v) in p.x.iter_mut().zip(p.v) {
        *x += dt * v;
    }
}

impl Simulator {
    /// The first half of a step: velocities, what the walls take of them, and places.
    pub(super) fn set_off(&mut self) {
        let (glass, spacing_m, half) = (self.glass, self.spacing_m, 0.5 * self.dt);
        self.kick_and(|p, heat| {
            hold(&glass, spacing_m, p, heat);
            drift(p, half);
        });
    }

    /// Half a step of velocity.
    pub(super) fn kick(&mut self) {
        self.kick_and(|_, _| ());
    }

    /// Half a step of velocity, then `then` with each particle and its heat. The work of the moving glass is booked as the kick does it.
    fn kick_and(&mut self, then: impl Fn(&mut Particle, &mut f64) + Sync) {
        let half = 0.5 * self.dt;
        if self.forces.friction.is_some() {
            self.stages.warm(half, &mut self.fluid);
        }
        let Fluid { particle, acceleration, mass, heat, .. } = &mut self.fluid;
        let turning = &self.turning;
        let pieces = particle.par_chunks_mut(PIECE).zip(heat.par_chunks_mut(PIECE));
        let pieces = pieces.zip(acceleration.par_chunks(PIECE)).zip(mass.par_chunks(PIECE)).enumerate();
        let sums = pieces.map(|(piece, (((particles, heats), accelerations), masses))| {
            let mut sums = Kicked::default();
            let mut turning = turning.iter().skip(piece * PIECE);
            for (((p, heat), a), m) in particles.iter_mut().zip(heats).zip(accelerations).zip(masses) {
                let middle: [f64; 3] = std::array::from_fn(|k| *m * (p.v[k] + 0.5 * half * a[k]));
                sums.momentum.iter_mut().zip(middle).for_each(|(sum, of_one)| *sum += of_one);
                if let Some([e_x, e_z]) = turning.next() {
                    sums.turned += e_x * middle[0] + e_z * middle[2];
                }
                for (v, a) in p.v.iter_mut().zip(*a) {
                    *v += half * a;
                }
                then(p, heat);
            }
            sums
        });
        let sums: Vec<Kicked> = sums.collect();
        let [f_x, f_y, f_z] = std::array::from_fn(|axis| self.body.uniform[axis] - self.gravity[axis]);
        for Kicked { momentum: [x, y, z], turned } in sums {
            self.work += half * (f_x * x + f_y * y + f_z * z + turned);
        }
    }

    /// A full step of density, with what its diffusion loses as heat, and half a step of places.
    pub(super) fn densify_and_drift(&mut self) {
        let (dt, sound2, rest) = (self.dt, self.forces.sound * self.forces.sound, self.forces.rest_density);
        let Fluid { particle, mass, density, heat, .. } = &mut self.fluid;
        let thermal = density.par_iter_mut().zip(heat);
        let parts = particle.par_iter_mut().zip(mass).zip(thermal).zip(&self.forces.rate).with_min_len(LIGHT);
        parts.for_each(|(((p, m), (rho, heat)), [strain, diffusion, _])| {
            // The energy of compression changes by p/rho^2 d(rho).
            *heat -= dt * p.p / (*rho * *rho) * diffusion;
            *rho += dt * (*rho * strain + diffusion);
            p.p = sound2 * (*rho - rest);
            p.volume = *m / *rho;
            drift(p, 0.5 * dt);
        });
    }

    /// Viscous heating over a full step.
    pub(super) fn gain_heat(&mut self) {
        let Fluid { mass, heat, .. } = &mut self.fluid;
        for ((heat, m), f) in heat.iter_mut().zip(mass).zip(&self.forces.force) {
            *heat += self.dt * f[3] / *m;
        }
    }

    /// The viscosity at the last rate of shear.
    pub(crate) fn thin(&mut self) {
        let rheology = self.liquid.rheology;
        if !rheology.is_newtonian() {
            let parts = self.fluid.viscosity.par_iter_mut().zip(&self.forces.force).with_min_len(LIGHT);
            parts.for_each(|(mu, f)| *mu = rheology.viscosity(f[4].max(0.0).sqrt()));
        }
    }
}
