//! The shortest duration whose lowest crest is the limit, and the forecast that verifies it.
//!
//! The lowest crest c(T) falls with the duration, c ~ 1/T^2 for a slow surface. The root of c(T) = 1 is bracketed and found by
//! interpolation in log c over log T. The last duration is where the next search starts; an interior-point method has no other
//! warm start.

use crate::PlanError;
use crate::course::{Course, GlassState};
use crate::models::{FrameForecast, SurfaceModel};
use crate::preferred::Preferred;
use crate::program::{Answer, Correction, Program};
use crate::request::Request;
use crate::response::{Departure, Response};
use meniscus::units::FRAME_INTERVAL_S;

/// Longest duration, s.
pub(crate) const LONGEST_S: f64 = 12.0;

/// Time between two knots, s, for motions of up to [`MOST_KNOTS`] of them.
const KNOT_S: f64 = 1.0 / 30.0;

/// Fewest and most knots.
const FEWEST_KNOTS: usize = 6;
const MOST_KNOTS: usize = 40;

/// Frames behind the arrival over which the surface is limited: two periods of the first mode.
const TAIL_FRAMES: usize = 30;

/// Relative width at which the search for the duration ends.
pub(crate) const TOLERANCE: f64 = 0.004;

/// Rounds of program and forecast.
const ROUNDS: usize = 8;

/// A motion and the surface that it is forecast to make.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The motion.
    pub course: Course,
    /// Surface of each frame behind the start, until half a second after arrival, by the nonlinear model.
    pub frames: Vec<FrameForecast>,
    /// Highest point of the forecast over the liquid at rest, m.
    pub crest_m: f64,
    /// Half-width of that frame at the stated confidence, m.
    pub half_width_m: f64,
    /// Highest point with its half-width, m: what is kept below the limit.
    pub bound_m: f64,
    /// Programs that were solved.
    pub programs: usize,
}

/// Everything that a search starts from.
pub(crate) struct Search<'a, M: SurfaceModel> {
    pub(crate) model: &'a M,
    pub(crate) response: &'a Response,
    pub(crate) from: &'a M::State,
    pub(crate) departure: Departure,
    pub(crate) request: &'a Request,
    pub(crate) programs: usize,
}

/// Frames of the longest search.
pub(crate) fn longest_frames() -> usize {
    frames_of(LONGEST_S)
}

/// Frames of a motion and its tail.
pub(crate) fn frames_of(duration_s: f64) -> usize {
    (duration_s / FRAME_INTERVAL_S).ceil() as usize + TAIL_FRAMES
}

/// Plans the fastest motion from rest at `from_m`, for a liquid in the state `liquid`.
///
/// # Errors
/// [`PlanError`] with the value that is refused, or with the lowest crest that was found.
pub fn plan<M: SurfaceModel>(
    model: &M,
    liquid: &M::State,
    from_m: f64,
    request: &Request,
) -> Result<Plan, PlanError> {
    check(model, from_m, request)?;
    let response = Response::of(model, longest_frames());
    let departure = Departure { glass: GlassState::resting(from_m), before_m: from_m };
    Search { model, response: &response, from: liquid, departure, request, programs: 0 }.fastest_verified()
}

/// Plans the motion of the lowest crest that takes `duration_s`, from rest at `from_m`.
///
/// # Errors
/// As for [`plan`]; [`PlanError::Infeasible`] where the robot needs longer.
pub fn smoothest<M: SurfaceModel>(
    model: &M,
    liquid: &M::State,
    from_m: f64,
    request: &Request,
    duration_s: f64,
) -> Result<Plan, PlanError> {
    request.check(from_m)?;
    let response = Response::of(model, longest_frames());
    let departure = Departure { glass: GlassState::resting(from_m), before_m: from_m };
    let mut search = Search { model, response: &response, from: liquid, departure, request, programs: 0 };
    let mut correction = search.free(frames_of(duration_s));
    let mut best: Option<Plan> = None;
    for _ in 0..3 {
        let Some(answer) = search.program(duration_s, &correction)? else { break };
        let (plan, next) = search.examine(&search.course(duration_s, answer));
        if best.as_ref().is_none_or(|best| plan.bound_m < best.bound_m) {
            best = Some(plan);
        }
        correction = next;
    }
    let (longest_s, limit_m) = (duration_s, request.limit_m);
    best.ok_or(PlanError::Infeasible { longest_s, crest_m: f64::NAN, limit_m })
}

