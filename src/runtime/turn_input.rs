//! Input of a turn: one profile or none, and the motion of the glass.

use crate::surface::SurfaceProfile;
use crate::units::Micros;

/// Source of the motion of the glass.
///
/// ```
/// use meniscus::runtime::InputSource;
/// use meniscus::units::Micros;
///
/// // The callback for a set-up without an IMU: the camera tracks the glass at every instant.
/// assert_eq!(InputSource::tracked(Micros(0)), InputSource::Tracked);
/// assert_eq!(InputSource::default(), InputSource::Tracked);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum InputSource {
    /// Edges of the glass in the profile; while these are not seen, as [`Self::Unobserved`].
    #[default]
    Tracked,
    /// IMU or command of a robot: acceleration along x, m/s2.
    Measured {
        /// Acceleration one frame interval before the frame, as the positions of the glass in the last three frames would
        /// give it: it enters the port.
        before: f64,
        /// Acceleration at the instant of the frame: the inertial pressure follows it at once.
        now: f64,
    },
    /// None: the input is estimated with the latents, from the heights alone.
    Unobserved,
}

impl InputSource {
    /// Source of a turn at any time whose motion comes from the edges of the glass.
    #[must_use]
    pub fn tracked(_time: Micros) -> Self {
        Self::Tracked
    }

    /// Scales a measured motion by `gain`. A tracked motion is unchanged: it is what the camera saw.
    pub(super) fn scaled(self, gain: f64) -> Self {
        match self {
            Self::Measured { before, now } => Self::Measured { before: gain * before, now: gain * now },
            other => other,
        }
    }
}

/// Input of one turn. The default is a turn without a frame.
///
/// ```
/// use meniscus::runtime::{InputSource, TurnInput};
///
/// let lost = TurnInput { source: InputSource::Unobserved, ..TurnInput::default() };
/// assert!(lost.profile.is_none());
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct TurnInput<'p> {
    /// Profile of the frame; `None` where no frame came or no liquid was seen.
    pub profile: Option<&'p SurfaceProfile>,
    /// Source of the motion of the glass.
    pub source: InputSource,
    /// Time of this turn that the way from the image to the profile has taken, microseconds.
    pub surface_us: u64,
}

impl<'p> TurnInput<'p> {
    /// Returns the input of a turn with a frame in which the glass is tracked.
    #[must_use]
    pub fn tracked(profile: &'p SurfaceProfile) -> Self {
        Self { profile: Some(profile), ..Self::default() }
    }
}
