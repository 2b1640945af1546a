//! Intrinsics of the depth image: from the camera's own list, or from slots of the coefficients table.
//!
//! | source | layout |
//! |---|---|
//! | list (RECPARAMSGET) | items of 20 bytes: u16 width, u16 height, f32 fx, fy, ppx, ppy |
//! | coefficients, table 25 | baseline in mm at 160; sixteen slots of f32 fx, fy, ppx, ppy from 256 |
//!
//! A slot with fx = fy and ppx = ppy was never written; a common camera stands in: f = 1.5 w,
//! pp = (w/2, h/2). The image is rectified, so there is no distortion.

use super::monitor::{Command, opcode};
use super::table::Table;
use crate::usb::lens::Intrinsics;
use crate::usb::uvc::bytes::{f32_at, u16_at};

/// Bytes of an item of the list.
const ITEM: usize = 20;
/// Offset of the first slot, and the bytes of one.
const SLOTS: (usize, usize) = (256, 16);
/// Sizes of the slots that this program can use, by slot.
const SIZES: [(u16, u16); 10] = [
    (1920, 1080),
    (1280, 720),
    (640, 480),
    (848, 480),
    (640, 360),
    (424, 240),
    (320, 240),
    (480, 270),
    (1280, 800),
    (960, 540),
];

/// Fault of a calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CalibrationError {
    /// Neither list nor table knows the size.
    Size {
        /// Pixels in a row.
        width: u16,
        /// Rows.
        height: u16,
    },
    /// A focal length or principal point that no such camera has.
    Implausible {
        /// fx, fy, ppx, ppy as stored.
        values: [f32; 4],
        /// Pixels in a row.
        width: u16,
        /// Rows.
        height: u16,
    },
    /// The baseline is no length of such a camera's.
    Baseline(f32),
    /// The colour lens stands or looks as it cannot beside the depth lens.
    Colour {
        /// Of the angles between its axes and those of the depth image.
        cosines: [f32; 3],
        /// From it to the depth lens, metres.
        apart_m: [f32; 3],
    },
}

impl core::fmt::Display for CalibrationError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Size { width, height } => {
                write!(f, "the camera has no intrinsics for images of {width} x {height}")
            }
            Self::Implausible { values: [fx, fy, ppx, ppy], width, height } => write!(
                f,
                "the camera's intrinsics for {width} x {height} cannot be: fx {fx} fy {fy} ppx {ppx} ppy {ppy}"
            ),
            Self::Colour { cosines: [x, y, z], apart_m: [right, down, forward] } => write!(
                f,
                "the colour lens cannot stand like that beside the depth lens: cosines of its axes {x} {y} {z}, the depth \
                 lens {right} {down} {forward} m from it"
            ),
            Self::Baseline(mm) => write!(f, "the camera's baseline cannot be {mm} mm"),
        }
    }
}

impl core::error::Error for CalibrationError {}

/// The command that asks for the list.
const LIST: Command<'static> = Command::new(opcode::RECPARAMSGET, [0; 4]);

/// The list's command and the intrinsics that its payload has for an image size.
pub mod recommended {
    use super::{CalibrationError, Command, ITEM, Intrinsics, LIST, four, sound, u16_at};

    /// The command.
    pub const COMMAND: Command<'static> = LIST;

    /// The item of an image size, width and height in pixels.
    ///
    /// ```
    /// use meniscus::usb::d4xx::recommended;
    ///
    /// let mut list = [0; 20];
    /// list[..4].copy_from_slice(&[0x80, 2, 0xe0, 1]);
    /// for (k, value) in [384.2_f32, 384.2, 319.5, 236.4].into_iter().enumerate() {
    ///     list[4 + 4 * k..8 + 4 * k].copy_from_slice(&value.to_le_bytes());
    /// }
    /// assert_eq!(recommended::read(&list, (640, 480)).map(|lens| lens.ppy), Ok(236.4));
    /// assert!(recommended::read(&list, (848, 480)).is_err());
    /// ```
    ///
    /// # Errors
    /// [`CalibrationError`] when the list lacks the size or holds nonsense for it.
    pub fn read(payload: &[u8], size: (u16, u16)) -> Result<Intrinsics, CalibrationError> {
        let (width, height) = size;
        let has_size = |item: &&[u8]| u16_at(item, 0) == Some(width) && u16_at(item, 2) == Some(height);
        let item = payload.chunks_exact(ITEM).find(has_size);
        let values = item.and_then(|item| four(item, 4));
        sound(values.ok_or(CalibrationError::Size { width, height })?, width, height)
    }
}

/// The intrinsics of an image size, width and height in pixels, by the slots of table 25.
///
/// ```
/// use meniscus::usb::d4xx::{Table, coefficients};
///
/// // Slot 2 is that of 640 x 480.
/// let mut bytes = [0; 512];
/// for (k, value) in [384.2_f32, 384.2, 319.5, 236.4].into_iter().enumerate() {
///     bytes[288 + 4 * k..292 + 4 * k].copy_from_slice(&value.to_le_bytes());
/// }
/// let table = Table { bytes: &bytes };
/// assert_eq!(coefficients(&table, (640, 480)).map(|lens| lens.fx), Ok(384.2));
/// assert!(coefficients(&table, (256, 144)).is_err());
/// ```
///
/// # Errors
/// [`CalibrationError`] when the table has no slot for it or nonsense in it.
pub fn coefficients(table: &Table<'_>, size: (u16, u16)) -> Result<Intrinsics, CalibrationError> {
    let (width, height) = size;
    let unknown = CalibrationError::Size { width, height };
    let slot = SIZES.iter().position(|listed| *listed == size).ok_or(unknown)?;
    let values = four(table.bytes, SLOTS.0 + slot * SLOTS.1).ok_or(unknown)?;
    let [fx, fy, ppx, ppy] = values;
    if fx == fy && ppx == ppy {
        let (w, h) = (f32::from(width), f32::from(height));
        return sound([1.5 * w, 1.5 * w, w / 2.0, h / 2.0], width, height);
    }
    sound(values, width, height)
}