/// Refuses a request that this liquid cannot keep at all.
pub(crate) fn check<M: SurfaceModel>(model: &M, from_m: f64, request: &Request) -> Result<(), PlanError> {
    request.check(from_m)?;
    let Request { limit_m, confidence, .. } = *request;
    if limit_m >= model.room_m() {
        return Err(PlanError::Rim { limit_m, room_m: model.room_m() });
    }
    let half_width_m = request.widening() * model.look(&model.rest(), 0.0).half_width_m;
    if half_width_m >= limit_m.min(request.residual_m.unwrap_or(limit_m)) {
        return Err(PlanError::Uncertain { limit_m, half_width_m, confidence });
    }
    Ok(())
}

impl<M: SurfaceModel> Search<'_, M> {
    /// The program of one duration, solved.
    pub(crate) fn program(
        &mut self,
        duration_s: f64,
        correction: &Correction,
    ) -> Result<Option<Answer>, PlanError> {
        self.preferring(duration_s, correction, Preferred::Small)
    }

    /// The program of one duration near the `preferred` jerks, solved.
    pub(crate) fn preferring(
        &mut self,
        duration_s: f64,
        correction: &Correction,
        preferred: Preferred<'_>,
    ) -> Result<Option<Answer>, PlanError> {
        self.programs += 1;
        let knots = (duration_s / KNOT_S).ceil() as usize;
        Program {
            request: self.request,
            departure: &self.departure,
            response: self.response,
            correction,
            input: M::INPUT,
            duration_s,
            knots: knots.clamp(FEWEST_KNOTS, MOST_KNOTS),
            frames: frames_of(duration_s),
            preferred,
        }
        .solve()
    }

    /// The motion of a solution.
    pub(crate) fn course(&self, duration_s: f64, answer: Answer) -> Course {
        let knot_s = duration_s / answer.jerks_m_s3.len() as f64;
        Course { start: self.departure.glass, knot_s, jerks_m_s3: answer.jerks_m_s3 }
    }

    /// Searches, forecasts and searches again until the forecast keeps the limit.
    fn fastest_verified(&mut self) -> Result<Plan, PlanError> {
        let distance_m = (self.request.to_m - self.departure.glass.position_m).abs();
        let shortest_s = self.request.limits.shortest_s(distance_m);
        let still_s = 2.0 * (distance_m * self.model.static_m() / self.request.limit_m).sqrt();
        let mut guess_s = f64::max(1.02 * shortest_s, 1.1 * still_s).min(0.8 * LONGEST_S);
        let mut correction = self.free(frames_of(guess_s));
        let mut best: Option<Plan> = None;
        let mut lowest_m = f64::NAN;
        for _ in 0..ROUNDS {
            let found = self.fastest(guess_s, shortest_s, &correction)?;
            guess_s = found.duration_s;
            let (plan, next) = self.examine(&self.course(found.duration_s, found.answer));
            correction = next;
            lowest_m = plan.bound_m.min(lowest_m);
            let gains = best
                .as_ref()
                .is_none_or(|best| plan.course.duration_s() < (1.0 - TOLERANCE) * best.course.duration_s());
            if self.keeps(&plan) {
                if gains {
                    best = Some(plan);
                } else {
                    break;
                }
            } else if best.is_some() {
                break;
            }
        }
        let (longest_s, limit_m) = (guess_s, self.request.limit_m);
        match best {
            Some(plan) => Ok(plan),
            None => self.slower(guess_s, correction)?.ok_or(PlanError::Infeasible {
                longest_s,
                crest_m: lowest_m,
                limit_m,
            }),
        }
    }

    /// Longer and longer motions from a duration whose forecast did not keep the limit.
    fn slower(&mut self, from_s: f64, mut correction: Correction) -> Result<Option<Plan>, PlanError> {
        let mut duration_s = from_s;
        for _ in 0..20 {
            duration_s *= 1.03;
            let Some(answer) = self.program(duration_s, &correction)? else { continue };
            let (plan, next) = self.examine(&self.course(duration_s, answer));
            if self.keeps(&plan) {
                return Ok(Some(plan));
            }
            correction = next;
        }
        Ok(None)
    }
}
