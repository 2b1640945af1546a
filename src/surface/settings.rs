//! Settings of the camera side: camera, its position, glass and tone of the liquid.

use super::optics::Optics;
use crate::usb::lens::Intrinsics;

/// Least difference between a clear liquid and the card behind it, grey levels.
const CLEAR_CONTRAST: f32 = 14.0;

/// Tone of the liquid relative to its background.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Liquid {
    /// Darker than the background.
    Dark,
    /// Brighter than the background.
    Bright,
    /// Clear, and darker than a bright card behind it: water in light of 850 nm. The depth image is not asked
    /// ([`Settings::of_clear_liquid`]).
    Clear,
}

/// The settings, unchecked; [`Settings::default`] is a D435 in front of the 35 mm glass.
///
/// ```
/// use meniscus::surface::{Config, ConfigError, Settings};
///
/// // Inner radius 35 mm, filled to 70 mm, rim at 110 mm.
/// let settings = Settings::for_glass(0.035, 0.070, 0.110);
/// assert!(Config::new(settings).is_ok());
///
/// let overfull = Settings { fill_m: 0.12, ..settings };
/// assert_eq!(Config::new(overfull).err(), Some(ConfigError::FillAboveRim(0.12, 0.11)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Intrinsics of both images.
    pub intrinsics: Intrinsics,
    /// Position of the depth lens relative to the lens of the outline image: right, down, forward
    /// along its axes, metres; zero where the outline is the left infrared image's, which is taken by the same lens.
    pub depth_lens_m: [f32; 3],
    /// Height of the camera above the inner bottom of the glass, metres.
    pub camera_height_m: f32,
    /// Horizontal distance of the camera from the line on which the glass axis moves, metres.
    pub camera_distance_m: f32,
    /// Standard deviation of that distance, metres. It counts where no depth image measures the wall.
    pub distance_std_m: f32,
    /// Pitch of the camera, radians, positive when it looks up.
    pub camera_pitch_rad: f32,
    /// Inner radius of the glass, metres.
    pub radius_m: f32,
    /// Thickness of the glass wall, metres; `None`: measured from the silhouette, frame by frame.
    pub wall_m: Option<f32>,
    /// Height of the liquid at rest, metres.
    pub fill_m: f32,
    /// Height of the rim, metres.
    pub rim_m: f32,
    /// Metres in one unit of the depth image.
    pub depth_unit_m: f32,
    /// Columns looked at on either side of the expected glass axis; also how far the glass may move
    /// between two frames: (this - half the width of the glass) pixels.
    pub region_half_width_px: usize,
    /// Columns looked at on either side of the image centre while the glass is not tracked.
    pub search_half_width_px: usize,
    /// Tone of the liquid.
    pub liquid: Liquid,
    /// Least difference between liquid and background, grey levels.
    pub least_contrast: f32,
}

impl Settings {
    /// A D435 in front of a glass of inner radius `radius_m`, filled to `fill_m`, with its rim at `rim_m`, metres.
    #[must_use]
    pub fn for_glass(radius_m: f64, fill_m: f64, rim_m: f64) -> Self {
        Self { radius_m: radius_m as f32, fill_m: fill_m as f32, rim_m: rim_m as f32, ..Self::default() }
    }

    /// The same before a camera of other optics.
    #[must_use]
    pub fn with_optics(self, optics: Optics) -> Self {
        let Optics { intrinsics, depth_unit_m, depth_lens_m } = optics;
        Self { intrinsics, depth_unit_m, depth_lens_m, ..self }
    }

    /// The same for a clear liquid, whose contrast is less than half of an opaque one's.
    ///
    /// ```
    /// use meniscus::surface::{Liquid, Settings};
    ///
    /// let settings = Settings::default().of_clear_liquid();
    /// assert_eq!(settings.liquid, Liquid::Clear);
    /// assert!(settings.least_contrast < Settings::default().least_contrast);
    /// ```
    #[must_use]
    pub fn of_clear_liquid(self) -> Self {
        Self { liquid: Liquid::Clear, least_contrast: CLEAR_CONTRAST, ..self }
    }

    /// Returns the part that the camera reports.
    #[must_use]
    pub fn optics(&self) -> Optics {
        let Self { intrinsics, depth_unit_m, depth_lens_m, .. } = *self;
        Optics { intrinsics, depth_unit_m, depth_lens_m }
    }
}

impl Default for Settings {
    fn default() -> Self {
        let Optics { intrinsics, depth_unit_m, depth_lens_m } = Optics::default();
        Self {
            intrinsics,
            depth_lens_m,
            camera_height_m: 0.030,
            camera_distance_m: 0.40,
            distance_std_m: 0.003,
            camera_pitch_rad: 0.0,
            radius_m: 0.035,
            wall_m: None,
            fill_m: 0.070,
            rim_m: 0.110,
            depth_unit_m,
            region_half_width_px: 64,
            search_half_width_px: 128,
            liquid: Liquid::Dark,
            least_contrast: 25.0,
        }
    }
}
