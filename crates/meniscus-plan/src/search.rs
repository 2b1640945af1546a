//! The shortest duration whose lowest crest is the limit, and the forecast that verifies it.
//!
//! The lowest crest c(T) falls with the duration, c ~ 1/T^2 for a slow surface. The root of c(T) = 1 is bracketed and found by
//! interpolation in log c over log T. The last duration is where the next search starts; an interior-point method has no other
//! warm start.

use crate::PlanError;
use crate::course::{Course, GlassState};
use crate::models::{FrameForecast, SurfaceModel};
use crate::program::{Answer, Correction, Program};
use crate::request::Request;
use crate::response::{Departure, Response, inputs_of};
use meniscus::units::FRAME_INTERVAL_S;

/// Longest duration, s.
const LONGEST_S: f64 = 12.0;

/// Time between two knots, s, for motions of up to [`MOST_KNOTS`] of them.
const KNOT_S: f64 = 1.0 / 30.0;

/// Fewest and most knots.
const FEWEST_KNOTS: usize = 6;
const MOST_KNOTS: usize = 40;

/// Frames behind the arrival over which the surface is limited: two periods of the first mode.
const TAIL_FRAMES: usize = 30;

/// Relative width at which the search for the duration ends.
const TOLERANCE: f64 = 0.004;

/// Part of the limit above which a crest counts as at the limit.
const NEAR: f64 = 0.985;

/// Programs in a full search.
const TRIES: usize = 16;

/// Rounds of program and forecast.
const ROUNDS: usize = 8;

/// Relative excess over the limit that a forecast may have.
const EXCESS: f64 = 2e-3;

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

/// A duration with its solution.
#[derive(Clone, Debug)]
struct Timed {
    duration_s: f64,
    answer: Answer,
}

/// Frames of the longest search.
pub(crate) fn longest_frames() -> usize {
    frames_of(LONGEST_S)
}

