//! The table of a planned motion, as `meniscus simulate --motion` and `meniscus run --motion` read it.

use meniscus_plan::{Course, Request};
use meniscus_platform::files::write_whole;
use std::fmt::Write;
use std::path::Path;

/// Rows in a second.
const RATE_HZ: f64 = 120.0;

/// The lines above the table.
pub(super) fn head(from_m: f64, request: &Request, name: &str) -> String {
    format!(
        "# meniscus plan: {from_m} m to {} m, crest below {} mm at {} %, {name}\n",
        request.to_m,
        1e3 * request.limit_m,
        100.0 * request.confidence
    )
}

/// Writes `course` behind `head`; the last row is the arrival.
pub(super) fn write(path: &Path, course: &Course, head: &str) -> anyhow::Result<()> {
    let mut text = String::from(head);
    text.push_str("t,x_m\n");
    let duration_s = course.duration_s();
    let rows = (duration_s * RATE_HZ).ceil() as usize;
    for row in 0..=rows {
        let time_s = duration_s * row as f64 / rows as f64;
        // A `String` takes every line.
        let _written = writeln!(text, "{time_s:.6},{:.7}", course.at(time_s).position_m);
    }
    Ok(write_whole(path, text.as_bytes())?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_data::motion::Motion;
    use meniscus_plan::GlassState;

    /// The reader of motions finds the position and the acceleration of the course.
    #[test]
    fn the_table_is_a_motion() {
        let path = std::env::temp_dir().join(format!("meniscus-plan-{}.csv", std::process::id()));
        let jerks_m_s3 = vec![50.0, -50.0, -50.0, 50.0];
        let course = Course { start: GlassState::resting(0.2), knot_s: 0.1, jerks_m_s3 };
        write(&path, &course, "# a course\n").expect("written");
        let motion = Motion::parse(path.to_str().expect("UTF-8"), 1.0).expect("a motion");
        std::fs::remove_file(&path).expect("removed");
        for time_s in [0.03, 0.15, 0.27, 0.39, 0.6] {
            let due = course.at(time_s);
            assert!((motion.position(time_s) - (due.position_m - 0.2)).abs() < 1e-5, "{time_s}");
            assert!((motion.acceleration(time_s) - due.acceleration_m_s2).abs() < 0.2, "{time_s}");
        }
    }
}
