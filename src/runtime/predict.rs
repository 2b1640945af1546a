//! First stages of a turn: resolve the input, and step. Energies are in units of H.

use super::estimator::{Estimator, POINTS_NEEDED};
use super::memory::Memory;
use super::turn_input::{InputSource, TurnInput};
use crate::filter::PORT_LIMIT;
use crate::latent::generic::{Audit, StepOutcome};
use crate::real::{Real, narrow};
use crate::runtime::health::count;
use crate::surface::SurfaceProfile;

/// Input of a turn as the model's own glass and camera would have it.
pub(super) struct Observation {
    /// Profile without what the observation model adds to it.
    profile: Option<SurfaceProfile>,
    /// Source of the motion, decided.
    pub(super) source: InputSource,
}

impl Observation {
    /// The profile, if enough of its points were seen.
    pub(super) fn measurement(&self) -> Option<&SurfaceProfile> {
        self.profile.as_ref().filter(|profile| profile.valid_points() >= POINTS_NEEDED)
    }
}

/// Predicted state of a turn, beside the one in the memory.
pub(super) struct Prior {
    /// Energy at the start of the turn.
    pub(super) energy_before: f64,
    /// Energy behind the position update, at which the step starts.
    pub(super) energy_placed: f64,
    /// Energy behind the step.
    pub(super) energy: f64,
    /// Input that entered the port.
    pub(super) input: f64,
    /// Acceleration of the glass as the encoder reads it, m/s2.
    pub(super) acceleration_m_s2: f64,
    pub(super) audit: Audit,
}

impl Estimator<'_> {
    /// Frees the profile of what the observation model adds, and decides where the motion of the glass comes from.
    pub(super) fn resolve_input(&self, memory: &mut Memory, input: &TurnInput<'_>) -> Observation {
        let observation_model = self.model.observation_model.as_ref();
        let profile = match (observation_model, input.profile) {
            (Some(observation_model), Some(profile)) => Some(observation_model.to_model(profile)),
            (_, profile) => profile.copied(),
        };
        let source = observation_model
            .map_or(input.source, |observation_model| input.source.scaled(observation_model.gain));
        let source = memory.resolve_source(source, profile.as_ref());
        Observation { profile, source }
    }

    /// Takes the GENERIC step of this turn under the motion that was observed.
    pub(super) fn step<R: Real>(&self, memory: &mut Memory, observation: &Observation) -> Prior {
        let energy_before = self.latent_energy::<R>(memory);
        let acceleration_m_s2 = self.observe_motion::<R>(memory, observation);
        let (energy_placed, input) = (self.latent_energy::<R>(memory), memory.filter.input());
        memory.filter.predict::<R>(self.model, energy_placed);
        let audit = self.model.generic.step_in::<R>(&mut memory.state, input);
        match audit.outcome {
            StepOutcome::Solved => {}
            StepOutcome::Unconverged => count(&mut memory.health.step_unconverged),
            StepOutcome::Backtracked => count(&mut memory.health.step_backtracked),
            StepOutcome::Held => count(&mut memory.health.step_held),
        }
        let energy = self.latent_energy::<R>(memory);
        if let InputSource::Measured { now, .. } = observation.source {
            let now = self.clip(memory, now) / self.acceleration_scale();
            memory.filter.set_known_input(&self.model.header.filter, now);
        }
        Prior { energy_before, energy_placed, energy, input, acceleration_m_s2, audit }
    }

    /// Gives the motion of the glass to the filter. Returns its acceleration as the encoder reads it, m/s2, clipped to what
    /// the model can have seen: off the last three positions, as measured, or as the filter estimates it.
    fn observe_motion<R: Real>(&self, memory: &mut Memory, observation: &Observation) -> f64 {
        let config = &self.model.header.filter;
        let profile = observation.profile.as_ref();
        let position = profile.and_then(|profile| profile.glass_x_m).map(f64::from).filter(|x| x.is_finite());
        if position.is_none() {
            count(&mut memory.health.glass_not_seen);
        }
        let differenced = memory.motion.update(position);
        let Memory { filter, state, .. } = memory;
        let acceleration = match observation.source {
            InputSource::Tracked => {
                // The position of this frame determines the input of the one before, so it comes before the step.
                if let Some(x_m) = position {
                    filter.update_position::<R>(self.model, &mut state.latent, x_m);
                }
                differenced
            }
            InputSource::Measured { before, .. } => before,
            InputSource::Unobserved => {
                filter.reset_position(config);
                self.acceleration_scale() * filter.input()
            }
        };
        let clipped = self.clip(memory, acceleration);
        if let InputSource::Measured { .. } = observation.source {
            memory.filter.set_known_input(config, clipped / self.acceleration_scale());
        }
        clipped
    }

    /// H(x).
    pub(super) fn latent_energy<R: Real>(&self, memory: &Memory) -> f64 {
        self.model.generic.potential.value(&narrow::<R, _, _>(&memory.state.latent)).wide()
    }

    /// Acceleration of a unit of the input, m/s2.
    pub(super) fn acceleration_scale(&self) -> f64 {
        f64::from(self.model.header.acceleration_scale)
    }

    /// Returns `acceleration` within what the model can have seen; zero where it is not finite.
    fn clip(&self, memory: &mut Memory, acceleration: f64) -> f64 {
        let limit = PORT_LIMIT * self.acceleration_scale();
        let clipped = if acceleration.is_finite() { acceleration.max(-limit).min(limit) } else { 0.0 };
        if clipped != acceleration {
            count(&mut memory.health.acceleration_clipped);
        }
        clipped
    }
}
