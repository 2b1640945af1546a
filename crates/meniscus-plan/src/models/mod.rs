//! Liquids that forecast a surface.

mod ahead;
mod learned;
mod pendulum;
mod reduced;
mod reduced_filter;

pub use learned::{LearnedModel, LearnedState, LearnedWatcher};
pub use pendulum::Pendulum;
pub use reduced::{ReducedLiquid, ReducedLiquidState};
pub use reduced_filter::ReducedWatcher;

use crate::wall::WALL;
use meniscus::surface::SurfaceProfile;

/// Input that a model takes from the positions of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameInput {
    /// Second difference of the positions of this frame and the two before, over the interval squared.
    SecondDifference,
    /// Mean acceleration since the frame before, along a motion of continuous speed: the change of speed over the interval.
    Mean,
}

/// The surface of one frame ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameForecast {
    /// Heights along the wall over the liquid at rest, from s = -1 to s = 1, m.
    pub wall_m: [f64; WALL],
    /// Half-width of a crest at either end that holds nine times out of ten, m.
    pub half_width_m: f64,
}

impl FrameForecast {
    /// Highest point along the wall, m.
    #[must_use]
    pub fn crest_m(&self) -> f64 {
        self.wall_m.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// Heights at both ends, m.
    #[must_use]
    pub fn ends_m(&self) -> [f64; 2] {
        [self.wall_m[0], self.wall_m[WALL - 1]]
    }
}

/// A liquid that forecasts its surface from a state, under one input a frame.
pub trait SurfaceModel {
    /// State of the liquid, with its error.
    type State: Clone;

    /// Kind of its input.
    const INPUT: FrameInput;

    /// Returns the liquid at rest.
    fn rest(&self) -> Self::State;

    /// Advances `state` by one frame under `input`, m/s2.
    fn advance(&self, state: &mut Self::State, input: f64);

    /// Returns the surface of `state` in a frame with this input.
    fn look(&self, state: &Self::State, input: f64) -> FrameForecast;

    /// Height of the rim over the liquid at rest, m.
    fn room_m(&self) -> f64;

    /// Height of a static surface at the end of the wall for each m/s2, m.
    fn static_m(&self) -> f64;

    /// Returns the surface in each frame after `from` under `inputs`.
    fn forecast(&self, from: &Self::State, inputs: &[f64]) -> Vec<FrameForecast> {
        stepped(self, from, inputs)
    }
}

/// Returns the forecast of `model` by its frames one after the other.
fn stepped<M: SurfaceModel + ?Sized>(model: &M, from: &M::State, inputs: &[f64]) -> Vec<FrameForecast> {
    let mut state = from.clone();
    let frame = |input: &f64| {
        model.advance(&mut state, *input);
        model.look(&state, *input)
    };
    inputs.iter().map(frame).collect()
}

/// An estimator that follows the liquid of a model by profiles and the motion that the robot carries out.
pub trait Watcher<M: SurfaceModel> {
    /// Takes the profile of a frame and the inputs of the robot's motion: of this frame, and at its instant. Returns the state.
    fn watch(&mut self, model: &M, profile: &SurfaceProfile, input: f64, now_m_s2: f64) -> M::State;
}
