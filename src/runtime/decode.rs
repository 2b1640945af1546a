//! Last stages of a turn: decode, intervals, field, audit. The surface is decoded once, at the corrected state.

use super::budget::{Clock, Lap, Stages, field_start_us};
use super::estimate::Estimate;
use super::estimator::Estimator;
use super::memory::Memory;
use super::mode::Mode;
use super::predict::Prior;
use crate::blob::FieldGroup;
use crate::latent::decoder::{Coefficients, Selection};
use crate::latent::generic::LATENTS;
use crate::real::Real;
use crate::runtime::health::count;
use crate::surface::{POINTS, SurfaceProfile};
use crate::uncertainty::discrepancy::Discrepancy;
use crate::uncertainty::intervals::{Interval, IntervalInput};
use crate::uncertainty::latent_covariance::LatentCovariance;

/// Corrected state of a turn, decoded.
pub(super) struct Posterior {
    latent: [f64; LATENTS],
    energy: f64,
    input: f64,
    coefficients: Coefficients,
    surface_m: [f32; POINTS],
    discrepancy: Discrepancy,
}

impl Estimator<'_> {
    /// Decodes the corrected state, and adds to its surface what the decoder cannot say.
    pub(super) fn decode<R: Real>(&self, memory: &Memory, measured: Option<&SurfaceProfile>) -> Posterior {
        let (decoder, input) = (&self.model.decoder, memory.filter.input());
        let energy = self.latent_energy::<R>(memory);
        let latent: [f64; LATENTS] = memory.state.latent.into();
        let coefficients = decoder.coefficients(&latent.map(|x| x as f32), input as f32);
        let mut surface_m = decoder.surface(&coefficients);
        self.model.cross_axis.add_to(&mut surface_m, memory.filter.lateral_m());
        let mut discrepancy = Discrepancy::NONE;
        if let Some(profile) = measured {
            discrepancy = Discrepancy::of(&self.model.error_model, profile, &surface_m, energy);
            discrepancy.add_to(&mut surface_m, profile);
        }
        if let Some(observation_model) = &self.model.observation_model {
            observation_model.add_offset(&mut surface_m);
        }
        Posterior { latent, energy, input, coefficients, surface_m, discrepancy }
    }

    /// Returns the half-widths of the corrected state, scaled by its disagreement with the heights that were `seen`.
    pub(super) fn interval<R: Real>(
        &self,
        memory: &mut Memory,
        posterior: &Posterior,
        seen: Option<&SurfaceProfile>,
    ) -> Interval {
        let errors = &self.model.error_model;
        let lateral = memory.filter.lateral(self.model);
        let interval = errors.interval::<R>(&IntervalInput {
            covariance: &memory.filter.covariance(),
            lateral_variance_m2: &self.model.cross_axis.variance::<R>(&lateral, &errors.surface),
            discrepancy: &posterior.discrepancy,
            latent_energy: posterior.energy,
            heat: memory.state.heat,
            energy_scale_j: self.model.header.energy_scale_j,
            blind_turns: memory.blind_turns,
        });
        let tracking = memory.mode == Mode::Tracking;
        memory.disagreement.update(seen, &posterior.surface_m, &interval.surface_m, tracking);
        memory.disagreement.scaled(&errors.factors, interval)
    }

    /// Writes the full field if it is wanted, valid and in time. Returns whether it was written. The numbers of a group that
    /// the model does not know are not numbers.
    pub(super) fn write_field<C: Clock>(
        &self,
        memory: &mut Memory,
        posterior: &Posterior,
        lap: &Lap<'_, C>,
        stages: &Stages,
        field: &mut [f32],
    ) -> bool {
        let wanted = self.groups != Selection::NONE && field.len() == self.field_len();
        if memory.mode == Mode::Halted || !wanted {
            return false;
        }
        if lap.elapsed_us().saturating_add(stages.surface_us) > field_start_us(self.deadline_us) {
            count(&mut memory.health.field_shed);
            return false;
        }
        let heat_j = self.model.header.energy_scale_j * memory.state.heat;
        let (known, decoder) = (self.model.header.known(), &self.model.decoder);
        let mut rest = field;
        for (index, group) in FieldGroup::ALL.into_iter().enumerate() {
            let one = Selection::NONE.with(index);
            if !self.groups.holds(index) {
                continue;
            }
            let Some((part, behind)) = rest.split_at_mut_checked(decoder.part_len(one)) else { break };
            rest = behind;
            if known.contains(group) {
                decoder.part(one, &posterior.coefficients, heat_j as f32, part);
            } else {
                part.fill(f32::NAN);
            }
        }
        true
    }

    /// Closes the books of the turn: the estimate but for interval, field and times.
    pub(super) fn audit(&self, memory: &Memory, prior: &Prior, posterior: &Posterior) -> Estimate {
        let joules = self.model.header.energy_scale_j;
        // Two corrections change H: by the position of the glass before the step, by heights and encoder behind it.
        let corrected = posterior.energy - prior.energy + prior.energy_placed - prior.energy_before;
        Estimate {
            mode: memory.mode,
            latent: posterior.latent,
            covariance: LatentCovariance::of(&memory.filter.covariance().latents),
            surface_m: posterior.surface_m,
            interval: Interval::default(),
            acceleration_m_s2: (self.acceleration_scale() * prior.input) as f32,
            port: posterior.input as f32,
            slosh_j: joules * posterior.energy,
            heat_j: joules * memory.state.heat,
            corrected_j: joules * corrected,
            audit: prior.audit,
            field_fresh: false,
            stages: Stages::default(),
        }
    }
}
