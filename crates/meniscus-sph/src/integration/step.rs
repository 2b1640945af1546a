//! One step in time: kick, drift, kick.
//!
//! ```text
//! v  += dt/2 a(t)                 x += dt/2 v
//! rho += dt rho'(x, v)            at the middle of the step
//! x  += dt/2 v                    a(t + dt) from x, rho, v;   v += dt/2 a(t + dt)
//! ```
//! (Monaghan 2005; Adami et al. 2012.) Density lives where the velocity is half a step away, so
//! sound is integrated by a leap-frog and neither grows nor decays by the scheme itself.

use crate::effects::{Surroundings, motion_with};
use crate::frame::Body;
use crate::particles::{Fluid, IMAGE_SKIN};
use crate::walls::hold;
use crate::{Error, SKIN, Simulator};
use meniscus_data::motion::Kinematics;
use rayon::prelude::*;

/// Largest `omega dt` of a step, with `omega` of [`crate::forces::Forces::fastest`]. A leap-frog alone follows up to 2; among
/// neighbours that swing with it, water in breaking waves blew up from 1.5 on. At rest it is 1.1, in a slosh that does not break 1.25.
const FASTEST_SWING: f64 = 1.3;

/// Most parts of a step.
const MOST_PARTS: f64 = 8.0;

/// Time for which a splash is looked at often after its fastest swing, s.
const SPLASH_S: f64 = 0.05;

impl Simulator {
    /// Advances by one step; `acceleration` gives the acceleration of the glass along x at a time.
    ///
    /// # Errors
    /// When a particle goes through the wall or a number is no longer finite.
    pub fn step(&mut self, acceleration: impl Fn(f64) -> f64) -> Result<(), Error> {
        self.step_moving(|t| Kinematics::along_x(acceleration(t)))
    }

    /// Advances by one step; `motion` gives the motion of the glass at a time.
    ///
    /// # Errors
    /// When a particle goes through the wall or a number is no longer finite.
    pub fn step_moving(&mut self, motion: impl Fn(f64) -> Kinematics) -> Result<(), Error> {
        // In a splash some particles swing faster than a step of the rest can follow.
        let dt = self.dt;
        let parts = (dt * self.forces.fastest / FASTEST_SWING).ceil().clamp(1.0, MOST_PARTS);
        if parts > 1.0 {
            self.calm_from_s = self.time + SPLASH_S;
        }
        self.forces.splash = self.time < self.calm_from_s;
        self.dt = dt / parts;
        let done = (0..parts as usize).try_for_each(|_| self.advance(&motion));
        self.dt = dt;
        done
    }

    /// Advances by the present step.
    fn advance(&mut self, motion: &impl Fn(f64) -> Kinematics) -> Result<(), Error> {
        let dt = self.dt;
        self.kick();
        hold(&self.glass, self.spacing_m, &mut self.fluid);
        self.drift();
        self.refresh_lists()?;
        let middle = Body::of(&motion_with(&self.laws, motion(self.time + 0.5 * dt)));
        self.reflect(&middle);
        self.forces.density_rates(&self.lists, &self.fluid, &self.walls, &middle);
        self.densify();
        self.drift();
        self.time += dt;
        self.remember();
        self.accelerate(&motion(self.time));
        self.gain_heat();
        self.thin();
        self.kick();
        Ok(())
    }

    /// Forces and accelerations at the present time, for a glass under `motion`.
    pub(crate) fn accelerate(&mut self, motion: &Kinematics) {
        self.body = Body::of(&motion_with(&self.laws, *motion));
        self.acting.press(&self.fluid, &mut self.forces.pressed);
        self.reflect(&self.body.clone());
        let sticking = self.sticking;
        self.walls.rub(&self.glass, &self.fluid, sticking);
        self.forces.forces(&self.lists, &self.fluid, &mut self.walls, &self.glass, sticking, self.dt);
        self.forces.accelerations(&mut self.fluid, &self.body);
        self.turning.clear();
        if self.body.turns() {
            self.turning.extend(self.fluid.particle.iter().map(|p| self.body.turning(&p.x, &p.v)));
        }
        let Self { acting, glass, spacing_m, lists, walls, forces, fluid, stages, dt, .. } = self;
        for (a, [_, a_x, a_y]) in fluid.acceleration.iter_mut().zip(&forces.pressed) {
            a[0] += a_x;
            a[1] += a_y;
        }
        let kernel = &forces.kernel;
        let around =
            Surroundings { kernel, lists, walls, sticking, rate: &forces.rate, glass, spacing_m: *spacing_m };
        acting.push(&around, fluid);
        if let Some(friction) = &mut forces.friction {
            stages.rub(*dt, friction, lists, walls, fluid);
        }
    }

