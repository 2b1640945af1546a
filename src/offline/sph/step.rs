//! One step in time: kick, drift, kick.
//!
//! ```text
//! v  += dt/2 a(t)                 x += dt/2 v
//! rho += dt rho'(x, v)            at the middle of the step
//! x  += dt/2 v                    a(t + dt) from x, rho, v;   v += dt/2 a(t + dt)
//! ```
//! (Monaghan 2005; Adami et al. 2012.) Density lives where the velocity is half a step away, so
//! sound is integrated by a leap-frog and neither grows nor decays by the scheme itself.

use super::Error;
use super::Simulator;
use super::state::Fluid;
use super::walls::{extrapolate, hold};
use crate::offline::prelude::*;
use crate::units::GRAVITY_M_S2;

/// The body force in the frame of a glass accelerated by `a_x`: `(-a_x, 0, -g)`, m/s2.
fn body_force(a_x: f64) -> [f64; 3] {
    [-a_x, 0.0, -GRAVITY_M_S2]
}

impl Simulator {
    /// Advances by one step; `acceleration` gives the acceleration of the glass at a time.
    ///
    /// # Errors
    /// When a particle leaves the glass or a number is no longer finite.
    pub fn step(&mut self, acceleration: impl Fn(f64) -> f64) -> Result<(), Error> {
        let dt = self.dt;
        self.kick();
        hold(&self.glass, self.spacing_m, &mut self.fluid);
        self.drift();
        self.refresh_lists()?;
        let middle = body_force(acceleration(self.time + 0.5 * dt));
        self.forces.density_rates(&self.lists, &self.fluid, &self.wall, middle);
        self.densify();
        self.drift();
        self.time += dt;
        self.accelerate(acceleration(self.time));
        self.gain_heat();
        self.kick();
        Ok(())
    }

    /// Forces and accelerations at the present time, for a glass accelerated by `a_x`.
    pub(crate) fn accelerate(&mut self, a_x: f64) {
        let g = body_force(a_x);
        extrapolate(&self.forces.kernel, &self.lists, &self.fluid, g, &mut self.wall);
        self.forces.forces(&self.lists, &self.fluid, &self.wall);
        self.forces.accelerations(&mut self.fluid, g);
        self.glass_acceleration = a_x;
    }

    /// Half a step of velocity; the work of the inertial force is booked as the kick does it.
    fn kick(&mut self) {
        let half = 0.5 * self.dt;
        let Fluid { particle, acceleration, mass, .. } = &mut self.fluid;
        let mut momentum = 0.0;
        for ((p, a), m) in particle.iter_mut().zip(acceleration).zip(mass) {
            momentum += *m * (p.v[0] + 0.5 * half * a[0]);
            for (v, a) in p.v.iter_mut().zip(*a) {
                *v += half * a;
            }
        }
        self.work -= self.glass_acceleration * half * momentum;
    }

    /// Half a step of position.
    fn drift(&mut self) {
        let half = 0.5 * self.dt;
        for p in &mut self.fluid.particle {
            for (x, v) in p.x.iter_mut().zip(p.v) {
                *x += half * v;
            }
        }
    }

    /// A full step of density, and what the diffusion of density loses as heat.
    fn densify(&mut self) {
        let (dt, sound2, rest) = (self.dt, self.forces.sound * self.forces.sound, self.forces.rest_density);
        let Fluid { particle, mass, density, heat, .. } = &mut self.fluid;
        let parts = particle.iter_mut().zip(mass).zip(density.iter_mut().zip(heat)).zip(&self.forces.rate);
        for (((p, m), (rho, heat)), [strain, diffusion]) in parts {
            // The energy of compression changes by p/rho^2 d(rho).
            *heat -= dt * p.p / (*rho * *rho) * diffusion;
            *rho += dt * (*rho * strain + diffusion);
            p.p = sound2 * (*rho - rest);
            p.volume = *m / *rho;
        }
    }

    /// Viscous heating over a full step, and the viscosity at the new rate of shear.
    fn gain_heat(&mut self) {
        let Fluid { mass, heat, viscosity, .. } = &mut self.fluid;
        for (((heat, m), f), mu) in heat.iter_mut().zip(mass).zip(&self.forces.force).zip(viscosity) {
            *heat += self.dt * f[3] / *m;
            if !self.liquid.rheology.is_newtonian() {
                *mu = self.liquid.rheology.viscosity(f[4].max(0.0).sqrt());
            }
        }
    }

    /// Rebuilds the neighbour lists when due, and refuses escapes.
    fn refresh_lists(&mut self) -> Result<(), Error> {
        if self.lists.stale(&self.fluid.particle) {
            self.check_inside()?;
            self.lists.rebuild(&self.fluid.particle, &self.wall);
        }
        Ok(())
    }

    /// Whether every particle is finite and inside the glass, within half a spacing.
    pub(crate) fn check_inside(&self) -> Result<(), Error> {
        let slack = 0.5 * self.spacing_m;
        let (glass, time_s) = (self.glass, self.time);
        let inside = |x: &[f64; 3]| {
            x[0].hypot(x[1]) <= glass.radius_m + slack && x[2] >= -slack && x[2] <= glass.rim_m
        };
        let mut outside =
            self.fluid.particle.iter().enumerate().filter(|(_, p)| !inside(&p.x)).map(|(i, p)| (i, p.x));
        match outside.next() {
            None => Ok(()),
            Some((particle, position_m)) if position_m.iter().all(|x| x.is_finite()) => {
                Err(Error::Escaped { particle, position_m, time_s, count: 1 + outside.count() })
            }
            Some((particle, _)) => Err(Error::NotFinite { particle, time_s }),
        }
    }
}
