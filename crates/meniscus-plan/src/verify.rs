//! The forecast of a motion by the whole model: what the linear response lacks, and whether the limits of the surface are kept.

use crate::course::Course;
use crate::models::{FrameForecast, SurfaceModel};
use crate::program::Correction;
use crate::response::inputs_of;
use crate::search::{Plan, Search, frames_of};
use meniscus::units::FRAME_INTERVAL_S;

/// Relative excess over the limit that a forecast may have.
const EXCESS: f64 = 2e-3;

/// Highest bounds of a forecast over their limits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Used {
    /// Of the whole motion.
    pub(crate) crest: f64,
    /// After arrival; zero where that has no limit of its own.
    pub(crate) residual: f64,
}

impl Used {
    /// Whether both limits are kept.
    pub(crate) fn keeps(self) -> bool {
        self.most() <= 1.0 + EXCESS
    }

    /// The larger one.
    pub(crate) fn most(self) -> f64 {
        self.crest.max(self.residual)
    }

    /// The number that falls with the duration. A program of the lowest crest leaves as much slosh after arrival as it may, so that
    /// this is at its limit for every duration, and tells something only where it is above.
    pub(crate) fn ratio(self) -> f64 {
        if self.keeps() { self.crest } else { self.most() }
    }
}

impl<M: SurfaceModel> Search<'_, M> {
    /// Factor on the half-widths of a forecast.
    fn widening(&self) -> f64 {
        self.share * self.request.widening()
    }

    /// The liquid left to itself, of which the linear response knows nothing.
    pub(crate) fn free(&self, frames: usize) -> Correction {
        let quiet = self.model.forecast(self.from, &vec![0.0; frames]);
        self.correction(&quiet, &vec![[0.0; 2]; frames])
    }

    /// Difference of the forecast `frames` from `linear`, with the half-widths.
    fn correction(&self, frames: &[FrameForecast], linear: &[[f64; 2]]) -> Correction {
        let widening = self.widening();
        let lacks = |(frame, linear): (&FrameForecast, &[f64; 2])| {
            // Second-order waves may put the highest point beside an end.
            let [left, right] = frame.ends_m();
            let (low, high) = frame.wall_m.split_at(frame.wall_m.len() / 2);
            let most = |part: &[f64], end: f64| part.iter().copied().fold(end, f64::max);
            [most(low, left) - linear[0], most(high, right) - linear[1]]
        };
        Correction {
            offset_m: frames.iter().zip(linear).map(lacks).collect(),
            half_m: frames.iter().map(|frame| widening * frame.half_width_m).collect(),
        }
    }

    /// Forecasts `course` by the whole model; also returns what the linear response lacks there.
    pub(crate) fn examine(&self, course: &Course) -> (Plan, Correction) {
        let count = frames_of(course.duration_s());
        let mut along = course.along();
        let inputs = inputs_of(M::INPUT, self.departure.before_m, count, |t| along.to(t));
        let frames = self.model.forecast(self.from, &inputs);
        let correction = self.correction(&frames, &self.response.heights(&inputs));
        let mut plan = Plan {
            course: course.clone(),
            frames: Vec::new(),
            crest_m: f64::NEG_INFINITY,
            half_width_m: 0.0,
            bound_m: f64::NEG_INFINITY,
            programs: self.programs,
        };
        for (frame, half) in frames.iter().zip(&correction.half_m) {
            if frame.crest_m() > plan.crest_m {
                (plan.crest_m, plan.half_width_m) = (frame.crest_m(), *half);
            }
            plan.bound_m = plan.bound_m.max(frame.crest_m() + half);
        }
        plan.frames = frames;
        (plan, correction)
    }

    /// Shares of the limits that the forecast of `plan` uses.
    pub(crate) fn used(&self, plan: &Plan) -> Used {
        let crest = plan.bound_m / self.request.limit_m;
        let Some(residual_m) = self.request.residual_m else { return Used { crest, residual: 0.0 } };
        let arrived = (plan.course.duration_s() / FRAME_INTERVAL_S) as usize;
        let widening = self.widening();
        let bound = |frame: &FrameForecast| frame.crest_m() + widening * frame.half_width_m;
        let left_m = plan.frames.iter().skip(arrived).map(bound).fold(f64::NEG_INFINITY, f64::max);
        Used { crest, residual: left_m / residual_m }
    }

    /// Whether the forecast of `plan` keeps the limits of the surface.
    pub(crate) fn keeps(&self, plan: &Plan) -> bool {
        self.used(plan).keeps()
    }
}
