//! The colour imager: its calibration table, and the controls that keep its rate.
//!
//! | offset in table 32 | field |
//! |---|---|
//! | 16 | 3 x 3 f32, row by row: normalised camera matrix, of which 0, 2, 4, 5 count |
//! | 52 | 5 f32: k1, k2, p1, p2, k3 |
//! | 144 | 2 u16: width and height of the calibration |
//! | 184 | 9 f32: rotation colour to depth, column by column |
//! | 220 | 3 f32: translation, millimetres, of the other sign |
//!
//! ```text
//! fx = k00 w / 2,  fy = k11 h / 2,  ppx = (1 + k02) w / 2,  ppy = (1 + k12) h / 2
//! ```
//!
//! of an image of the calibration's shape; of a taller one `k11` and `k12`, of a wider one `k00` and `k02` are
//! stretched by the ratio of the shapes. A point in the axes of depth is `R p + t` of one in those of colour with
//! `t = -0.001 translation`: the colour lens stands at `t`.

use super::intrinsics::{CalibrationError, sound};
use super::table::Table;
use crate::usb::lens::ColourLens;
use crate::usb::uvc::bytes::{f32_at, u16_at};

/// Id of the colour table.
pub const COLOUR: u16 = 32;
/// Selector of the automatic exposure mode of a UVC camera terminal, one byte.
pub const EXPOSURE_MODE: u8 = 0x02;
/// The mode in which the camera chooses the exposure.
pub const EXPOSURE_BY_CAMERA: u8 = 8;
/// Selector of the exposure's priority, one byte: 0 keeps the frame rate in the dark.
pub const EXPOSURE_PRIORITY: u8 = 0x03;

/// Farthest that the two lenses can be apart, metres: those of a D435 are 15 mm.
const APART_M: f32 = 0.06;
/// Least cosine between an axis and its fellow: three degrees.
const ALIGNED: f32 = 0.9986;

/// The colour lens, and where it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Colour {
    /// Its optics, and how it is turned.
    pub lens: ColourLens,
    /// Position of the depth lens relative to it: right, down, forward along the axes of the depth
    /// image, metres.
    pub depth_lens_m: [f32; 3],
}

