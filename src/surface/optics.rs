//! What a camera tells of itself: intrinsics, depth unit, the lenses of its images.

use super::config::Settings;

/// Pinhole intrinsics of an image in pixels; pixel `u` is centred on the number `u`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intrinsics {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Focal length, horizontal.
    pub fx: f32,
    /// Focal length, vertical.
    pub fy: f32,
    /// Principal point, horizontal.
    pub ppx: f32,
    /// Principal point, vertical.
    pub ppy: f32,
}

/// The camera's part of the [`Settings`]; those of its default are a D435's with the outline in infrared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Optics {
    /// Of the depth image, and of the outline's: the infrared one is taken by the same lens, the colour one is
    /// [rectified](super::Rectifier) to it.
    pub intrinsics: Intrinsics,
    /// Metres in one unit of the depth image.
    pub depth_unit_m: f32,
    /// Where the lens of the depth image stands, as seen from that of the outline image: right, down, forward, metres.
    pub depth_lens_m: [f32; 3],
}

impl Default for Optics {
    fn default() -> Self {
        Settings::default().optics()
    }
}
