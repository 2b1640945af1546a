//! Why a motion was not planned.

use std::fmt;

/// Why a motion was not planned.
#[derive(Clone, Debug, PartialEq)]
pub enum PlanError {
    /// A number of the request is out of its range.
    Range {
        /// The option or field.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Unit of the value.
        unit: &'static str,
        /// The range, in words.
        allowed: String,
    },
    /// The half-width of a surface at rest alone is not below the limit.
    Uncertain {
        /// Limit, m.
        limit_m: f64,
        /// Half-width at the stated confidence, m.
        half_width_m: f64,
        /// Confidence.
        confidence: f64,
    },
    /// The rim is not above the limit.
    Rim {
        /// Limit, m.
        limit_m: f64,
        /// Height of the rim over the fill, m.
        room_m: f64,
    },
    /// No motion of the longest duration keeps the limits.
    Infeasible {
        /// Longest duration that was tried, s.
        longest_s: f64,
        /// Lowest crest with its half-width at that duration, m; not a number where speed, acceleration and jerk alone forbid it.
        crest_m: f64,
        /// Limit, m.
        limit_m: f64,
    },
    /// The solver ended without a solution.
    Solver(String),
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range { name, value, unit, allowed } => {
                write!(f, "{name} = {value} {unit} is out of range: {allowed}")
            }
            Self::Uncertain { limit_m, half_width_m, confidence } => write!(
                f,
                "a limit of {:.2} mm cannot be promised with a confidence of {confidence}: the forecast of a liquid at rest is \
                 uncertain by {:.2} mm; give a higher limit or a lower confidence",
                1e3 * limit_m,
                1e3 * half_width_m
            ),
            Self::Rim { limit_m, room_m } => write!(
                f,
                "a limit of {:.1} mm is not below the rim, which is {:.1} mm above the liquid at rest: give a lower limit, or \
                 the glass with --setup",
                1e3 * limit_m,
                1e3 * room_m
            ),
            Self::Infeasible { longest_s, crest_m, limit_m } if crest_m.is_finite() => write!(
                f,
                "no motion of up to {longest_s:.1} s keeps the crest below {:.2} mm: the lowest found is {:.2} mm with its \
                 half-width; wait until the liquid is calm, or give a higher limit or a lower confidence",
                1e3 * limit_m,
                1e3 * crest_m
            ),
            Self::Infeasible { longest_s, .. } => write!(
                f,
                "the distance takes longer than {longest_s:.1} s at this speed, acceleration and jerk: raise them, or divide \
                 the distance"
            ),
            Self::Solver(why) => write!(f, "the program of the motion was not solved: {why}"),
        }
    }
}

impl std::error::Error for PlanError {}