/// The distance of the two imagers, millimetres, by table 25.
///
/// ```
/// use meniscus::usb::d4xx::{CalibrationError, Table, baseline_mm};
///
/// let mut bytes = [0; 512];
/// assert_eq!(baseline_mm(&Table { bytes: &bytes }), Err(CalibrationError::Baseline(0.0)));
/// bytes[160..164].copy_from_slice(&(-50.1_f32).to_le_bytes());
/// assert_eq!(baseline_mm(&Table { bytes: &bytes }), Ok(50.1));
/// ```
///
/// # Errors
/// [`CalibrationError::Baseline`] when it is not between 10 and 200 mm.
pub fn baseline_mm(table: &Table<'_>) -> Result<f32, CalibrationError> {
    let stored = f32_at(table.bytes, 160).unwrap_or(f32::NAN);
    let size = if stored < 0.0 { -stored } else { stored };
    if (10.0..=200.0).contains(&size) { Ok(size) } else { Err(CalibrationError::Baseline(stored)) }
}

fn four(bytes: &[u8], at: usize) -> Option<[f32; 4]> {
    let number = |k: usize| f32_at(bytes, at + 4 * k);
    Some([number(0)?, number(1)?, number(2)?, number(3)?])
}

/// A focal length of 0.3 to 3 image widths, a principal point in the middle half of the image.
pub(super) fn sound(values: [f32; 4], width: u16, height: u16) -> Result<Intrinsics, CalibrationError> {
    let [fx, fy, ppx, ppy] = values;
    let (w, h) = (f32::from(width), f32::from(height));
    let focal = 0.3 * w..=3.0 * w;
    let centred = (0.25 * w..=0.75 * w).contains(&ppx) && (0.25 * h..=0.75 * h).contains(&ppy);
    // A comparison with a number that is none is false.
    if focal.contains(&fx) && focal.contains(&fy) && centred {
        return Ok(Intrinsics { width: width.into(), height: height.into(), fx, fy, ppx, ppy });
    }
    Err(CalibrationError::Implausible { values, width, height })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(slot: usize, values: [f32; 4], baseline: f32) -> [u8; 512] {
        let mut bytes = [0; 512];
        bytes[160..164].copy_from_slice(&baseline.to_le_bytes());
        for (k, value) in values.iter().enumerate() {
            let at = 256 + 16 * slot + 4 * k;
            bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        }
        bytes
    }

    const D435: [f32; 4] = [384.21, 384.21, 319.48, 236.35];

    #[test]
    fn slot_two_is_640_by_480() {
        let bytes = table(2, D435, -50.1);
        let found = coefficients(&Table { bytes: &bytes }, (640, 480)).expect("sound");
        assert_eq!([found.fx, found.fy, found.ppx, found.ppy], D435);
        assert_eq!(baseline_mm(&Table { bytes: &bytes }), Ok(50.1), "its sign is not known");
        let other = coefficients(&Table { bytes: &bytes }, (256, 144));
        assert_eq!(other, Err(CalibrationError::Size { width: 256, height: 144 }));
    }

    #[test]
    fn an_unwritten_slot_is_a_common_camera_and_nonsense_is_refused() {
        let unwritten = table(2, [0.0; 4], 50.0);
        let found = coefficients(&Table { bytes: &unwritten }, (640, 480)).expect("a stand-in");
        assert_eq!([found.fx, found.fy, found.ppx, found.ppy], [960.0, 960.0, 320.0, 240.0]);
        for values in [[f32::NAN, 1.0, 2.0, 3.0], [384.0, 384.0, 900.0, 236.0], [-384.0, 384.0, 320.0, 240.0]]
        {
            let nonsense = table(2, values, f32::NAN);
            let refused = coefficients(&Table { bytes: &nonsense }, (640, 480));
            assert!(matches!(refused, Err(CalibrationError::Implausible { .. })), "{refused:?}");
            assert!(baseline_mm(&Table { bytes: &nonsense }).is_err());
        }
    }

    #[test]
    fn the_list_is_searched_by_size() {
        let mut list = [0; 40];
        list[..4].copy_from_slice(&[0x50, 3, 0xe0, 1]);
        list[20..24].copy_from_slice(&[0x80, 2, 0xe0, 1]);
        for (k, value) in D435.iter().enumerate() {
            list[24 + 4 * k..28 + 4 * k].copy_from_slice(&value.to_le_bytes());
        }
        assert_eq!(recommended::read(&list, (640, 480)).map(|i| i.ppx), Ok(319.48));
        assert!(matches!(recommended::read(&list, (848, 480)), Err(CalibrationError::Implausible { .. })));
        assert!(matches!(recommended::read(&list[..39], (640, 480)), Err(CalibrationError::Size { .. })));
    }
}
