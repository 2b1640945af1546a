//! An estimate carried on without a measurement: state, cross-axis slosh and covariance, turn by turn.

use super::memory::Memory;
use crate::blob::Model;
use crate::latent::generic::{LATENTS, Latent, LatentState};
use crate::surface::POINTS;
use crate::uncertainty::cross_axis::LateralState;
use crate::uncertainty::intervals::{CarriedCovariance, Horizon};

/// The turns that come, under a plan.
#[derive(Clone, Copy)]
pub(super) struct Course<'c> {
    model: &'c Model<'c>,
    /// Accelerations along x of the turns to come, m/s2, the next one first.
    plan: &'c [f64],
    /// Turns behind the estimate.
    turn: usize,
    state: LatentState,
    lateral: LateralState,
    carried: CarriedCovariance,
}

impl<'c> Course<'c> {
    /// The course from what `memory` holds.
    pub(super) fn new(model: &'c Model<'c>, memory: &Memory, plan: &'c [f64]) -> Self {
        let latent_energy = model.generic.potential.value(&memory.state.latent);
        Self {
            model,
            plan,
            turn: 0,
            state: memory.state,
            lateral: memory.filter.lateral(model),
            carried: model.error_model.carried(
                &memory.filter.covariance(),
                latent_energy,
                memory.disagreement.scale(&model.error_model.factors),
            ),
        }
    }

    /// Takes the next turn.
    pub(super) fn step(&mut self) {
        let Self { model, plan, turn, .. } = *self;
        model.generic.step(&mut self.state, port(model, plan, turn));
        model.cross_axis.step(&mut self.lateral);
        let latent_energy = model.generic.potential.value(&self.state.latent);
        let at = Horizon { frames: turn, planned: plan.len() };
        let kick = self.kick();
        model.error_model.carry(&mut self.carried, &kick, at, latent_energy);
        self.turn = turn.saturating_add(1);
    }

    /// Heights of the surface, metres above the inner bottom.
    pub(super) fn surface_m(&self) -> [f32; POINTS] {
        let Self { model, state, .. } = self;
        let latent: [f64; LATENTS] = state.latent.into();
        let coefficients = model.decoder.coefficients(&latent.map(|x| x as f32), 0.0);
        let mut surface_m = model.decoder.surface(&coefficients);
        let [lateral_m, _] = self.lateral.amplitude_m;
        model.cross_axis.add_to(&mut surface_m, lateral_m);
        if let Some(observation_model) = &model.observation_model {
            observation_model.add_offset(&mut surface_m);
        }
        surface_m
    }

    /// Half-widths of the surface, m.
    pub(super) fn half_width_m(&self) -> [f32; POINTS] {
        let errors = &self.model.error_model;
        let horizon = Horizon { frames: self.turn, planned: self.plan.len() };
        errors.carried_heights(&self.carried, &self.lateral_variance_m2(), horizon)
    }

    /// Half-widths of a crest that stands at each height, m; `within` is the last turn at which another may come.
    ///
    /// Where the plan does not reach the crest, an acceleration may bring another one at any time, and they are those of the
    /// last turn.
    pub(super) fn crest_half_width_m(mut self, within: usize) -> [f32; POINTS] {
        let Model { error_model, cross_axis, .. } = self.model;
        if self.turn <= self.plan.len() {
            return error_model.carried_crest(&self.carried, &self.lateral_variance_m2());
        }
        let left = within.saturating_sub(self.turn);
        for _ in 0..left {
            cross_axis.step(&mut self.lateral);
        }
        let kick = self.kick();
        error_model.carry_free(&mut self.carried, &kick, left);
        self.turn = within;
        self.half_width_m()
    }

    /// dt B.
    fn kick(&self) -> Latent {
        self.model.generic.port * self.model.generic.dt_s
    }

    /// y of each height.
    fn lateral_variance_m2(&self) -> [f64; POINTS] {
        self.model.cross_axis.variance::<f64>(&self.lateral, &self.model.error_model.surface)
    }
}

/// The port value of turn `ahead` of `plan`, m/s2; zero behind its end and for what is no number.
fn port(model: &Model<'_>, plan: &[f64], ahead: usize) -> f64 {
    let planned = plan.get(ahead).copied().filter(|a| a.is_finite()).unwrap_or(0.0);
    let gain = model.observation_model.as_ref().map_or(1.0, |observation_model| observation_model.gain);
    gain * planned / f64::from(model.header.acceleration_scale)
}
