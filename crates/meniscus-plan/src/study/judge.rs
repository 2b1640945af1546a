//! One move, planned and by its rivals.

use super::camera::Camera;
use super::carry::{Bench, Carried, Failure, Trace, carry_planned, carry_rival};
use super::draw::{Move, StudyLiquid};
use crate::compare::{crest_m, forecast_motion};
use crate::models::{LearnedModel, LearnedWatcher, Pendulum, ReducedLiquid, ReducedWatcher, SurfaceModel};
use crate::request::Request;
use crate::rivals::{Motion, minimum_jerk, pendulum, shaped, trapezoid};
use crate::search::{plan, smoothest};
use serde::{Deserialize, Serialize};

/// Version of the outcomes in a folder; others are not read.
pub(super) const VERSION: u32 = 4;

/// Relative difference of two crests that count as equal.
const EQUAL: f64 = 0.03;

/// Simulations in the search for the time of an equal crest.
const TRIES: usize = 2;

/// Kind of a model that plans.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Planner {
    /// A learned model of that liquid.
    Learned,
    /// The reduced slosh model.
    Reduced,
}

impl Planner {
    /// Name in files.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Learned => "learned",
            Self::Reduced => "reduced",
        }
    }
}

/// Result of one move.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Version of this form.
    pub version: u32,
    /// The move.
    pub of: Move,
    /// Kind of the model that planned.
    pub planner: Planner,
    /// Time of arrival in the first plan, s.
    pub planned_s: f64,
    /// Time of arrival, s.
    pub arrival_s: f64,
    /// Crest and half-width of the first plan, m.
    pub predicted_m: [f64; 2],
    /// Crest by the simulator, m.
    pub crest_m: f64,
    /// Time of each plan during the move, ms.
    pub solve_ms: Vec<f64>,
    /// Plans during the move that the solver did not give.
    pub unsolved: usize,
    /// Crest of the motion of minimum jerk in the same time, by the simulator, m.
    pub minimum_jerk_m: f64,
    /// Time in which the motion of minimum jerk has the crest of the plan, by the simulator, s.
    pub equal_crest_s: f64,
    /// Crests of other rivals in the same time, by the model that planned, m; none where a rival takes longer.
    pub rivals_m: Vec<(String, Option<f64>)>,
    /// Lowest crest in the same time over that of minimum jerk, both by the model that planned and without a half-width: no planner
    /// can be better by this model.
    pub model_bound: f64,
    /// The motion that was carried out.
    pub planned: Trace,
    /// Minimum jerk in the same time.
    pub minimum_jerk: Trace,
}

/// Models that plan and estimate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Planners<'a> {
    pub(super) glycerine: &'a LearnedModel<'a>,
    /// Plans water where there is one; the reduced model does otherwise.
    pub(super) learned_water: Option<&'a LearnedModel<'a>>,
    pub(super) water: &'a ReducedLiquid,
    /// First modes of both liquids, for the rivals that need one.
    pub(super) first_modes: [Pendulum; 2],
}

/// Carries out a move in every way.
pub(super) fn judge(planners: &Planners<'_>, bench: Bench<'_>, of: &Move) -> Result<Outcome, Failure> {
    let camera = Camera::new(of.seed);
    let [glycerine, water] = &planners.first_modes;
    let (learned, mode) = match of.liquid {
        StudyLiquid::Glycerine => (Some(planners.glycerine), glycerine),
        StudyLiquid::Water => (planners.learned_water, water),
    };
    match learned {
        Some(model) => {
            let carried = carry_planned(bench, model, LearnedWatcher::default(), camera, &of.request)?;
            compare(model, mode, bench, of, &carried)
        }
        None => {
            let model = planners.water;
            let carried = carry_planned(bench, model, ReducedWatcher::default(), camera, &of.request)?;
            let outcome = compare(model, mode, bench, of, &carried)?;
            Ok(Outcome { planner: Planner::Reduced, ..outcome })
        }
    }
}

/// Compares a motion that was carried out with its rivals.
fn compare<M: SurfaceModel>(
    model: &M,
    mode: &Pendulum,
    bench: Bench<'_>,
    of: &Move,
    carried: &Carried,
) -> Result<Outcome, Failure> {
    let request = &of.request;
    let first = plan(model, &model.rest(), 0.0, request)?;
    let duration_s = carried.arrival_s;
    let same = minimum_jerk(0.0, request.to_m, duration_s);
    let plain = carry_rival(bench, &same)?;
    let others = [
        ("trapezoid", Some(trapezoid(0.0, request.to_m, duration_s))),
        ("input shaping", shaped(0.0, request.to_m, duration_s, mode)),
        ("pendulum", pendulum(mode, 0.0, request, duration_s).ok()),
    ];
    let mut rivals_m = Vec::new();
    for (name, motion) in others {
        let crest = motion.map(|motion| crest_m(&forecast_motion(model, &model.rest(), &motion)));
        rivals_m.push((name.into(), crest));
    }
    Ok(Outcome {
        version: VERSION,
        of: *of,
        planner: Planner::Learned,
        planned_s: first.course.duration_s(),
        arrival_s: duration_s,
        predicted_m: [first.crest_m, first.half_width_m],
        crest_m: carried.crest_m,
        solve_ms: carried.solve_ms.clone(),
        unsolved: carried.unsolved,
        minimum_jerk_m: plain.crest_m,
        equal_crest_s: equal_crest_s(bench, request, carried, &plain)?,
        rivals_m,
        model_bound: model_bound(model, request, &same)?,
        planned: carried.trace.clone(),
        minimum_jerk: plain.trace,
    })
}

/// Time in which the motion of minimum jerk has the crest of `carried`, s.
///
/// Crests of tried times are joined in log c over log T; c ~ 1/T^2 leads to the first.
fn equal_crest_s(
    bench: Bench<'_>,
    request: &Request,
    carried: &Carried,
    plain: &Carried,
) -> Result<f64, Failure> {
    let wanted = carried.crest_m;
    let mut last = (plain.arrival_s, plain.crest_m);
    let mut exponent = -2.0;
    for _ in 0..TRIES {
        let next_s = last.0 * (wanted / last.1).powf(1.0 / exponent).clamp(0.6, 1.7);
        if (wanted / last.1 - 1.0).abs() < EQUAL {
            return Ok(next_s);
        }
        let crest_m = carry_rival(bench, &minimum_jerk(0.0, request.to_m, next_s))?.crest_m;
        let slope = (crest_m / last.1).ln() / (next_s / last.0).ln();
        if slope.is_finite() {
            exponent = slope.clamp(-6.0, -0.7);
        }
        last = (next_s, crest_m);
    }
    Ok(last.0 * (wanted / last.1).powf(1.0 / exponent).clamp(0.8, 1.25))
}

/// The lowest crest over that of minimum jerk in the same time, by the model alone.
fn model_bound<M: SurfaceModel>(model: &M, request: &Request, same: &Motion) -> Result<f64, Failure> {
    let sure = Request { confidence: 0.5, ..*request };
    let lowest = smoothest(model, &model.rest(), 0.0, &sure, same.duration_s)?;
    Ok(lowest.crest_m / crest_m(&forecast_motion(model, &model.rest(), same)))
}
