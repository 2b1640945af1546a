//! Middle stages of a turn: linearise, update by the heights, and update by the encoder's window.
//!
//! The decoder is linearised once, at the predicted state, and the filter works on that.

use super::estimator::Estimator;
use super::memory::Memory;
use super::mode::Mode;
use super::predict::{Observation, Prior};
use super::turn_input::InputSource;
use crate::filter::{Adaptation, Reading, Update, UpdateContext};
use crate::latent::generic::LATENTS;
use crate::latent::linearisation::Linearisation;
use crate::real::Real;
use crate::runtime::health::count;
use crate::surface::SurfaceProfile;

/// Frames of a full window that must have been seen for the encoder to be trusted: half of 16.
const ROWS_NEEDED: usize = 8;

impl Estimator<'_> {
    /// Expands the decoder's surface about the predicted state.
    // Its arrays and those of the filter's update need not lie on the stack at once.
    #[inline(never)]
    pub(super) fn linearise(&self, memory: &Memory) -> Linearisation {
        let latent: [f64; LATENTS] = memory.state.latent.into();
        self.model.decoder.linearise(&latent.map(|x| x as f32), memory.filter.input() as f32)
    }

    /// Corrects the state by the heights. Returns the measurement that was used: none where too few points were seen, or
    /// where the correction was not finite.
    pub(super) fn update<'o, R: Real>(
        &self,
        memory: &mut Memory,
        observation: &'o Observation,
        linearisation: Option<&Linearisation>,
        prior: &Prior,
    ) -> Option<&'o SurfaceProfile> {
        let (profile, about) = observation.measurement().zip(linearisation)?;
        let context = context(memory, prior);
        let Memory { filter, state, .. } = memory;
        match filter.update_heights::<R>(self.model, &mut state.latent, profile, about, context) {
            Update::Accepted => Some(profile),
            Update::Refused => {
                count(&mut memory.health.measurement_refused);
                None
            }
        }
    }

    /// Adds the frame to the window, and corrects the state by what the encoder reads off it. Returns whether this turn
    /// counts as tracked.
    pub(super) fn read_window<R: Real>(
        &self,
        memory: &mut Memory,
        observation: &Observation,
        measured: Option<&SurfaceProfile>,
        prior: &Prior,
    ) -> bool {
        // The encoder was trained on a glass that keeps to its line.
        let in_line =
            measured.map(|profile| self.model.cross_axis.without(profile, memory.filter.lateral_m()));
        let row = self.model.scale().row(in_line.as_ref(), prior.acceleration_m_s2 as f32);
        memory.window.push(row);
        let tracked =
            measured.is_some() && memory.window.is_full() && memory.window.measured_rows() >= ROWS_NEEDED;
        // Its windows hold the motion, so that without one its reading means nothing.
        if tracked
            && observation.source != InputSource::Unobserved
            && !self.update_reading::<R>(memory, prior)
        {
            count(&mut memory.health.measurement_refused);
        }
        tracked
    }

    /// Corrects the state by the encoder's reading, if that is finite. Returns whether it was used.
    fn update_reading<R: Real>(&self, memory: &mut Memory, prior: &Prior) -> bool {
        let readings = self.model.encoder.encode(memory.window.rows());
        let [latent @ .., input] = readings.map(f64::from);
        if !readings.iter().all(|x| x.is_finite()) {
            return false;
        }
        let (reading, context) = (Reading { latent: latent.into(), input }, context(memory, prior));
        let Memory { filter, state, .. } = memory;
        filter.update_reading::<R>(self.model, &mut state.latent, &reading, context) == Update::Accepted
    }
}

/// Circumstances of this turn's updates: the noise scales follow only while the filter tracks.
fn context(memory: &Memory, prior: &Prior) -> UpdateContext {
    let adaptation = if memory.mode == Mode::Tracking { Adaptation::Follow } else { Adaptation::Hold };
    UpdateContext { latent_energy: prior.energy, adaptation }
}
