//! Lens of a webcam as somebody measured it, and the lens that the reader looks through.
//!
//! A webcam tells nothing of its lens. A ruler does: level before the camera at the distance `L`, the whole width of the
//! image shows `W` of it. Then
//!
//! ```text
//! f = w L / W  pixels,   w: width of the image, pixels        field of view = 2 atan(W / (2 L))
//! ```
//!
//! The optical axis is taken to meet the middle of the image, pixels to be square, and the lens to be free of distortion.

use meniscus::surface::{ColourLens, Intrinsics, Optics, Rectifier};
use serde::{Deserialize, Serialize};

/// Focal lengths that are accepted, as shares of the image's width: fields of view of 104 to 11 degrees.
const FOCAL: (f64, f64) = (0.39, 5.2);
/// The rectifier takes the mean of places up to half a pixel apart, so it makes images smaller by less than this.
const SMALLER: f32 = 1.99;

/// A stated lens.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StatedLens {
    /// Width and height of the camera's image, pixels.
    pub size: [u16; 2],
    /// Focal length in pixels of that image.
    pub focal_px: f64,
}

/// Why a stated lens cannot be one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LensError {
    /// The focal length for this width is out of range.
    Focal {
        /// Stated focal length, pixels.
        focal_px: f64,
        /// Width of the image, pixels.
        width: u16,
    },
    /// The field of view in degrees is out of range.
    FieldOfView(f64),
}

impl std::fmt::Display for LensError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Focal { focal_px, width } => {
                let [least, most] = [FOCAL.0, FOCAL.1].map(|share| share * f64::from(*width));
                write!(
                    f,
                    "a focal length of {focal_px} px is out of range for images {width} px wide: {least:.0} to {most:.0}"
                )
            }
            Self::FieldOfView(degrees) => {
                write!(f, "a field of view of {degrees} degrees is out of range: 11 to 104")
            }
        }
    }
}

impl std::error::Error for LensError {}

impl StatedLens {
    /// Returns the action of a person who does not know the lens.
    pub const HOW_TO_MEASURE: &str = "hold a ruler level before the camera at a distance of L mm and read how many mm, W, the \
        whole width of the image shows; the focal length is (width of the image in px) * L / W, and the field of view \
        2 atan(W / 2L)";

    /// A lens of this focal length.
    ///
    /// # Errors
    /// [`LensError::Focal`].
    pub fn of_focal(size: [u16; 2], focal_px: f64) -> Result<Self, LensError> {
        let share = focal_px / f64::from(size[0]);
        // A comparison with a number that is none is false.
        if !(FOCAL.0..=FOCAL.1).contains(&share) {
            return Err(LensError::Focal { focal_px, width: size[0] });
        }
        Ok(Self { size, focal_px })
    }

    /// A lens with this horizontal field of view: `f = w / (2 tan(angle / 2))`.
    ///
    /// # Errors
    /// [`LensError::FieldOfView`].
    pub fn of_field_of_view(size: [u16; 2], degrees: f64) -> Result<Self, LensError> {
        let focal_px = 0.5 * f64::from(size[0]) / (0.5 * degrees).to_radians().tan();
        Self::of_focal(size, focal_px).map_err(|_| LensError::FieldOfView(degrees))
    }

    /// Returns the lens of the camera's own image.
    #[must_use]
    pub fn own(&self) -> Intrinsics {
        let [width, height] = self.size.map(usize::from);
        let f = self.focal_px as f32;
        Intrinsics { width, height, fx: f, fy: f, ppx: middle(width), ppy: middle(height) }
    }

    /// Returns the optics of the image that the reader sees: as a D435 has it, whose size of a pixel the reader was
    /// made for, or with the camera's own focal length where that is shorter.
    ///
    /// ```
    /// use meniscus_service::setup::StatedLens;
    ///
    /// let lens = StatedLens::of_field_of_view([640, 480], 60.0)?;
    /// assert!((lens.focal_px - 554.3).abs() < 0.1);
    /// let optics = lens.optics();
    /// assert_eq!((optics.intrinsics.width, optics.intrinsics.fx), (640, 384.21));
    /// # Ok::<(), meniscus_service::setup::LensError>(())
    /// ```
    #[must_use]
    pub fn optics(&self) -> Optics {
        let (own, usual) = (self.own(), Optics::default());
        let f = own.fx.min(usual.intrinsics.fx).max(own.fx / SMALLER);
        let (width, height) = (usual.intrinsics.width, usual.intrinsics.height);
        let intrinsics = Intrinsics { width, height, fx: f, fy: f, ppx: middle(width), ppy: middle(height) };
        Optics { intrinsics, ..usual }
    }

    /// Returns the rectifier from the camera's images to those of [`optics`](Self::optics).
    #[must_use]
    pub fn rectifier(&self) -> Rectifier {
        let rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let lens = ColourLens { intrinsics: self.own(), distortion: [0.0; 5], rotation };
        Rectifier::new(lens, self.optics().intrinsics)
    }

    /// Whether it is a lens at all, for one that was read from a file.
    ///
    /// # Errors
    /// [`LensError::Focal`].
    pub fn check(&self) -> Result<(), LensError> {
        Self::of_focal(self.size, self.focal_px).map(drop)
    }
}

/// Number of the middle of an axis of pixels.
fn middle(pixels: usize) -> f32 {
    0.5 * (pixels as f32 - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lens_that_cannot_be_is_refused() {
        let refused = StatedLens::of_focal([640, 480], 60.0).expect_err("a field of view of 159 degrees");
        assert!(refused.to_string().contains("images 640 px wide: 250 to 3328"), "{refused}");
        for degrees in [f64::NAN, 0.0, -60.0, 5.0, 120.0, 180.0] {
            assert!(StatedLens::of_field_of_view([640, 480], degrees).is_err(), "{degrees}");
        }
        assert!(StatedLens { size: [0, 480], focal_px: 500.0 }.check().is_err());
    }

    /// A ruler's end in the camera's image is where the reader's lens looks for it.
    #[test]
    fn a_point_of_the_room_is_at_its_place_in_the_readers_image() {
        for (size, focal_px) in [([640, 480], 610.0), ([1280, 720], 930.0), ([640, 480], 300.0)] {
            let lens = StatedLens::of_focal(size, focal_px).expect("a lens");
            let (own, to) = (lens.own(), lens.optics().intrinsics);
            // A vertical edge 30 mm to the right in a distance of 400 mm.
            let edge = own.ppx + own.fx * 0.030 / 0.4;
            let level = |u: usize| (255.0 * (u as f32 + 0.5 - edge).clamp(0.0, 1.0)) as u8;
            let row: Vec<u8> = (0..own.width).flat_map(|u| [level(u), 128]).collect();
            let yuy2: Vec<u8> = row.iter().copied().cycle().take(row.len() * own.height).collect();
            let mut grey = vec![0; lens.rectifier().grey_bytes()];
            let whole = meniscus::surface::Region::whole((to.width, to.height));
            lens.rectifier().rectify(&yuy2, &mut grey, whole);
            let middle_row = &grey[240 * to.width..241 * to.width];
            let expected = to.ppx + to.fx * 0.030 / 0.4;
            // Dark pixels from the middle to the edge, the last one in part.
            let from = to.ppx as usize + 1;
            let dark: f32 = middle_row[from..from + 40].iter().map(|g| 1.0 - f32::from(*g) / 255.0).sum();
            let found = from as f32 - 0.5 + dark;
            assert!((found - expected).abs() < 0.06, "{size:?} {focal_px}: {found} {expected}");
        }
    }
}