/// The colour lens by table 32, for images of a size, width and height in pixels.
///
/// ```
/// use meniscus::usb::d4xx::{Table, colour};
///
/// let mut bytes = [0; 256];
/// let mut write = |at: usize, values: &[f32]| {
///     for (k, value) in values.iter().enumerate() {
///         bytes[at + 4 * k..at + 4 * k + 4].copy_from_slice(&value.to_le_bytes());
///     }
/// };
/// write(16, &[1.435, 0.0, 0.006, 0.0, 2.544, 0.02, 0.0, 0.0, 1.0]);
/// write(184, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
/// write(220, &[14.8, 0.2, -0.4]);
/// let colour = colour(&Table { bytes: &bytes }, (640, 480))?;
/// assert!((colour.lens.intrinsics.fy - 610.56).abs() < 1e-3);
/// assert!((colour.depth_lens_m[0] - 0.0148).abs() < 1e-6);
/// # Ok::<(), meniscus::usb::d4xx::CalibrationError>(())
/// ```
///
/// # Errors
/// [`CalibrationError`] when the table is too short or holds nonsense.
pub fn colour(table: &Table<'_>, size: (u16, u16)) -> Result<Colour, CalibrationError> {
    let (width, height) = size;
    let short = CalibrationError::Size { width, height };
    let number = |at: usize, k: usize| f32_at(table.bytes, at + 4 * k).ok_or(short);
    let [mut k00, mut k02, mut k11, mut k12] =
        [number(16, 0)?, number(16, 2)?, number(16, 4)?, number(16, 5)?];
    let (w, h) = (f32::from(width), f32::from(height));
    let calibrated =
        [u16_at(table.bytes, 144), u16_at(table.bytes, 146)].map(|side| f32::from(side.unwrap_or(0)));
    let [across, down] = if calibrated.contains(&0.0) { [16.0, 9.0] } else { calibrated };
    let (shape, own) = (down / across, h / w);
    if own < shape {
        k11 *= shape / own;
        k12 *= shape / own;
    } else {
        k00 *= own / shape;
        k02 *= own / shape;
    }
    let values = [0.5 * k00 * w, 0.5 * k11 * h, 0.5 * (1.0 + k02) * w, 0.5 * (1.0 + k12) * h];
    let intrinsics = sound(values, width, height)?;
    let mut distortion = [0.0; 5];
    for (k, coefficient) in distortion.iter_mut().enumerate() {
        *coefficient = number(52, k)?;
    }
    // The columns of the rotation from colour to depth are the rows of the one back.
    let mut rotation = [[0.0; 3]; 3];
    let mut depth_lens_m = [0.0; 3];
    for (row, axis) in rotation.iter_mut().enumerate() {
        for (column, entry) in axis.iter_mut().enumerate() {
            *entry = number(184, 3 * row + column)?;
        }
    }
    for (k, coordinate) in depth_lens_m.iter_mut().enumerate() {
        *coordinate = 1e-3 * number(220, k)?;
    }
    let [[xx, ..], [_, yy, _], [.., zz]] = rotation;
    let aligned = [xx, yy, zz].into_iter().all(|cosine| (ALIGNED..1.0001).contains(&cosine));
    let near = depth_lens_m.iter().all(|apart| (-APART_M..APART_M).contains(apart));
    let mild = distortion.iter().all(|coefficient| (-10.0..10.0).contains(coefficient));
    if !(aligned && near && mild) {
        return Err(CalibrationError::Colour { cosines: [xx, yy, zz], apart_m: depth_lens_m });
    }
    Ok(Colour { lens: ColourLens { intrinsics, distortion, rotation }, depth_lens_m })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(calibrated: [u16; 2], rotation: [f32; 9], translation_mm: [f32; 3]) -> [u8; 256] {
        let mut bytes = [0; 256];
        let mut write = |at: usize, values: &[f32]| {
            for (k, value) in values.iter().enumerate() {
                bytes[at + 4 * k..at + 4 * k + 4].copy_from_slice(&value.to_le_bytes());
            }
        };
        write(16, &[1.435, 0.0, 0.006, 0.0, 2.544, 0.02, 0.0, 0.0, 1.0]);
        write(52, &[0.1, 0.2, 0.3, 0.4, 0.5]);
        write(184, &rotation);
        write(220, &translation_mm);
        for (k, side) in calibrated.into_iter().enumerate() {
            bytes[144 + 2 * k..146 + 2 * k].copy_from_slice(&side.to_le_bytes());
        }
        bytes
    }

    const STRAIGHT: [f32; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

    #[test]
    fn an_image_narrower_than_the_calibration_is_a_cut_of_its_width() {
        let bytes = table([1920, 1080], STRAIGHT, [14.8, 0.2, -0.4]);
        let found = colour(&Table { bytes: &bytes }, (640, 480)).expect("sound");
        let lens = found.lens.intrinsics;
        // 4:3 out of 16:9 loses width: the focal length is that of the height, 2.544 * 240 = 610.6.
        assert!((lens.fx - 1.435 * 320.0 * (0.75 / 0.5625)).abs() < 1e-3, "{lens:?}");
        assert!((lens.fy - 610.56).abs() < 1e-3 && (lens.ppy - 244.8).abs() < 1e-3, "{lens:?}");
        assert!((lens.fx - lens.fy).abs() < 3.0, "square pixels: {lens:?}");
        assert_eq!(found.lens.distortion, [0.1, 0.2, 0.3, 0.4, 0.5]);
        for (found, mm) in found.depth_lens_m.into_iter().zip([14.8, 0.2, -0.4]) {
            assert!((found - 1e-3 * mm).abs() < 1e-7, "{found}");
        }
        let square = table([0, 0], STRAIGHT, [14.8, 0.2, -0.4]);
        assert_eq!(colour(&Table { bytes: &square }, (640, 480)), Ok(found), "16:9 where it does not say");
    }

    #[test]
    fn a_point_of_the_world_is_found_where_the_rotation_puts_it() {
        // Colour to depth: a turn about x by s, column by column.
        let (s, c) = crate::math::sincosf(0.01);
        let bytes = table([1920, 1080], [1.0, 0.0, 0.0, 0.0, c, s, 0.0, -s, c], [15.0, 0.0, 0.0]);
        let found = colour(&Table { bytes: &bytes }, (640, 480)).expect("sound");
        // A direction of colour's axes (0, b, 1), in those of depth: R (0, b, 1) = (0, c b - s, s b + c).
        let b = 0.1;
        let lens = ColourLens { distortion: [0.0; 5], ..found.lens };
        let (_, v) = lens.pixel_of(0.0, (c * b - s) / (s * b + c));
        assert!((v - (lens.intrinsics.fy * b + lens.intrinsics.ppy)).abs() < 1e-3, "{v}");
    }

    #[test]
    fn nonsense_and_a_table_that_ends_too_early_are_refused() {
        let turned = table([1920, 1080], [0.9, 0.1, 0.0, -0.1, 0.9, 0.0, 0.0, 0.0, 1.0], [15.0, 0.0, 0.0]);
        let far = table([1920, 1080], STRAIGHT, [150.0, 0.0, 0.0]);
        let none = table([1920, 1080], STRAIGHT, [f32::NAN, 0.0, 0.0]);
        for bytes in [turned, far, none] {
            let refused = colour(&Table { bytes: &bytes }, (640, 480));
            assert!(matches!(refused, Err(CalibrationError::Colour { .. })), "{refused:?}");
        }
        let cut = table([1920, 1080], STRAIGHT, [15.0, 0.0, 0.0]);
        let refused = colour(&Table { bytes: &cut[..230] }, (640, 480));
        assert_eq!(refused, Err(CalibrationError::Size { width: 640, height: 480 }));
    }
}
