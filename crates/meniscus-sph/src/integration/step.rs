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
use crate::particles::IMAGE_SKIN;
use crate::{Error, SKIN, Simulator};
use meniscus_data::motion::Kinematics;

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
        self.set_off();
        self.refresh_lists()?;
        let middle = Body::of(&motion_with(&self.laws, motion(self.time + 0.5 * dt)));
        self.reflect(&middle);
        self.forces.density_rates(&self.lists, &self.fluid, &self.walls, &middle);
        self.densify_and_drift();
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
        self.forces.forces(&self.lists, &self.fluid, &mut self.walls, &self.glass, sticking, self.dt);
        self.forces.accelerations(&mut self.fluid, &self.body);
        self.turning.clear();
        if self.body.turns() {
            self.turning.extend(self.fluid.particle.iter().map(|p| self.body.turning(&p.x, &p.v)));
        }
        let Self { acting, glass, spacing_m, lists, walls, forces, fluid, stages, dt, .. } = self;
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
