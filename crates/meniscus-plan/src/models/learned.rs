//! The learned model as a liquid that forecasts its surface, from a published estimate.
//!
//! ```text
//! x(k+1)  = GENERIC step(x(k), u(k))                  z = decoder(x)
//! P(k+1)  = A P(k) A^T + w(k) Q                       half = k sqrt(e P e^T + w d + g^2),   w = floor + H(x(k))
//! ```
//! Letters as in `meniscus::uncertainty`; `e` is the slope of an end of the wall in the latents, and k the factor of the next crest
//! under a plan. The estimator's own forecast
//! keeps w of the liveliest slosh so far. Here w follows the slosh down, too: a limit on what is left could not be kept otherwise.

use super::ahead::{EndAhead, FRAMES};
use super::{FrameForecast, FrameInput, SurfaceModel, Watcher, stepped};
use crate::wall::WallMap;
use meniscus::blob::Model;
use meniscus::latent::generic::{LATENTS, Latent, LatentState};
use meniscus::runtime::{Estimate, Estimator, InputSource, Memory, TurnInput};
use meniscus::surface::{POINTS, SurfaceProfile};
use meniscus::units::GRAVITY_M_S2;
use meniscus_platform::clock::NoClock;
use nalgebra::SMatrix;

/// Matrix on latent space.
type Square = SMatrix<f64, LATENTS, LATENTS>;

/// A learned model that plans.
#[derive(Debug)]
pub struct LearnedModel<'m> {
    model: &'m Model<'m>,
    wall: WallMap,
    /// Slopes of both ends in the latents about rest, m.
    slopes: [Latent; 2],
    /// The decoder's own surface at rest, m: what a forecast is above the liquid at rest is counted from it.
    rest_m: [f64; POINTS],
    /// Misfit d of the decoder at the ends, m2.
    misfit_m2: f64,
    /// Covariance of a liquid that has been watched at rest.
    settled: Square,
    /// Variance of both ends ahead.
    ahead: [EndAhead; 2],
}

/// Latents with their error.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnedState {
    /// State of the GENERIC step.
    pub latent: LatentState,
    /// P.
    pub covariance: Square,
}

impl<'m> LearnedModel<'m> {
    /// The planner's view of a checked model.
    #[must_use]
    pub fn new(model: &'m Model<'m>) -> Self {
        let wall = WallMap::new();
        let errors = &model.error_model;
        let ends = |latent: usize| {
            let column = std::array::from_fn(|point| errors.surface[(latent, point)]);
            wall.ends(&column)
        };
        let slopes = [0, 1].map(|end: usize| Latent::from_fn(|latent, _| ends(latent)[end]));
        let ahead = slopes.each_ref().map(|slope| EndAhead::new(slope, &errors.transition, &errors.process));
        let misfit = |index: usize| f64::from(errors.surface_misfit[index]);
        let mut out = Self {
            model,
            wall,
            slopes,
            rest_m: [0.0; POINTS],
            misfit_m2: misfit(0).max(misfit(POINTS - 1)),
            settled: Square::zeros(),
            ahead,
        };
        out.rest_m = out.surface_m(&LatentState::default());
        out.settled = out.watched_at_rest();
        out
    }

    /// The state of a published estimate. Inner variables of embedded effects start relaxed.
    #[must_use]
    pub fn state(&self, estimate: &Estimate) -> LearnedState {
        let covariance = Square::from_fn(|row, column| f64::from(estimate.covariance.at(row, column)));
        let latent = LatentState { latent: Latent::from(estimate.latent), ..LatentState::default() };
        LearnedState { latent, covariance }
    }

    /// Covariance after a second of watching a liquid at rest.
    fn watched_at_rest(&self) -> Square {
        let (estimator, mut memory) = (Estimator::new(self.model), Memory::default());
        let profile = SurfaceProfile {
            height_m: self.rest_m.map(|z| z as f32),
            variance_m2: [1e-8; POINTS],
            valid: [true; POINTS],
            glass_x_m: Some(0.0),
            sequence: 0,
            captured: meniscus::units::Micros(0),
        };
        let mut covariance = Square::zeros();
        for _ in 0..60 {
            let estimate = estimator.turn(&mut memory, TurnInput::tracked(&profile), &mut NoClock, &mut []);
            covariance = self.state(&estimate).covariance;
        }
        covariance
    }

    /// The 21 heights of `state`, m above the inner bottom.
    fn surface_m(&self, state: &LatentState) -> [f64; POINTS] {
        let latent: [f64; LATENTS] = state.latent.into();
        let coefficients = self.model.decoder.coefficients(&latent.map(|x| x as f32), 0.0);
        let mut heights = self.model.decoder.surface(&coefficients);
        if let Some(observation_model) = &self.model.observation_model {
            observation_model.add_offset(&mut heights);
        }
        heights.map(f64::from)
    }

