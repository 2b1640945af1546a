//! Motions of the study: single jolts, pairs of jolts, slow jolts, and those that the workflow may suggest.
//!
//! Four recordings belong to a glass: three are fitted and one is held out. Suggested ones are added one by one.

use crate::findings::suggest::suggestable;
use crate::recordings::motion_plan::{Jolt, MotionPlan, REST_S};

/// Sets of motions that a glass of liquid makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum MotionKind {
    /// One jolt at the first mode's period.
    Single,
    /// A short jolt and a longer one in the opposite direction.
    Double,
    /// One jolt half as long again.
    Slow,
    /// The motions that a discovery may suggest; the name stands in digests and files.
    Asked,
}

/// Returns the motions of a kind. The last is held out, except among those that may be suggested.
#[must_use]
pub fn motions(kind: MotionKind) -> Vec<MotionPlan> {
    const SECONDS: f64 = 2.2;
    let double = |strength: f64| MotionPlan {
        jolts: vec![
            Jolt { start_s: REST_S, period_s: 0.20, strength_m_s2: strength },
            Jolt { start_s: 0.9, period_s: 0.30, strength_m_s2: -0.8 * strength },
        ],
        seconds: SECONDS,
    };
    match kind {
        MotionKind::Single => [0.6, 1.25, 2.2, 1.7].map(|a| MotionPlan::jolt(0.28, a, SECONDS)).to_vec(),
        MotionKind::Double => [0.7, 1.3, 2.0, 1.6].map(double).to_vec(),
        MotionKind::Slow => [0.7, 1.2, 1.9, 1.5].map(|a| MotionPlan::jolt(0.40, a, SECONDS)).to_vec(),
        MotionKind::Asked => suggestable(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_starts_and_ends_at_rest_and_has_the_acceleration_of_its_jolts() {
        for kind in [MotionKind::Single, MotionKind::Double, MotionKind::Slow, MotionKind::Asked] {
            for plan in motions(kind) {
                let h = 1e-4;
                let second =
                    |t: f64| (plan.position(t + h) - 2.0 * plan.position(t) + plan.position(t - h)) / (h * h);
                assert!(second(0.3).abs() < 1e-6 && second(plan.seconds - 0.1).abs() < 1e-6);
                let jolt = plan.jolts[0];
                let quarter = second(jolt.start_s + 0.25 * jolt.period_s);
                assert!((quarter / jolt.strength_m_s2 - 1.0).abs() < 1e-3, "{quarter}");
                assert!(plan.position(1e3).abs() < 0.065, "{plan:?} goes too far");
            }
        }
    }
}
