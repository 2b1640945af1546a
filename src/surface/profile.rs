//! Surface profile: heights of the liquid at one instant, as the camera measures them.

use crate::math::sqrtf;
use crate::units::Micros;

/// Points of a profile, equally spaced over the visible width of the liquid.
pub const POINTS: usize = 21;

/// The profile covers `x` in [-0.9 R, 0.9 R]; nearer to the silhouette of the glass the wall turns
/// away from the camera and a pixel covers more than a millimetre of it.
pub const PROFILE_HALF_SPAN: f64 = 0.9;

/// `x` of profile point `index` in units of the inner radius R, in the frame of the glass.
///
/// ```
/// use meniscus::surface::{POINTS, profile_abscissa};
///
/// assert_eq!(profile_abscissa(0), -0.9);
/// assert!(profile_abscissa(POINTS / 2).abs() < 1e-12);
/// ```
#[must_use]
pub fn profile_abscissa(index: usize) -> f64 {
    PROFILE_HALF_SPAN * (2.0 * index as f64 / (POINTS - 1) as f64 - 1.0)
}

/// Heights of the liquid's edge (the contact line on the wall that faces the camera), in the frame
/// of the glass: `x` to the right in the image, `z` up from the inner bottom of the glass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceProfile {
    /// Height above the inner bottom of the glass, in metres. Meaningless where not valid.
    pub height_m: [f32; POINTS],
    /// Variance of the height, square metres: noise of the edge and of the depth, and what is left of the
    /// known biases. [`Self::interval_m`] is the interval stated from it. Meaningless where not valid.
    pub variance_m2: [f32; POINTS],
    /// Whether the point was seen; a point that was not seen is never invented.
    pub valid: [bool; POINTS],
    /// Position of the glass axis along the camera's horizontal, in metres, from the tracked glass
    /// edges, relative to the configured origin; `None` where the glass edges were not found.
    pub glass_x_m: Option<f32>,
    /// The camera's frame counter.
    pub sequence: u32,
    /// Mid-exposure device time.
    pub captured: Micros,
}

/// Standard deviations from the height to the end of the stated interval, which holds 95 % of the points.
const INTERVAL: f32 = 2.0;

impl SurfaceProfile {
    /// Half width of the interval in which point `index` is stated to lie, metres; `None` where the point
    /// was not seen. Calibrated on rendered scenes (`meniscus camera study`), not on a physical camera.
    #[must_use]
    pub fn interval_m(&self, index: usize) -> Option<f32> {
        let seen = self.valid.get(index).is_some_and(|valid| *valid);
        self.variance_m2.get(index).filter(|_| seen).map(|variance| INTERVAL * sqrtf(*variance))
    }

    /// Returns the number of valid points.
    #[must_use]
    pub fn valid_points(&self) -> usize {
        self.valid.iter().filter(|&&v| v).count()
    }
}
