//! Relaxation of a packing of rings to rest, under gravity and strong friction.

use super::Settled;
use crate::{Error, Simulator};
use meniscus_data::motion::Kinematics;
use std::sync::atomic::{AtomicBool, Ordering};

/// Length of each phase of settling, s: still, shaken, still.
const PHASES_S: [f64; 3] = [0.2, 0.3, 1.0];

/// Acceleration and frequency of the shake: the first mode of a liquid without viscosity then just
/// does not break, which would throw drops over the rim.
const SHAKE: (f64, f64) = (1.0, 3.4);

/// Decay time of every velocity in the still phases, s; it damps the slosh about critically.
const FRICTION_S: f64 = 0.04;

/// Refuses to go on once `stop` is raised.
pub(crate) fn check_running(stop: &AtomicBool) -> Result<(), Error> {
    if stop.load(Ordering::Relaxed) { Err(Error::Stopped) } else { Ok(()) }
}

impl Simulator {
    /// Lets the packing come to rest and returns it. The shake brings the particles into the arrangement that sloshing
    /// would bring them into anyway; without it the liquid sinks by 0.1 mm while the recording runs.
    ///
    /// # Errors
    /// As for [`Simulator::step`], and [`Error::Stopped`].
    pub(super) fn settle(mut self, stop: &AtomicBool) -> Result<Settled, Error> {
        self.accelerate(&Kinematics::default());
        let [packing, shaking, resting] = PHASES_S.map(|seconds| (seconds / self.dt) as usize);
        for _ in 0..packing {
            check_running(stop)?;
            self.step(|_| 0.0)?;
            self.rub(1.0);
        }
        let start = self.time;
        for _ in 0..shaking {
            check_running(stop)?;
            self.step(|t| SHAKE.0 * (std::f64::consts::TAU * SHAKE.1 * (t - start)).sin())?;
        }
        for step in 0..resting {
            check_running(stop)?;
            self.step(|_| 0.0)?;
            // Friction fades out, so that the liquid finds its own balance.
            self.rub((2.0 * (1.0 - step as f64 / resting as f64)).min(1.0));
        }
        self.check_inside()?;
        Ok(Settled {
            position: self.fluid.particle.iter().map(|p| p.x).collect(),
            law: self.forces.position_density.law(),
            mass: self.fluid.mass,
            density: self.fluid.density,
        })
    }

    /// Slows every particle by `strength` times the friction of a still phase.
    fn rub(&mut self, strength: f64) {
        let keep = 1.0 - strength * self.dt / FRICTION_S;
        for p in &mut self.fluid.particle {
            for v in &mut p.v {
                *v *= keep;
            }
        }
    }
}
