//! Checked settings, and what follows from them once for all frames.

use super::deproject::Camera;
use super::settings::Settings;
use crate::usb::frame::Stamp;

/// Widest region of interest in pixels: the bound of every fixed array of columns.
pub const MAX_COLUMNS: usize = 256;

/// Thickest wall of a glass, metres.
pub const THICKEST_WALL_M: f32 = 0.006;

/// Fault of the settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConfigError {
    /// The named setting must be a finite number above zero.
    NotPositive(&'static str, f32),
    /// The pitch must be within 0.35 rad (20 degrees) of level.
    PitchTooSteep(f32),
    /// The fill height must lie below the rim.
    FillAboveRim(f32, f32),
    /// The camera must stand outside of the glass.
    CameraInGlass(f32, f32),
    /// A region of twice the named half width must fit into [`MAX_COLUMNS`] and hold the glass.
    RegionWidth(&'static str, usize),
    /// The wall must be 0 to [`THICKEST_WALL_M`] thick.
    WallThickness(f32),
    /// The image must have pixels.
    NoPixels(usize, usize),
    /// The lenses of the two images must be within 100 mm of each other.
    LensesApart([f32; 3]),
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NotPositive(name, value) => {
                write!(f, "{name} is {value}; it must be finite and above zero")
            }
            Self::PitchTooSteep(pitch) => {
                write!(f, "the camera pitch is {pitch} rad; it must be within 0.35")
            }
            Self::FillAboveRim(fill, rim) => {
                write!(f, "the fill height {fill} m is not below the rim {rim} m")
            }
            Self::CameraInGlass(distance, radius) => {
                write!(f, "the camera distance {distance} m is not above twice the radius {radius} m")
            }
            Self::RegionWidth(name, width) => {
                write!(f, "{name} is {width} px; it must hold the glass and be at most {}", MAX_COLUMNS / 2)
            }
            Self::WallThickness(wall) => {
                write!(f, "the wall is {wall} m thick; it must be 0 to {THICKEST_WALL_M}")
            }
            Self::NoPixels(width, height) => write!(f, "an image of {width} x {height} has no pixels"),
            Self::LensesApart([x, y, z]) => {
                write!(f, "the depth lens is {x}, {y}, {z} m from that of the outline; 0.1 is the most")
            }
        }
    }
}

impl core::error::Error for ConfigError {}

/// Checked settings with what follows from them.
///
/// ```
/// use meniscus::surface::{Config, Settings};
///
/// let config = Config::new(Settings::default())?;
/// // The middle of the surface on the wall that faces the camera lies above the middle of the image.
/// let point = config.wall_point(0.0, config.settings().fill_m);
/// let (column, row) = config.pixel_of(point);
/// assert!((column - 319.48).abs() < 1e-3 && row < 236.35);
/// # Ok::<(), meniscus::surface::ConfigError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Config {
    pub(super) settings: Settings,
    /// The lens of the outline image.
    pub(super) camera: Camera,
    /// The lens of the depth image, for which the axis of the glass lies [`Settings::depth_lens_m`] to the left.
    pub(super) depth_camera: Camera,
    /// First row that can show the glass, and the row behind the last one that shows liquid.
    pub(super) rows: (usize, usize),
    /// Rows in which the glass holds liquid whatever the slosh: 6 % to 26 % of the fill height.
    pub(super) foot_rows: (usize, usize),
    /// Width of the liquid's silhouette at the middle of the range, pixels.
    pub(super) silhouette_px: f32,
}

