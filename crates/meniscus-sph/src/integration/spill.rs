//! Liquid that leaves over the rim.
//!
//! Above the rim there is no wall: a particle there is a free drop. One that is outside of the glass above the rim has left it; as soon as it
//! falls below the rim it is no longer simulated, and its mass and energy are booked:
//! ```text
//! volume   sum m/rho0
//! energy   kinetic + potential + internal before - after
//! rest     m g h less for each, with h = fill - volume/area the level of the rest: so much less is the energy of what remains, at rest
//! ```
//! A particle outside below the rim that was never above it went through the wall: the simulation has failed.

use crate::particles::{PIECE, Particle, retain};
use crate::{Error, Simulator};
use meniscus_data::recording::EnergyBook;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Liquid that left the glass over the rim since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spilled {
    /// Number of particles.
    pub particles: usize,
    /// Volume at the density of rest, m3.
    pub volume_m3: f64,
    /// Energy above that of rest, J.
    pub energy_j: f64,
}

/// Where a particle is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// In the glass, or above it.
    Inside,
    /// Outside, above the rim.
    Over,
    /// Outside, below the rim.
    Below,
    /// Nowhere: not a finite number.
    Lost,
}

impl Simulator {
    /// Returns what left the glass over the rim since the start.
    #[must_use]
    pub fn spilled(&self) -> Spilled {
        self.spilled
    }

    fn place(&self, x: &[f64; 3]) -> Place {
        let (glass, slack) = (&self.glass, 0.5 * self.spacing_m);
        let (radius, wall) = (x[0].hypot(x[1]), glass.radius_at(x[2]));
        if !x.iter().all(|x| x.is_finite()) {
            Place::Lost
        } else if x[2] > glass.rim_m - self.spacing_m && radius > wall {
            // A spacing below the rim, too: it came over the edge since it was last looked at.
            Place::Over
        } else if x[2] > glass.rim_m || glass.wall_distance(x) >= -slack {
            Place::Inside
        } else {
            Place::Below
        }
    }

    /// Whether every particle is finite, and inside the glass or went over its rim.
    ///
    /// # Errors
    /// When one is not.
    pub(crate) fn check_inside(&self) -> Result<(), Error> {
        self.check(&self.places())
    }

    /// Where each particle is.
    fn places(&self) -> Vec<Place> {
        self.fluid.particle.par_iter().with_min_len(PIECE).map(|p| self.place(&p.x)).collect()
    }

    fn check(&self, places: &[Place]) -> Result<(), Error> {
        let particles = self.fluid.particle.iter().zip(places).zip(&self.over).enumerate();
        let mut wrong = particles.filter_map(|(i, ((p, place), over))| match place {
            Place::Lost => Some((i, p.x)),
            Place::Below if !over => Some((i, p.x)),
            _ => None,
        });
        let time_s = self.time;
        match wrong.next() {
            None => Ok(()),
            Some((particle, position_m)) if position_m.iter().all(|x| x.is_finite()) => {
                Err(Error::Escaped { particle, position_m, time_s, count: 1 + wrong.count() })
            }
            Some((particle, _)) => Err(Error::NotFinite { particle, time_s }),
        }
    }

    /// Lets go of what fell below the rim outside, and notes what is over it; to be called before the lists are built anew.
    ///
    /// # Errors
    /// When a particle went through the wall, or has no finite position.
    pub(crate) fn spill(&mut self) -> Result<(), Error> {
        let mut places = self.places();
        self.check(&places)?;
        let keep = |((p, place), over): ((&Particle, &Place), &bool)| match place {
            Place::Over => p.x[2] > self.glass.rim_m,
            Place::Below => !over,
            Place::Inside | Place::Lost => true,
        };
        let keep: Vec<bool> = self.fluid.particle.iter().zip(&places).zip(&self.over).map(keep).collect();
        if keep.contains(&false) {
            self.let_go(&keep);
            retain(&mut places, &keep);
        }
        self.over = places.iter().map(|place| *place == Place::Over).collect();
        Ok(())
    }

    /// Removes the particles that are not in `keep` and books them.
    fn let_go(&mut self, keep: &[bool]) {
        let before = above_rest(&self.energy());
        let lost = |keep: &bool| !keep;
        let mass: f64 = self.fluid.mass.iter().zip(keep).filter(|(_, k)| lost(k)).map(|(m, _)| m).sum();
        self.spilled.particles += keep.iter().filter(|k| lost(k)).count();
        let area = PI * self.glass.radius_at(self.glass.fill_m).powi(2);
        let volume = mass / self.forces.rest_density;
        // The level in the middle of this loss.
        let level = self.glass.fill_m - (self.spilled.volume_m3 + 0.5 * volume) / area;
        self.spilled.volume_m3 += volume;
        self.rest_energy += mass * self.gravity[2] * level;
        self.fluid.retain(keep);
        self.forces.retain(keep);
        self.acting.retain(keep);
        retain(&mut self.over, keep);
        retain(&mut self.number, keep);
        self.spilled.energy_j += before - above_rest(&self.energy());
    }
}

