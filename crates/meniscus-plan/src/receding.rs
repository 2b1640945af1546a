//! Planning again from a measured state, while the glass is in progress.
//!
//! A state that is measured in frame n takes effect in frame n + 2: until then the robot follows the motion that it has. From
//! there on the rest of the move is planned anew.

use crate::PlanError;
use crate::course::{Course, GlassState};
use crate::models::SurfaceModel;
use crate::renew::Renewed;
use crate::request::Request;
use crate::response::{Departure, Response, inputs_of};
use crate::search::{Plan, Search, check, longest_frames, plan};
use meniscus::units::FRAME_INTERVAL_S;

/// Frames from a measured state to the motion that it changes: 33 ms for camera, estimator and program.
pub const LEAD_FRAMES: usize = 2;

/// Frames between two plans: 10 Hz.
pub const PERIOD_FRAMES: usize = 6;

/// Rest of the move that is not planned anew, s.
const LAST_S: f64 = 0.15;

/// Distance from the goal below which the move is not planned anew, m.
const NEAR_M: f64 = 0.002;

/// Part of the half-widths that a renewed plan keeps below the limit. A first plan keeps them whole. The estimate moves by a part of its
/// error between two looks; a motion that was changed for each of these moves ended up worse than the first plan.
const RENEWED_SHARE: f64 = 0.5;

/// A motion in the making: the parts of the courses that are carried out.
#[derive(Debug)]
pub struct Receding<'a, M: SurfaceModel> {
    model: &'a M,
    request: Request,
    response: Response,
    /// First frame and course of each part.
    parts: Vec<(usize, Course)>,
    first: Plan,
}

impl<M: SurfaceModel> Clone for Receding<'_, M> {
    fn clone(&self) -> Self {
        let Self { model, request, response, parts, first } = self;
        Self {
            model,
            request: *request,
            response: response.clone(),
            parts: parts.clone(),
            first: first.clone(),
        }
    }
}

impl<'a, M: SurfaceModel> Receding<'a, M> {
    /// Plans from rest at `from_m`.
    ///
    /// # Errors
    /// As for [`plan`].
    pub fn new(model: &'a M, liquid: &M::State, from_m: f64, request: &Request) -> Result<Self, PlanError> {
        check(model, from_m, request)?;
        let first = plan(model, liquid, from_m, request)?;
        let response = Response::of(model, longest_frames());
        Ok(Self { model, request: *request, response, parts: vec![(0, first.course.clone())], first })
    }

    /// The first plan.
    #[must_use]
    pub fn first(&self) -> &Plan {
        &self.first
    }

    /// The glass at `time_s` since the start.
    #[must_use]
    pub fn at(&self, time_s: f64) -> GlassState {
        let part = self.parts.iter().rev().find(|(frame, _)| time_of(*frame) <= time_s);
        let (frame, course) = part.unwrap_or(&self.parts[0]);
        course.at(time_s - time_of(*frame))
    }

    /// Time of arrival, s.
    #[must_use]
    pub fn arrival_s(&self) -> f64 {
        self.parts.last().map_or(0.0, |(frame, course)| time_of(*frame) + course.duration_s())
    }

    /// Input of the liquid in frame `frame`.
    #[must_use]
    pub fn input(&self, frame: usize) -> f64 {
        let start_s = time_of(frame) - FRAME_INTERVAL_S;
        let before_m = self.at(start_s - FRAME_INTERVAL_S).position_m;
        inputs_of(M::INPUT, before_m, 1, |time_s| self.at(start_s + time_s))[0]
    }

    /// Plans the rest of the move from the liquid `measured` in frame `frame`. Returns the plan, which is the motion under way where that
    /// still keeps the limit, or `None` where the rest of the move is too short.
    ///
    /// # Errors
    /// [`PlanError::Solver`]; the robot then follows the motion that it has.
    pub fn renew(&mut self, frame: usize, measured: &M::State) -> Result<Option<Plan>, PlanError> {
        let start = frame + LEAD_FRAMES;
        let start_s = time_of(start);
        let glass = self.at(start_s);
        if self.arrival_s() - start_s < LAST_S || (self.request.to_m - glass.position_m).abs() < NEAR_M {
            return Ok(None);
        }
        let mut liquid = measured.clone();
        for ahead in 1..=LEAD_FRAMES {
            self.model.advance(&mut liquid, self.input(frame + ahead));
        }
        let departure = Departure { glass, before_m: self.at(start_s - FRAME_INTERVAL_S).position_m };
        let under_way = self.rest_of_the_way(start_s);
        let mut search = Search {
            model: self.model,
            response: &self.response,
            from: &liquid,
            departure,
            request: &self.request,
            share: RENEWED_SHARE,
            programs: 0,
        };
        let plan = match search.renewed(&under_way)? {
            Renewed::Kept(plan) => plan,
            Renewed::Changed(plan) => {
                self.parts.push((start, plan.course.clone()));
                plan
            }
        };
        Ok(Some(plan))
    }

    /// The present course from `start_s` on, with knots of its own there.
    fn rest_of_the_way(&self, start_s: f64) -> Course {
        let duration_s = self.arrival_s() - start_s;
        let parts = ((duration_s / FRAME_INTERVAL_S).ceil() as usize).max(1);
        let knot_s = duration_s / parts as f64;
        let acceleration = |k: usize| self.at(start_s + k as f64 * knot_s).acceleration_m_s2;
        let jerks_m_s3 = (0..parts).map(|k| (acceleration(k + 1) - acceleration(k)) / knot_s).collect();
        Course { start: self.at(start_s), knot_s, jerks_m_s3 }
    }
}

/// Time of a frame, s.
fn time_of(frame: usize) -> f64 {
    frame as f64 * FRAME_INTERVAL_S
}