    /// Lets the effects remember a full step: stresses, springs, heat.
    fn remember(&mut self) {
        if self.acting.is_elastic() {
            self.reflect(&self.body.clone());
        }
        let sticking = self.sticking;
        let Self { acting, glass, spacing_m, lists, walls, forces, fluid, dt, .. } = self;
        let kernel = &forces.kernel;
        let around =
            Surroundings { kernel, lists, walls, sticking, rate: &forces.rate, glass, spacing_m: *spacing_m };
        acting.advance(*dt, &around, fluid);
    }

    /// Lists who has an image in the walls, makes the images and lists the neighbours.
    pub(crate) fn list(&mut self) {
        let reach = self.forces.kernel.support2.sqrt() + IMAGE_SKIN * SKIN * self.spacing_m;
        self.walls.list(&self.glass, reach, &self.fluid.particle);
        self.reflect(&self.body.clone());
        self.lists.rebuild(&self.fluid.particle, &self.walls.image, self.glass.rim_m);
    }

    /// Makes the images of the present state under the body force `body`.
    fn reflect(&mut self, body: &Body) {
        self.walls.reflect(&self.glass, &self.fluid, body);
    }

    /// Half a step of velocity; the work of the moving glass is booked as the kick does it.
    fn kick(&mut self) {
        let half = 0.5 * self.dt;
        if self.forces.friction.is_some() {
            self.stages.warm(half, &mut self.fluid);
        }
        let Fluid { particle, acceleration, mass, .. } = &mut self.fluid;
        let mut momentum = [0.0; 3];
        let mut turned = 0.0;
        let mut turning = self.turning.iter();
        for ((p, a), m) in particle.iter_mut().zip(acceleration).zip(mass) {
            // Momentum in the middle of the kick.
            let middle: [f64; 3] = std::array::from_fn(|k| *m * (p.v[k] + 0.5 * half * a[k]));
            momentum.iter_mut().zip(middle).for_each(|(sum, of_one)| *sum += of_one);
            if let Some([e_x, e_z]) = turning.next() {
                turned += e_x * middle[0] + e_z * middle[2];
            }
            for (v, a) in p.v.iter_mut().zip(*a) {
                *v += half * a;
            }
        }
        let [f_x, f_y, f_z] = std::array::from_fn(|axis| self.body.uniform[axis] - self.gravity[axis]);
        self.work += f_x * half * momentum[0];
        self.work += f_y * half * momentum[1];
        self.work += f_z * half * momentum[2] + half * turned;
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
        for (((p, m), (rho, heat)), [strain, diffusion, _]) in parts {
            // The energy of compression changes by p/rho^2 d(rho).
            *heat -= dt * p.p / (*rho * *rho) * diffusion;
            *rho += dt * (*rho * strain + diffusion);
            p.p = sound2 * (*rho - rest);
            p.volume = *m / *rho;
        }
    }

    /// Viscous heating over a full step.
    fn gain_heat(&mut self) {
        let Fluid { mass, heat, .. } = &mut self.fluid;
        for ((heat, m), f) in heat.iter_mut().zip(mass).zip(&self.forces.force) {
            *heat += self.dt * f[3] / *m;
        }
    }

    /// The viscosity at the last rate of shear.
    pub(crate) fn thin(&mut self) {
        let rheology = self.liquid.rheology;
        if !rheology.is_newtonian() {
            let parts = self.fluid.viscosity.par_iter_mut().zip(&self.forces.force).with_min_len(256);
            parts.for_each(|(mu, f)| *mu = rheology.viscosity(f[4].max(0.0).sqrt()));
        }
    }

    /// Rebuilds the neighbour lists when due, without what left over the rim.
    fn refresh_lists(&mut self) -> Result<(), Error> {
        if self.lists.stale(&self.fluid.particle) {
            self.spill()?;
            self.list();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::setup::small_glass;
    use crate::validate::Mode;
    use crate::{Simulator, relative_closure};
    use meniscus_data::liquids::Rheology;

    /// A wave twice as high as it can stand breaks at the wall. With steps of the rest some of its particles gain energy from
    /// nothing, step after step.
    #[test]
    fn water_that_breaks_keeps_its_energy() {
        let mut simulator =
            Simulator::new(&small_glass(1000.0, Rheology::newtonian(1e-3))).expect("the glass settles");
        let mode = Mode::first(simulator.glass);
        simulator.set_velocity(|x| mode.velocity(x).map(|v| 0.6 * v));
        let mut books = Vec::new();
        while simulator.time_s() < 0.8 {
            simulator.step(|_| 0.0).expect("no particle goes through the wall");
            books.push(simulator.energy());
        }
        let closure = relative_closure(&books);
        println!("the energy closes to {:.2} %", 100.0 * closure);
        assert!(closure < 0.01, "{closure}");
    }
}
