//! The motion of minimum jerk beside a plan, by the same model.

use crate::models::{FrameForecast, SurfaceModel};
use crate::response::inputs_of;
use crate::rivals::{Motion, minimum_jerk};
use crate::search::Plan;
use meniscus::units::FRAME_INTERVAL_S;

/// Frames behind the arrival of a motion whose surface is forecast.
const TAIL_FRAMES: usize = 30;

/// Halvings in the search for the time of an equal crest.
const HALVINGS: usize = 24;

/// The motion of minimum jerk over the distance of a plan.
#[derive(Clone, Debug)]
pub struct MinimumJerk {
    /// In the same time.
    pub motion: Motion,
    /// Its surface, frame by frame.
    pub frames: Vec<FrameForecast>,
    /// Its crest, m.
    pub crest_m: f64,
    /// Time in which it has the crest of the plan, s.
    pub equal_crest_s: f64,
}

/// Returns the surface of each frame behind the start of `motion`, until half a second after its end.
#[must_use]
pub fn forecast_motion<M: SurfaceModel>(model: &M, liquid: &M::State, motion: &Motion) -> Vec<FrameForecast> {
    let frames = (motion.duration_s / FRAME_INTERVAL_S).ceil() as usize + TAIL_FRAMES;
    let inputs = inputs_of(M::INPUT, motion.at(0.0).position_m, frames, |time_s| motion.at(time_s));
    model.forecast(liquid, &inputs)
}

/// Highest point of a forecast over the liquid at rest, m.
#[must_use]
pub fn crest_m(frames: &[FrameForecast]) -> f64 {
    frames.iter().map(FrameForecast::crest_m).fold(0.0, f64::max)
}

/// Compares `plan` with the motion of minimum jerk from the same liquid.
#[must_use]
pub fn compare<M: SurfaceModel>(model: &M, liquid: &M::State, plan: &Plan) -> MinimumJerk {
    let (course, duration_s) = (&plan.course, plan.course.duration_s());
    let (from_m, to_m) = (course.start.position_m, course.at(duration_s).position_m);
    let of = |duration_s: f64| minimum_jerk(from_m, to_m, duration_s);
    let crest_of = |duration_s: f64| crest_m(&forecast_motion(model, liquid, &of(duration_s)));
    // The crest falls with the duration but for ripples: the longest time whose crest is that of the plan is found from above.
    let (mut low_s, mut high_s) = (0.5 * duration_s, 3.0 * duration_s);
    for _ in 0..HALVINGS {
        let middle_s = 0.5 * (low_s + high_s);
        if crest_of(middle_s) > plan.crest_m { low_s = middle_s } else { high_s = middle_s }
    }
    let motion = of(duration_s);
    let frames = forecast_motion(model, liquid, &motion);
    MinimumJerk { crest_m: crest_m(&frames), motion, frames, equal_crest_s: high_s }
}
