//! Borrowed images as they leave the USB layer: pixels in place, sequence number, capture time.

use crate::units::Micros;

/// Number and time of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stamp {
    /// The camera's own frame counter; a gap is a lost frame.
    pub sequence: u32,
    /// Mid-exposure device time.
    pub captured: Micros,
}

/// A depth image, Z16 little-endian, `width * height * 2` bytes; 0 means "no depth here".
#[derive(Clone, Copy, Debug)]
pub struct DepthFrame<'a> {
    /// Row-major pixels, two bytes each, little-endian.
    pub bytes: &'a [u8],
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Sequence and time.
    pub stamp: Stamp,
}

/// The image in which the liquid's outline is traced, Y8: the left infrared image, which is pixel-aligned to the
/// depth image, or the colour image's luma, [rectified](crate::surface::Rectifier).
#[derive(Clone, Copy, Debug)]
pub struct OutlineFrame<'a> {
    /// Row-major pixels, one byte each.
    pub bytes: &'a [u8],
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Sequence and time.
    pub stamp: Stamp,
}
