//! Plans, and what a search for one starts from. The search itself stands in `shortest` and `verify`.

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
    /// Part of the half-widths that is kept below the limit.
    pub(crate) share: f64,
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
    Search { model, response: &response, from: liquid, departure, request, share: 1.0, programs: 0 }
        .fastest_verified()
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
    let mut search =
        Search { model, response: &response, from: liquid, departure, request, share: 1.0, programs: 0 };
    let mut correction = search.free(frames_of(duration_s));
    let best = search.settled(duration_s, &mut correction, None)?;
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
    /// The program of one duration, solved; its solution may be near a motion that is known.
    pub(crate) fn program(
        &mut self,
        duration_s: f64,
        correction: &Correction,
        nearby: Option<&Course>,
    ) -> Result<Option<Answer>, PlanError> {
        self.solve(duration_s, correction, Preferred::Small, nearby)
    }

    /// The program of one duration near the motion `under_way`, solved.
    pub(crate) fn program_near(
        &mut self,
        duration_s: f64,
        correction: &Correction,
        under_way: &Course,
    ) -> Result<Option<Answer>, PlanError> {
        self.solve(duration_s, correction, Preferred::Near(under_way), Some(under_way))
    }

    fn solve(
        &mut self,
        duration_s: f64,
        correction: &Correction,
        preferred: Preferred<'_>,
        nearby: Option<&Course>,
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
            nearby,
        }
        .solve()
    }

    /// The motion of a solution.
    pub(crate) fn course(&self, duration_s: f64, answer: Answer) -> Course {
        let knot_s = duration_s / answer.jerks_m_s3.len() as f64;
        Course { start: self.departure.glass, knot_s, jerks_m_s3: answer.jerks_m_s3 }
    }
}
