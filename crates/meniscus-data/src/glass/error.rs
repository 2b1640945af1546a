//! Reasons why points are no profile of a glass.

use std::fmt::{self, Display, Formatter};

/// Largest number of points.
pub const MOST_POINTS: usize = 32;

/// Reason why points are no profile.
#[derive(Clone, Debug, PartialEq)]
pub enum WallError {
    /// Too few or too many points.
    Count(usize),
    /// The first point is not at the height 0.
    Start(f64),
    /// A point is no higher than the one before, or no finite number.
    Height(usize, [f64; 2]),
    /// A radius is out of range.
    Radius(usize, [f64; 2]),
    /// The line between two points swings to the axis.
    Pinched(f64),
}

impl Display for WallError {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count(count) => write!(f, "a profile of {count} points: it needs 3 to {MOST_POINTS}"),
            Self::Start(z) => {
                write!(f, "the profile starts at the height {z} m: its first point must be at 0, the bottom")
            }
            Self::Height(i, [z, r]) => {
                write!(f, "point {} of the profile, [{z}, {r}], is not higher than the one before", i + 1)
            }
            Self::Radius(i, [z, r]) => write!(
                f,
                "point {} of the profile, [{z}, {r}], has a radius out of range: above 0 to 0.2 m (0 only at the bottom)",
                i + 1
            ),
            Self::Pinched(z) => write!(
                f,
                "the line through the points of the profile reaches the axis at the height {z:.4} m: give more points there"
            ),
        }
    }
}

impl std::error::Error for WallError {}
