//! One motion of the simulated glass: planned with the estimator in the loop, or by a rival without.

use super::camera::Camera;
use crate::PlanError;
use crate::course::GlassState;
use crate::models::{SurfaceModel, Watcher};
use crate::receding::{PERIOD_FRAMES, Receding};
use crate::request::Request;
use crate::rivals::Motion;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::motion::Kinematics;
use meniscus_sph::WatchedGlass;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Frames that the glass is watched at rest before it moves: more than the window of the encoder.
const WATCHED: usize = 30;

/// Frames behind arrival over which the crest counts, and those that the filter of the truth looks ahead.
const TAIL: usize = 24;
const AHEAD: usize = 5;

/// Why a motion was not carried out.
#[derive(Debug)]
pub enum Failure {
    /// It was not planned.
    Plan(PlanError),
    /// The simulation ended.
    Simulation(meniscus_sph::Error),
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Plan(error) => write!(f, "{error}"),
            Self::Simulation(error) => write!(f, "{error}"),
        }
    }
}

impl std::error::Error for Failure {}

impl From<PlanError> for Failure {
    fn from(error: PlanError) -> Self {
        Self::Plan(error)
    }
}

impl From<meniscus_sph::Error> for Failure {
    fn from(error: meniscus_sph::Error) -> Self {
        Self::Simulation(error)
    }
}

/// Glass and surface, frame by frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Trace {
    /// Position of the glass, m.
    pub position_m: Vec<f64>,
    /// Highest point along the wall over the liquid at rest, m.
    pub highest_m: Vec<f64>,
}

/// A motion that was carried out.
#[derive(Clone, Debug, Default)]
pub struct Carried {
    /// Time of arrival, s.
    pub arrival_s: f64,
    /// Highest point along the wall over the liquid at rest, by the simulator, m.
    pub crest_m: f64,
    /// Glass and surface.
    pub trace: Trace,
    /// Time that each plan during the move took, ms.
    pub solve_ms: Vec<f64>,
    /// Plans during the move that the solver did not give.
    pub unsolved: usize,
}

/// A settled glass, and the flag that ends its simulation.
#[derive(Clone, Copy, Debug)]
pub struct Bench<'a> {
    /// The glass at rest.
    pub glass: &'a WatchedGlass,
    /// Height of the liquid at rest, m.
    pub fill_m: f64,
    /// Ends the simulation once it is raised.
    pub stop: &'a AtomicBool,
}

/// Carries out `request` from 0 m, planned anew at 10 Hz from what `watcher` makes of the camera's profiles.
///
/// # Errors
/// [`Failure`], when the first plan or the simulation fails.
pub fn carry_planned<M: SurfaceModel, W: Watcher<M>>(
    bench: Bench<'_>,
    model: &M,
    mut watcher: W,
    mut camera: Camera,
    request: &Request,
) -> Result<Carried, Failure> {
    let mut glass = bench.glass.clone();
    let rest = glass.profile();
    let mut liquid = model.rest();
    for _ in 0..WATCHED {
        liquid = watcher.watch(model, &camera.see(&rest, 0.0), 0.0, 0.0);
    }
    let mut receding = Receding::new(model, &liquid, 0.0, request)?;
    let mut carried = Carried::default();
    carried.trace.position_m.push(0.0);
    let mut frame = 0;
    while (frame as f64) < receding.arrival_s() / FRAME_INTERVAL_S + (TAIL + AHEAD) as f64 {
        frame += 1;
        glass.advance(bench.stop, |t| Kinematics::along_x(receding.at(t).acceleration_m_s2))?;
        let state = receding.at(frame as f64 * FRAME_INTERVAL_S);
        let profile = camera.see(&glass.profile(), state.position_m);
        liquid = watcher.watch(model, &profile, receding.input(frame), state.acceleration_m_s2);
        carried.trace.position_m.push(state.position_m);
        if frame % PERIOD_FRAMES == 0 {
            let start = Instant::now();
            match receding.renew(frame, &liquid) {
                Ok(Some(_)) => carried.solve_ms.push(1e3 * start.elapsed().as_secs_f64()),
                Ok(None) => {}
                Err(_) => carried.unsolved += 1,
            }
        }
    }
    carried.arrival_s = receding.arrival_s();
    finish(&mut carried, &glass, bench.fill_m);
    Ok(carried)
}

/// Carries out `motion`, whatever the liquid does.
///
/// # Errors
/// [`Failure::Simulation`].
pub fn carry_rival(bench: Bench<'_>, motion: &Motion) -> Result<Carried, Failure> {
    let mut glass = bench.glass.clone();
    let frames = (motion.duration_s / FRAME_INTERVAL_S).ceil() as usize + TAIL + AHEAD;
    let at = |time_s: f64| -> GlassState { motion.at(time_s) };
    for _ in 0..frames {
        glass.advance(bench.stop, |t| Kinematics::along_x(at(t).acceleration_m_s2))?;
    }
    let position_m = (0..=frames).map(|n| at(n as f64 * FRAME_INTERVAL_S).position_m).collect();
    let trace = Trace { position_m, highest_m: Vec::new() };
    let mut carried = Carried { arrival_s: motion.duration_s, trace, ..Carried::default() };
    finish(&mut carried, &glass, bench.fill_m);
    Ok(carried)
}

/// Takes the truth from the glass.
fn finish(carried: &mut Carried, glass: &WatchedGlass, fill_m: f64) {
    let highest = |row: Vec<f32>| row.into_iter().fold(0.0, f32::max);
    carried.trace.highest_m =
        glass.wall_m().into_iter().map(|row| f64::from(highest(row)) - fill_m).collect();
    carried.crest_m = carried.trace.highest_m.iter().copied().fold(0.0, f64::max);
}
