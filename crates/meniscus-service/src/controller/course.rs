//! Forecast under a plan: the same for the controller's record and for the plan service of the ROS 2 node.

use super::plan::Plan;
use super::record::ForecastPoint;
use super::spill::SpillRisk;
use meniscus::blob::Model;
use meniscus::runtime::Memory;
use meniscus::runtime::output::HostTime;

/// Turns of the forecast without a plan, and behind the end of one: half a second.
const HORIZON: usize = 30;

/// Turns of the forecast at most: two seconds.
pub const HORIZON_MAX: usize = 120;

/// Turns between two points of a forecast.
const POINT_EVERY: usize = 3;

/// Accelerations of the turns to come under a plan; none without one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Course {
    accelerations: Vec<f64>,
}

impl Course {
    /// Returns the course of `plan` behind the instant `host`; `None` where it has ended or the instant is not known.
    #[must_use]
    pub fn of(plan: &Plan, host: Option<HostTime>) -> Option<Self> {
        let at_ns = host?.unix_ns;
        let left_s = plan.left_s(at_ns);
        if left_s <= 0.0 {
            return None;
        }
        // Behind its end the glass rests, and the liquid rings out.
        let turns = ((left_s * 60.0).ceil() as usize + HORIZON).min(HORIZON_MAX);
        let mut accelerations = vec![0.0; turns];
        plan.accelerations(at_ns, &mut accelerations);
        Some(Self { accelerations })
    }

    /// Returns the accelerations, the next turn's first, m/s2.
    #[must_use]
    pub fn accelerations(&self) -> &[f64] {
        &self.accelerations
    }

    /// Returns risk and surface of the turns behind `memory`: every third turn of a plan; without one the risk within half a
    /// second alone.
    #[must_use]
    pub fn forecast(&self, model: &Model<'_>, memory: &Memory) -> (SpillRisk, Vec<ForecastPoint>) {
        let turns = self.accelerations.len();
        let mut points = Vec::with_capacity(turns.div_ceil(POINT_EVERY));
        let spill =
            SpillRisk::within(model, memory, turns.max(HORIZON), &self.accelerations, |ahead, point| {
                if turns > 0 && ahead % POINT_EVERY == 0 {
                    let (surface_m, half_width_m) = (point.surface_m, point.half_width_m);
                    points.push(ForecastPoint { ahead: ahead as u32, surface_m, half_width_m });
                }
            });
        (spill, points)
    }
}
