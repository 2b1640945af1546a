//! Optics that a camera reports: intrinsics, depth unit, the lenses of its images.

use crate::usb::lens::Intrinsics;

/// The camera's part of the [`Settings`](super::Settings); those of its default are a D435's with the outline in infrared.
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
        let intrinsics =
            Intrinsics { width: 640, height: 480, fx: 384.21, fy: 384.21, ppx: 319.48, ppy: 236.35 };
        Self { intrinsics, depth_unit_m: 1e-4, depth_lens_m: [0.0; 3] }
    }
}
