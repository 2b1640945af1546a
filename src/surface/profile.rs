//! The surface profile: what the camera knows of the liquid at one instant.

use crate::units::Micros;

/// Points of a profile, equally spaced over the visible width of the liquid.
pub const POINTS: usize = 21;

/// The profile covers `x` in [-0.9 R, 0.9 R]; nearer to the silhouette of the glass the wall turns
/// away from the camera and a pixel covers more than a millimetre of it.
pub const PROFILE_HALF_SPAN: f64 = 0.9;

/// `x` of profile point `index` in units of the inner radius R, in the frame of the glass.
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

impl SurfaceProfile {
    /// Number of points that were seen.
    #[must_use]
    pub fn seen(&self) -> usize {
        self.valid.iter().filter(|&&v| v).count()
    }
}