    /// The frame of the latents of `state`, whose ends have the variance `latent_m2` by them.
    fn seen(&self, state: &LatentState, latent_m2: f64) -> FrameForecast {
        let mut heights = self.surface_m(state);
        heights.iter_mut().zip(self.rest_m).for_each(|(z, rest)| *z -= rest);
        let errors = &self.model.error_model;
        let at_rest = f64::from(errors.factors.rest_noise_std_m);
        let variance = latent_m2 + self.weight(state) * self.misfit_m2 + at_rest * at_rest;
        FrameForecast {
            wall_m: self.wall.wall(&heights),
            half_width_m: f64::from(errors.factors.crest) * variance.max(0.0).sqrt(),
        }
    }

    /// w of `state`.
    fn weight(&self, state: &LatentState) -> f64 {
        let floor = f64::from(self.model.error_model.factors.weight_floor);
        floor + self.model.generic.potential.value(&state.latent)
    }

    /// The input of the port for an acceleration, which a robot that lags or scales changes.
    fn port(&self, input: f64) -> f64 {
        let gain =
            self.model.observation_model.as_ref().map_or(1.0, |observation_model| observation_model.gain);
        gain * input / f64::from(self.model.header.acceleration_scale)
    }
}

impl SurfaceModel for LearnedModel<'_> {
    type State = LearnedState;

    const INPUT: FrameInput = FrameInput::SecondDifference;

    fn rest(&self) -> LearnedState {
        LearnedState { latent: LatentState::default(), covariance: self.settled }
    }

    fn advance(&self, state: &mut LearnedState, input: f64) {
        let errors = &self.model.error_model;
        let next = errors.transition * state.covariance * errors.transition.transpose()
            + errors.process * self.weight(&state.latent);
        state.covariance = next;
        self.model.generic.step(&mut state.latent, self.port(input));
    }

    fn look(&self, state: &LearnedState, _: f64) -> FrameForecast {
        let of = |slope: &Latent| slope.dot(&(state.covariance * slope));
        self.seen(&state.latent, of(&self.slopes[0]).max(of(&self.slopes[1])))
    }

    /// The same frames as by `advance` and `look`, without a covariance in each.
    fn forecast(&self, from: &LearnedState, inputs: &[f64]) -> Vec<FrameForecast> {
        if inputs.len() > FRAMES {
            return stepped(self, from, inputs);
        }
        let mut latent = from.latent;
        let mut weights = Vec::with_capacity(inputs.len());
        let frame = |input: &f64| {
            weights.push(self.weight(&latent));
            self.model.generic.step(&mut latent, self.port(*input));
            let [left, right] = self.ahead.each_ref().map(|end| end.variance_m2(&from.covariance, &weights));
            self.seen(&latent, left.max(right))
        };
        inputs.iter().map(frame).collect()
    }

    fn room_m(&self) -> f64 {
        self.model.header.rim_m - self.model.header.fill_m
    }

    fn static_m(&self) -> f64 {
        self.model.header.radius_m / GRAVITY_M_S2
    }
}

/// The estimator of a learned model, given the robot's motion.
#[derive(Clone, Debug, Default)]
pub struct LearnedWatcher {
    memory: Memory,
}

impl Watcher<LearnedModel<'_>> for LearnedWatcher {
    fn watch(
        &mut self,
        model: &LearnedModel<'_>,
        profile: &SurfaceProfile,
        input: f64,
        now_m_s2: f64,
    ) -> LearnedState {
        let source = InputSource::Measured { before: input, now: now_m_s2 };
        let input = TurnInput { profile: Some(profile), source, surface_us: 0 };
        let estimator = Estimator::new(model.model).only(meniscus::latent::decoder::Selection::NONE);
        model.state(&estimator.turn(&mut self.memory, input, &mut NoClock, &mut []))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_platform::files::AlignedBytes;

    #[test]
    fn a_forecast_is_that_of_the_covariance_stepped_frame_by_frame() {
        let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
        let model = Model::load(&bytes).expect("the shipped model");
        let learned = LearnedModel::new(&model);
        let mut from = learned.rest();
        from.covariance += Square::identity() * 1e-3;
        let inputs: Vec<f64> = (0..200).map(|k| 2.0 * (0.3 * f64::from(k)).sin()).collect();
        let (ahead, stepped) = (learned.forecast(&from, &inputs), stepped(&learned, &from, &inputs));
        assert_eq!(ahead.len(), stepped.len());
        for (ahead, stepped) in ahead.iter().zip(&stepped) {
            assert_eq!(ahead.wall_m, stepped.wall_m);
            let apart = (ahead.half_width_m / stepped.half_width_m - 1.0).abs();
            assert!(apart < 1e-9, "{} m for {} m", ahead.half_width_m, stepped.half_width_m);
        }
        let (least, largest) = stepped.iter().fold((f64::MAX, 0.0_f64), |(least, largest), frame| {
            (least.min(frame.half_width_m), largest.max(frame.half_width_m))
        });
        assert!(largest > 1.2 * least, "the half-width changes: {least} to {largest} m");
        assert!(FRAMES >= crate::search::longest_frames(), "the longest plan is covered");
    }
}