impl Config {
    /// Checks the settings.
    ///
    /// # Errors
    /// [`ConfigError`] names the first setting that cannot be used.
    pub fn new(settings: Settings) -> Result<Self, ConfigError> {
        let s = &settings;
        let lens = &s.intrinsics;
        let positive = [
            ("fx", lens.fx),
            ("fy", lens.fy),
            ("camera_height_m", s.camera_height_m),
            ("camera_distance_m", s.camera_distance_m),
            ("distance_std_m", s.distance_std_m),
            ("radius_m", s.radius_m),
            ("fill_m", s.fill_m),
            ("rim_m", s.rim_m),
            ("depth_unit_m", s.depth_unit_m),
            ("least_contrast", s.least_contrast),
        ];
        if let Some((name, value)) = positive.into_iter().find(|(_, v)| !(v.is_finite() && *v > 0.0)) {
            return Err(ConfigError::NotPositive(name, value));
        }
        if !s.camera_pitch_rad.is_finite() || s.camera_pitch_rad.abs() >= 0.35 {
            return Err(ConfigError::PitchTooSteep(s.camera_pitch_rad));
        }
        if s.fill_m >= s.rim_m {
            return Err(ConfigError::FillAboveRim(s.fill_m, s.rim_m));
        }
        if s.camera_distance_m <= 2.0 * s.radius_m {
            return Err(ConfigError::CameraInGlass(s.camera_distance_m, s.radius_m));
        }
        if let Some(wall) = s.wall_m.filter(|wall| !(0.0..=THICKEST_WALL_M).contains(wall)) {
            return Err(ConfigError::WallThickness(wall));
        }
        if lens.width == 0 || lens.height == 0 {
            return Err(ConfigError::NoPixels(lens.width, lens.height));
        }
        // A comparison with a number that is none is false.
        if !s.depth_lens_m.iter().all(|apart| apart.abs() <= 0.1) {
            return Err(ConfigError::LensesApart(s.depth_lens_m));
        }
        let camera = Camera::new(s);
        let depth_camera = camera.moved(s.depth_lens_m);
        let silhouette_px = 2.0 * lens.fx * camera.silhouette_slope();
        for (name, half) in [
            ("region_half_width_px", s.region_half_width_px),
            ("search_half_width_px", s.search_half_width_px),
        ] {
            if half > MAX_COLUMNS / 2 || (half as f32) < 0.5 * silhouette_px {
                return Err(ConfigError::RegionWidth(name, half));
            }
        }
        let front_m = s.camera_distance_m - s.radius_m;
        let row = |height_m: f32, distance_m: f32| {
            (camera.row_of(height_m, distance_m).max(0.0) as usize).min(lens.height)
        };
        // The rim is highest in the image at the near wall, or at the far wall if the camera looks down on it.
        let top = row(s.rim_m, front_m).min(row(s.rim_m, s.camera_distance_m + s.radius_m));
        let foot_rows = (row(0.26 * s.fill_m, front_m), row(0.06 * s.fill_m, front_m));
        Ok(Self { settings, camera, depth_camera, rows: (top, foot_rows.1), foot_rows, silhouette_px })
    }

    /// Number and time of a pair of images: those of the depth image, but where another lens has taken the outline,
    /// its time. The edge is where it was then; the depth image only tells how far the wall is.
    #[must_use]
    pub fn stamp_of(&self, depth: Stamp, outline: Stamp) -> Stamp {
        let one_lens = self.settings.depth_lens_m == [0.0; 3];
        if one_lens { depth } else { Stamp { captured: outline.captured, ..depth } }
    }

    /// The settings that were checked.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Column and row at which a point of the room is seen; `x` right of the range's middle, `y` away
    /// from the camera, `z` above the inner bottom of the glass, metres.
    #[must_use]
    pub fn pixel_of(&self, [x, y, z]: [f32; 3]) -> (f32, f32) {
        self.camera.pixel_of(x, y + self.settings.camera_distance_m, z)
    }

    /// Returns the position of a profile point on the wall that faces the camera of a glass at the middle of the
    /// range; `abscissa` in units of the inner radius, as [`super::profile_abscissa`] gives it.
    #[must_use]
    pub fn wall_point(&self, abscissa: f32, height_m: f32) -> [f32; 3] {
        let across = crate::math::sqrtf((1.0 - abscissa * abscissa).max(0.0));
        [abscissa * self.settings.radius_m, -across * self.settings.radius_m, height_m]
    }

    /// Width and height of the images, pixels.
    #[must_use]
    pub fn image_size(&self) -> (usize, usize) {
        let lens = &self.settings.intrinsics;
        (lens.width, lens.height)
    }
}
