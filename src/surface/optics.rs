//! Optics that a camera reports: intrinsics, depth unit, the lenses of its images.

use super::config::Settings;
use crate::usb::lens::Intrinsics;

/// The camera's part of the [`Settings`]; those of its default are a D435's with the outline in infrared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Optics {
    /// Of the depth image, and of the outline's: the infrared one is taken by the same lens, the colour one is
    /// [rectified](super::Rectifier) to it.
    pub intrinsics: Intrinsics,
    /// Metres in one unit of the depth image.
    pub depth_unit_m: f32,
    /// Position of the depth lens relative to that of the outline image: right, down, forward, metres.
    pub depth_lens_m: [f32; 3],
}

impl Default for Optics {
    fn default() -> Self {
        Settings::default().optics()
    }
}