/// Frames of a motion and its tail.
fn frames_of(duration_s: f64) -> usize {
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
    /// The liquid left to itself, of which the linear response knows nothing.
    fn free(&self, frames: usize) -> Correction {
        let quiet = self.model.forecast(self.from, &vec![0.0; frames]);
        self.correction(&quiet, &vec![[0.0; 2]; frames])
    }

    /// What `linear` lacks of the forecast `frames`.
    fn correction(&self, frames: &[FrameForecast], linear: &[[f64; 2]]) -> Correction {
        let widening = self.request.widening();
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

    /// The program of one duration, solved.
    fn program(&mut self, duration_s: f64, correction: &Correction) -> Result<Option<Answer>, PlanError> {
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
        }
        .solve()
    }

    /// The motion of a solution.
    fn course(&self, duration_s: f64, answer: Answer) -> Course {
        let knot_s = duration_s / answer.jerks_m_s3.len() as f64;
        Course { start: self.departure.glass, knot_s, jerks_m_s3: answer.jerks_m_s3 }
    }

    /// Forecasts `course` by the whole model; also returns what the linear response lacks there.
    pub(crate) fn examine(&self, course: &Course) -> (Plan, Correction) {
        let count = frames_of(course.duration_s());
        let inputs = inputs_of(M::INPUT, self.departure.before_m, count, |t| course.at(t));
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

    /// Whether the forecast of `plan` keeps the limits of the surface.
    fn keeps(&self, plan: &Plan) -> bool {
        let most = (1.0 + EXCESS) * self.request.limit_m;
        let arrived = (plan.course.duration_s() / FRAME_INTERVAL_S) as usize;
        let widening = self.request.widening();
        let bound = |frame: &FrameForecast| frame.crest_m() + widening * frame.half_width_m;
        let rest = self.request.residual_m.map_or(most, |residual_m| (1.0 + EXCESS) * residual_m);
        plan.bound_m <= most && plan.frames.iter().skip(arrived).all(|frame| bound(frame) <= rest)
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
            let found = self.fastest(guess_s, shortest_s, TRIES, &correction)?;
            guess_s = found.duration_s;
            let (plan, next) = self.examine(&self.course(found.duration_s, found.answer));
            correction = next;
            lowest_m = plan.bound_m.min(lowest_m);
            let gains = best.as_ref().is_none_or(|best| {
                plan.course.duration_s() < (1.0 - TOLERANCE) * best.course.duration_s()
            });
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

    /// The shortest duration from `least_s` on whose lowest crest is not above the limit, by at most `tries` programs.
    fn fastest(
        &mut self,
        guess_s: f64,
        least_s: f64,
        tries: usize,
        correction: &Correction,
    ) -> Result<Timed, PlanError> {
        let limit_m = self.request.limit_m;
        let (mut low_s, mut above) = (least_s, None::<f64>);
        let mut high: Option<Timed> = None;
        let mut lowest_m = f64::NAN;
        let mut duration_s = guess_s.max(least_s * (1.0 + 1e-6));
        for _ in 0..tries {
            match self.program(duration_s, correction)? {
                None => (low_s, above) = (duration_s, None),
                Some(answer) => {
                    let ratio = answer.crest_m / limit_m;
                    lowest_m = answer.crest_m.min(lowest_m);
                    if ratio > 1.0 {
                        (low_s, above) = (duration_s, Some(ratio));
                    } else {
                        high = Some(Timed { duration_s, answer });
                        if ratio > NEAR {
                            break;
                        }
                    }
                }
            }
            duration_s = match &high {
                Some(high) if high.duration_s <= low_s * (1.0 + TOLERANCE) => break,
                Some(high) => between(low_s, above, high, limit_m),
                // c falls with 1/T^2 where the surface is slow, and less where the present slosh is the crest.
                None => low_s * above.map_or(1.15, |ratio| ratio.sqrt().clamp(1.02, 1.6)),
            };
            if duration_s > LONGEST_S {
                break;
            }
        }
        high.ok_or(PlanError::Infeasible { longest_s: duration_s.min(LONGEST_S), crest_m: lowest_m, limit_m })
    }

    /// One search of few programs from a motion that is under way, verified once.
    pub(crate) fn renewed(&mut self, under_way: &Course) -> Result<Plan, PlanError> {
        let (kept, correction) = self.examine(under_way);
        let remaining_s = under_way.duration_s();
        let Some(answer) = self.program(remaining_s, &correction)? else { return Ok(kept) };
        let ratio = answer.crest_m / self.request.limit_m;
        let mut course = self.course(remaining_s, answer);
        if !(0.96..=1.0).contains(&ratio) {
            // c ~ 1/T^2; a sixth of the motion at most, as the next turn comes soon.
            let duration_s = remaining_s * ratio.max(0.0).sqrt().clamp(0.85, 1.2);
            if let Some(answer) = self.program(duration_s, &correction)? {
                let worth = ratio > 1.0 && answer.crest_m < 0.99 * ratio * self.request.limit_m
                    || ratio < 1.0 && answer.crest_m <= self.request.limit_m;
                if worth {
                    course = self.course(duration_s, answer);
                }
            }
        }
        Ok(self.examine(&course).0)
    }
}

/// A duration between `low_s` and that of `high`, where log c over log T meets the limit.
fn between(low_s: f64, above: Option<f64>, high: &Timed, limit_m: f64) -> f64 {
    let (low, top) = (low_s.ln(), high.duration_s.ln());
    let below = (high.answer.crest_m / limit_m).max(1e-3).ln();
    let share = match above {
        Some(ratio) => (ratio.ln() / (ratio.ln() - below)).clamp(0.1, 0.95),
        // No crest is known at the lower end: by c ~ 1/T^2 from the upper one.
        None => ((top + 0.5 * below - low) / (top - low)).clamp(0.1, 0.9),
    };
    (low + share * (top - low)).exp()
}
