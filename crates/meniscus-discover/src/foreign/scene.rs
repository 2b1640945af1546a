//! Request to a simulator: glass, liquid, effects with their sizes, and tables of motion.

use crate::insert::simulated::Course;
use meniscus::surface::{POINTS, profile_abscissa};
use meniscus::units::{FRAME_INTERVAL_S, GRAVITY_M_S2};
use meniscus_data::motion::Motion;
use meniscus_sph::Setup;
use serde::Serialize;
use std::collections::BTreeMap;

/// Version of the protocol, raised when a program that read the one before would read this one wrongly.
pub const FORMAT: u32 = 1;

/// Scene of one settled glass with some motions, in SI units.
#[derive(Clone, Debug, Serialize)]
pub struct Scene {
    /// Version, [`FORMAT`].
    pub meniscus_simulator: u32,
    /// Acceleration of gravity, m/s2.
    pub gravity_m_s2: f64,
    /// Glass.
    pub glass: SceneGlass,
    /// Liquid.
    pub liquid: SceneLiquid,
    /// Values of the effects by the spelling of their parameters, SI; infinite ones are null in JSON.
    pub effects: BTreeMap<&'static str, f64>,
    /// Resolution of the simulation; a model without a resolution ignores it.
    pub resolution: SceneResolution,
    /// Time between two frames, s; the first is at time 0.
    pub frame_interval_s: f64,
    /// Positions of the heights in the frame of the glass, m: along its motion, and away from the camera.
    pub points_m: Vec<[f64; 2]>,
    /// Motions.
    pub motions: Vec<SceneMotion>,
}

/// Upright cylindrical glass, sizes from the inner bottom.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SceneGlass {
    /// Inner radius, m.
    pub radius_m: f64,
    /// Height of the liquid at rest, m.
    pub fill_m: f64,
    /// Height of the rim, m.
    pub rim_m: f64,
}

/// Newtonian liquid as stated.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SceneLiquid {
    /// Density, kg/m3.
    pub density_kg_m3: f64,
    /// Viscosity, Pa s.
    pub viscosity_pa_s: f64,
}

/// Resolution of a simulation.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SceneResolution {
    /// Distance of particles or nodes, m.
    pub spacing_m: f64,
    /// Seed of whatever is drawn.
    pub seed: u64,
}

/// Motion of the glass along x, sampled evenly; the liquid rests at its start.
#[derive(Clone, Debug, Serialize)]
pub struct SceneMotion {
    /// Frames that are wanted of it.
    pub frames: usize,
    /// Times, s.
    pub time_s: Vec<f64>,
    /// Positions, m.
    pub x_m: Vec<f64>,
    /// Accelerations of the smooth curve through the positions, m/s2.
    pub acceleration_m_s2: Vec<f64>,
}

impl Scene {
    /// Returns the scene of `courses` in `setup`.
    ///
    /// # Errors
    /// In words, when a motion cannot be joined to a curve.
    pub fn new(setup: &Setup, courses: &[&Course]) -> Result<Self, String> {
        let Setup { glass, liquid, spacing_m, seed, effects, .. } = setup;
        let motions = courses.iter().map(|course| motion(course)).collect::<Result<Vec<_>, String>>()?;
        Ok(Self {
            meniscus_simulator: FORMAT,
            gravity_m_s2: GRAVITY_M_S2,
            glass: SceneGlass { radius_m: glass.radius_m, fill_m: glass.fill_m, rim_m: glass.rim_m },
            liquid: SceneLiquid {
                density_kg_m3: liquid.density_kg_m3,
                viscosity_pa_s: liquid.rheology.consistency,
            },
            effects: effects.on().into_iter().map(|(parameter, value)| (parameter.spelling, value)).collect(),
            resolution: SceneResolution { spacing_m: *spacing_m, seed: *seed },
            frame_interval_s: FRAME_INTERVAL_S,
            points_m: points(glass.radius_m).to_vec(),
            motions,
        })
    }
}

/// Returns the points of the wall that faces the camera at which heights are wanted.
fn points(radius_m: f64) -> [[f64; 2]; POINTS] {
    std::array::from_fn(|point| {
        let s = profile_abscissa(point);
        [radius_m * s, -radius_m * (1.0 - s * s).sqrt()]
    })
}

fn motion(course: &Course) -> Result<SceneMotion, String> {
    let curve = Motion::sampled(&course.samples).ok_or("its motion cannot be joined to a curve")?;
    let (time_s, x_m): (Vec<f64>, Vec<f64>) = course.samples.iter().copied().unzip();
    let acceleration_m_s2 = time_s.iter().map(|t| curve.acceleration(*t)).collect();
    Ok(SceneMotion { frames: course.frames, time_s, x_m, acceleration_m_s2 })
}
