//! Jerks that a program prefers: small ones in a first plan, those of the motion under way in a renewed one.
//!
//! A renewed plan without a preference answered to the error of the estimate with large jerks. In water they excited short waves, and the
//! crest became twice the limit.

use crate::course::Course;

/// Weight e of the jerks of a first plan: it makes the solution unique and costs less than 0.1 % of the crest.
const SMOOTHNESS: f64 = 1e-3;

/// Weight e of a renewed plan, about the jerks r of the motion under way. A change that gains little answers to the error of the
/// estimate, and excites short waves that no model has.
const RENEWED: f64 = 0.2;

/// Jerks that a program prefers.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Preferred<'a> {
    /// None.
    Small,
    /// Those of a motion under way, stretched to the duration.
    Near(&'a Course),
}

impl Preferred<'_> {
    /// e.
    pub(crate) fn weight(self) -> f64 {
        match self {
            Self::Small => SMOOTHNESS,
            Self::Near(_) => RENEWED,
        }
    }

    /// Crest in units of the limit below which a lower one is worth nothing.
    pub(crate) fn enough(self) -> Option<f64> {
        matches!(self, Self::Near(_)).then_some(1.0)
    }

    /// r_i, over a jerk of `largest` m/s3, of `knots` parts.
    pub(crate) fn jerk(self, part: usize, knots: usize, largest: f64) -> f64 {
        let Self::Near(course) = self else { return 0.0 };
        let knot_s = course.duration_s() / knots as f64;
        let acceleration = |k: usize| course.at(k as f64 * knot_s).acceleration_m_s2;
        (acceleration(part + 1) - acceleration(part)) / (knot_s * largest)
    }
}
