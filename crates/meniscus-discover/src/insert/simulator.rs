//! Interface of a simulator of the glass, and the particle simulator behind it.
//!
//! A simulator gets a settled glass with its effects and some motions, and returns the surface heights of each frame. Gain and
//! delay of the commanded motion and the effects of the camera are applied around it.

use super::course::{Course, run};
use meniscus::reduced::effects::{Active, Simulator as Carried, Slot, Stated};
use meniscus_data::effects::Effects;
use meniscus_sph::Setup;
use std::sync::atomic::AtomicBool;
use thiserror::Error;

/// Processor time of a particle step before any was measured, s: 3.7 us in glycerine with a yield stress at 7 mm, on a virtual
/// AMD EPYC.
const PARTICLE_STEP_S: f64 = 4.0e-6;

/// Reason for which a simulator returned no heights.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum SimulatorFault {
    /// This glass in this motion cannot be simulated; others may be.
    #[error("{0}")]
    Here(String),
    /// The simulator itself is of no use: nothing more is asked of it.
    #[error("{0}")]
    Broken(String),
    /// The program was interrupted.
    #[error("interrupted")]
    Stopped,
}

/// Simulator of the glass.
pub trait GlassSimulator: Sync {
    /// Returns the name for people.
    fn name(&self) -> &str;

    /// Returns the text that distinguishes its results on disk from those of any other simulator; nothing for the particle
    /// simulator.
    fn identity(&self) -> &str;

    /// Returns `effects`, counted from `stated`, as they enter a simulation, in SI units.
    ///
    /// # Errors
    /// In words, when it does not carry one of them or a value is out of its range.
    fn carried(&self, effects: &[Active], stated: &Stated) -> Result<Effects, String>;

    /// Returns the processor time of a particle step before any was measured, s; none where the work is not known beforehand.
    fn particle_step_s(&self) -> Option<f64>;

    /// Simulates `courses` of one settled glass; returns the heights of each, frame after frame, m. `stop` ends the work.
    ///
    /// # Errors
    /// [`SimulatorFault`].
    fn run(
        &self,
        setup: &Setup,
        courses: &[&Course],
        stop: Option<&AtomicBool>,
    ) -> Result<Vec<Vec<f32>>, SimulatorFault>;
}

/// The particle simulator.
#[derive(Clone, Copy, Debug)]
pub struct Particles;

impl GlassSimulator for Particles {
    fn name(&self) -> &str {
        "particles"
    }

    fn identity(&self) -> &str {
        ""
    }

    fn carried(&self, effects: &[Active], stated: &Stated) -> Result<Effects, String> {
        let mut inside = Effects::default();
        for effect in effects.iter().filter(|effect| !is_around(effect)) {
            inside.set_simulated(effect, stated).map_err(|error| error.to_string())?;
        }
        Ok(inside)
    }

    fn particle_step_s(&self) -> Option<f64> {
        Some(PARTICLE_STEP_S)
    }

    fn run(
        &self,
        setup: &Setup,
        courses: &[&Course],
        _stop: Option<&AtomicBool>,
    ) -> Result<Vec<Vec<f32>>, SimulatorFault> {
        run(setup, courses).map_err(SimulatorFault::Here)
    }
}

/// Returns whether `effect` is applied around a simulator: gain and delay of the motion, what the camera does, and the radius
/// of the glass that is simulated.
pub(crate) fn is_around(effect: &Active) -> bool {
    matches!(
        (effect.entry.simulator, effect.entry.slot),
        (Carried::Absent(_), Slot::Port(_) | Slot::View(_) | Slot::Vessel(_))
    )
}
