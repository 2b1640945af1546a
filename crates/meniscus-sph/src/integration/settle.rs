//! Settling: the ring packing relaxes under gravity and strong friction before time starts.

use crate::effects::Acting;
use crate::{Error, Simulator, Spilled};
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
    /// Lets the packing come to rest, then sets clock, velocities and books to zero. The shake
    /// brings the particles into the arrangement that sloshing would bring them into anyway; without
    /// it the liquid sinks by 0.1 mm while the recording runs.
    ///
    /// # Errors
    /// As for [`Simulator::step`], and [`Error::Stopped`].
    pub(crate) fn settle(&mut self, stop: &AtomicBool) -> Result<(), Error> {
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
        self.start();
        Ok(())
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

    /// Sets clock, velocities and books to zero and lets the effects act from here.
    fn start(&mut self) {
        for p in &mut self.fluid.particle {
            p.v = [0.0; 3];
        }
        self.fluid.heat.fill(0.0);
        self.forces.position_density.settle();
        self.time = 0.0;
        self.calm_from_s = 0.0;
        self.work = 0.0;
        self.spilled = Spilled::default();
        self.rest_energy = self.potential();
        let rest_density = self.forces.rest_density;
        self.acting = Acting::on(&self.laws, &self.glass, rest_density, self.forces.kernel.h, &self.fluid);
        self.accelerate(&Kinematics::default());
    }
}