/// Energy of the liquid in the glass above that of rest, J.
fn above_rest(book: &EnergyBook) -> f64 {
    book.kinetic + book.potential + book.internal
}

#[cfg(test)]
mod tests {
    use crate::setup::small_glass;
    use crate::validate::Mode;
    use crate::{Setup, Simulator, closure};
    use meniscus_data::liquids::Rheology;
    use meniscus_data::recording::Glass;

    /// A full small glass whose first mode starts at `speed_m_s`.
    fn full_glass(speed_m_s: f64) -> Simulator {
        let setup = small_glass(1000.0, Rheology::newtonian(0.05));
        let glass = Glass { rim_m: 0.042, ..setup.glass };
        let mut simulator = Simulator::new(&Setup { glass, ..setup }).expect("the glass settles");
        let mode = Mode::first(simulator.glass);
        simulator.set_velocity(|x| mode.velocity(x).map(|v| speed_m_s * v));
        simulator
    }

    #[test]
    fn a_strong_slosh_loses_liquid_over_the_rim_and_the_books_close() {
        let mut simulator = full_glass(0.7);
        let mass = |s: &Simulator| s.motion().map(|(_, _, m)| m).sum::<f64>();
        let (all, started) = (mass(&simulator), simulator.energy().kinetic);
        let level = |s: &Simulator| {
            // Twice the height of the middle of mass is the mean height of what stands in a cylinder.
            2.0 * s.motion().map(|(x, _, m)| m * x[2]).sum::<f64>() / mass(s)
        };
        let before = level(&simulator);
        while simulator.time_s() < 1.2 {
            simulator.step(|_| 0.0).expect("no particle goes through the wall");
        }
        let spilled = simulator.spilled();
        println!("{spilled:?} of {all} kg, books off by {}", closure(&simulator.energy()) / started);
        assert!(spilled.particles > 5, "{spilled:?}");
        assert!((spilled.volume_m3 * 1000.0 / (all - mass(&simulator)) - 1.0).abs() < 1e-9, "{spilled:?}");
        // The surface stands lower by what left, as far as it has come to rest.
        let area = std::f64::consts::PI * 0.035 * 0.035;
        let fallen = (before - level(&simulator)) * area;
        assert!((fallen / spilled.volume_m3 - 1.0).abs() < 0.1, "{fallen} m3 for {spilled:?}");
        let rim = simulator.glass.rim_m;
        assert!(simulator.motion().all(|(x, ..)| x[2] > rim || x[0].hypot(x[1]) < 0.0385));
        assert!(closure(&simulator.energy()).abs() < 0.02 * started, "{:?}", simulator.energy());
    }

    #[test]
    fn a_gentle_slosh_loses_nothing() {
        let mut simulator = full_glass(0.1);
        while simulator.time_s() < 0.4 {
            simulator.step(|_| 0.0).expect("it stays in the glass");
        }
        assert_eq!(simulator.spilled().particles, 0);
        assert_eq!(simulator.energy().spilled, 0.0);
    }

    /// The density of the step that lets liquid go is found from the pressure of the step before.
    #[test]
    fn what_remains_keeps_the_pressure_on_the_surface_above_it() {
        let mut simulator = full_glass(0.3);
        for _ in 0..20 {
            simulator.step(|_| 0.0).expect("no particle goes through the wall");
        }
        let before = simulator.forces.pressed.clone();
        assert!(before.iter().any(|[p, ..]| *p != before[0][0]), "the surface is flat");
        // The first and every seventh particle fell over the rim.
        let all = before.len();
        for i in (0..all).step_by(7) {
            simulator.fluid.particle[i].x = [0.1, 0.0, 0.0];
            simulator.over[i] = true;
        }
        simulator.spill().expect("no particle went through the wall");
        let left = all - all.div_ceil(7);
        assert_eq!((simulator.number.len(), simulator.forces.pressed.len()), (left, left));
        for (number, above) in simulator.number.iter().zip(&simulator.forces.pressed) {
            assert_eq!(above, &before[*number as usize], "particle {number}");
        }
    }
}
