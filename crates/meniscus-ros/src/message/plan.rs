//! `meniscus_msgs/srv/Plan` and its messages.

use super::Stamp;
use meniscus::surface::POINTS;
use ros2_client::Message;
use serde::{Deserialize, Serialize};

/// `geometry_msgs/Point`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// x, m.
    pub x: f64,
    /// y, m.
    pub y: f64,
    /// z, m.
    pub z: f64,
}

/// `meniscus_msgs/PlanSample`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlanSample {
    /// Instant on the wall clock.
    pub stamp: Stamp,
    /// Position of the glass.
    pub position: Point,
}

/// Request of `meniscus_msgs/srv/Plan`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlanRequest {
    /// Number of the plan.
    pub sequence: u32,
    /// Whether the run follows the plan from now on.
    pub follow: bool,
    /// The planned motion.
    pub samples: Vec<PlanSample>,
}

/// `meniscus_msgs/SurfaceForecast`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SurfaceForecast {
    /// Time after the stamp of the answer, s.
    pub after: f64,
    /// Heights, m.
    pub heights: [f32; POINTS],
    /// Half-widths with 90 % coverage, m.
    pub half_widths: [f32; POINTS],
}

/// Answer of `meniscus_msgs/srv/Plan`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlanResponse {
    /// Whether there is a forecast.
    pub accepted: bool,
    /// Number of the fault; 0 without one.
    pub fault: u8,
    /// The fault in a sentence.
    pub reason: String,
    /// Turn that the forecast begins at, on the host's clock.
    pub stamp: Stamp,
    /// The same on the camera's clock, us.
    pub camera_time: u64,
    /// Largest distance of the samples from the line of the model, m.
    pub across: f64,
    /// Predicted surfaces.
    pub profiles: Vec<SurfaceForecast>,
    /// Highest point, m.
    pub crest: f64,
    /// Its half-width with 90 % coverage, m.
    pub crest_half_width: f64,
    /// Time until then, s.
    pub crest_after: f64,
    /// Largest probability that a height passes the rim.
    pub spill_probability: f64,
    /// Length of the forecast, s.
    pub horizon: f64,
    /// Part of it with a planned motion, s.
    pub planned: f64,
}

impl Message for PlanRequest {}
impl Message for PlanResponse {}
