//! The program with the rows that matter, against the one with all rows.

use super::*;
use crate::course::{Course, GlassState};
use crate::models::{Pendulum, SurfaceModel};
use crate::preferred::Preferred;
use crate::request::{Limits as RobotLimits, Request};
use crate::response::{Departure, Response};

/// Frames of every program here.
const FRAMES: usize = 90;

/// Solves `program` as it is, and with all of its rows at once.
fn both(program: &Program<'_>) -> [Option<Vec<f64>>; 2] {
    let limits = Limits::of(program);
    let all = program.solve_with(limits.all.iter()).expect("the solver ends");
    let mut chosen = limits.first(program);
    let lazy = program.solve_chosen(&limits, &mut chosen).expect("the solver ends");
    let share = chosen.iter().filter(|chosen| **chosen).count() as f64 / chosen.len() as f64;
    assert!(lazy.is_none() || share < 0.9, "{share} of the rows were taken");
    [lazy, all]
}

#[test]
fn the_rows_that_matter_give_the_solution_of_all_rows() {
    let pendulum = Pendulum { frequency: 22.0, damping: 0.3, radius_m: 0.035, room_m: 0.04 };
    let response = Response::of(&pendulum, FRAMES);
    let swinging = pendulum.forecast(&[0.004, 0.05], &[0.0; FRAMES]);
    let swings = Correction {
        offset_m: swinging.iter().map(crate::models::FrameForecast::ends_m).collect(),
        half_m: vec![0.0004],
    };
    let (slow, quick) = (RobotLimits { speed_m_s: 0.3, ..RobotLimits::default() }, RobotLimits::default());
    let (mut solved, mut fast) = (0, 0);
    for (limits, correction, residual_m) in [
        (quick, Correction::default(), None),
        (quick, swings.clone(), None),
        (quick, swings, Some(0.004)),
        (slow, Correction::default(), None),
    ] {
        let request = Request { to_m: 0.2, limits, limit_m: 0.006, confidence: 0.95, residual_m };
        let departure = Departure { glass: GlassState::resting(0.0), before_m: 0.0 };
        let mut nearby = None;
        for duration_s in [0.6, 0.8, 0.9, 1.0] {
            let program = Program {
                request: &request,
                departure: &departure,
                response: &response,
                correction: &correction,
                input: Pendulum::INPUT,
                duration_s,
                knots: 24,
                frames: FRAMES,
                preferred: Preferred::Small,
                nearby: nearby.as_ref(),
            };
            let [lazy, all] = both(&program);
            assert_eq!(lazy.is_some(), all.is_some(), "{duration_s} s");
            let (Some(lazy), Some(all)) = (lazy, all) else { continue };
            for (lazy, all) in lazy.iter().zip(&all) {
                assert!((lazy - all).abs() < 2e-3, "{lazy} for {all} at {duration_s} s");
            }
            let answer = program.answer(&lazy);
            assert!((answer.crest_m - program.answer(&all).crest_m).abs() < 1e-4 * request.limit_m);
            let start = departure.glass;
            let course = Course { start, knot_s: program.knot_s(), jerks_m_s3: answer.jerks_m_s3 };
            // The course of the jerks is the motion that the rows were about.
            let end = course.at(duration_s - 1e-9);
            assert!((end.position_m - 0.2).abs() < 1e-6 && end.speed_m_s.abs() < 1e-5, "{end:?}");
            let speed = (0..500).map(|n| course.at(duration_s * f64::from(n) / 500.0).speed_m_s);
            let fastest = speed.fold(0.0, f64::max);
            assert!(fastest <= limits.speed_m_s * (1.0 + 2e-5), "{fastest} m/s");
            solved += 1;
            fast += usize::from(fastest > 0.99 * limits.speed_m_s);
            nearby = Some(course);
        }
    }
    assert!(solved >= 10 && fast >= 1, "{solved} motions, {fast} of them at the limit of the speed");
}
