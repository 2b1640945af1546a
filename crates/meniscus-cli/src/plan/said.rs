//! Text and JSON of `meniscus plan`.

use meniscus_plan::{MinimumJerk, Plan, Request};
use meniscus_report::checks::Check;
use std::fmt::Write;

/// Instants at which the limits of the robot are looked at.
const INSTANTS: u32 = 1000;

/// A plan beside its rival.
pub(super) struct Planned<'a> {
    pub(super) request: &'a Request,
    pub(super) plan: &'a Plan,
    pub(super) rival: &'a MinimumJerk,
    pub(super) solve_ms: f64,
    pub(super) from_m: f64,
    pub(super) name: &'a str,
}

impl Planned<'_> {
    /// Largest speed and acceleration of the motion.
    fn largest(&self) -> [f64; 2] {
        let course = &self.plan.course;
        let step_s = course.duration_s() / f64::from(INSTANTS);
        let states = (0..=INSTANTS).map(|k| course.at(f64::from(k) * step_s));
        states.fold([0.0, 0.0], |[speed, acceleration], state| {
            [f64::max(speed, state.speed_m_s.abs()), f64::max(acceleration, state.acceleration_m_s2.abs())]
        })
    }

    /// The sentences for a person.
    pub(super) fn text(&self) -> String {
        let Self { request, plan, rival, .. } = self;
        let (duration_s, [speed, acceleration]) = (plan.course.duration_s(), self.largest());
        let mut text = String::new();
        // A `String` takes every line.
        let _written = writeln!(
            text,
            "{} m to {} m in {duration_s:.3} s: crest {:.2} mm ± {:.2} mm over the liquid at rest, limit {} mm at {} %",
            self.from_m,
            request.to_m,
            1e3 * plan.crest_m,
            1e3 * plan.half_width_m,
            1e3 * request.limit_m,
            100.0 * request.confidence
        );
        let _written = writeln!(
            text,
            "  largest speed {speed:.2} m/s, acceleration {acceleration:.2} m/s2; {}, {} programs, {:.0} ms",
            self.name, plan.programs, self.solve_ms
        );
        let _written = writeln!(
            text,
            "  minimum jerk in the same time: crest {:.2} mm; with this crest it takes {:.3} s",
            1e3 * rival.crest_m,
            rival.equal_crest_s
        );
        text
    }

    /// The object for a script.
    pub(super) fn json(&self) -> serde_json::Value {
        let Self { request, plan, rival, .. } = self;
        let (duration_s, [speed, acceleration]) = (plan.course.duration_s(), self.largest());
        let jerk = plan.course.jerks_m_s3.iter().fold(0.0, |most: f64, jerk| most.max(jerk.abs()));
        let (limits, sure) = (request.limits, 1.0 + 1e-6);
        let checks = [
            Check::informational("travel_time", duration_s, "s"),
            Check::informational("crest", 1e3 * plan.crest_m, "mm"),
            Check::informational("crest_half_width", 1e3 * plan.half_width_m, "mm"),
            Check::at_most("crest_bound", 1e3 * plan.bound_m, "mm", 1.0025e3 * request.limit_m),
            Check::at_most("speed", speed, "m/s", sure * limits.speed_m_s),
            Check::at_most("acceleration", acceleration, "m/s2", sure * limits.acceleration_m_s2),
            Check::at_most("jerk", jerk, "m/s3", sure * limits.jerk_m_s3),
            Check::informational("minimum_jerk_crest", 1e3 * rival.crest_m, "mm"),
            Check::informational("minimum_jerk_time_at_equal_crest", rival.equal_crest_s, "s"),
            Check::informational("solve_ms", self.solve_ms, "ms"),
        ];
        serde_json::json!({ "checks": checks })
    }
}
