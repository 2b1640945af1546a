//! The region of interest: the columns around the expected glass, the rows from rim to foot.

use super::config::{Config, MAX_COLUMNS};
use super::edge::SPAN;

/// A rectangle of pixels, ends exclusive.
///
/// ```
/// use meniscus::surface::Region;
///
/// assert_eq!(Region::whole((640, 480)), Region { left: 0, right: 640, top: 0, bottom: 480 });
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// First column.
    pub left: usize,
    /// Column behind the last.
    pub right: usize,
    /// First row.
    pub top: usize,
    /// Row behind the last.
    pub bottom: usize,
}

impl Region {
    /// All of an image of a size, width and height in pixels.
    #[must_use]
    pub const fn whole(size: (usize, usize)) -> Self {
        let (width, height) = size;
        Self { left: 0, right: width, top: 0, bottom: height }
    }

    /// With the pixels beyond it that place an edge at its rim.
    pub(super) fn with_rim(self, size: (usize, usize)) -> Self {
        let (width, height) = size;
        Self {
            left: self.left.saturating_sub(SPAN),
            right: self.right.saturating_add(SPAN).min(width),
            top: self.top.saturating_sub(SPAN),
            bottom: self.bottom.saturating_add(SPAN).min(height),
        }
    }

    /// Around the last known position of the glass axis, or the whole search range without one; at most
    /// [`MAX_COLUMNS`] wide.
    pub(super) fn around(config: &Config, axis_m: Option<f32>) -> Self {
        let settings = &config.settings;
        let (centre, half) = match axis_m {
            Some(x_m) => (config.camera.column_of(x_m), settings.region_half_width_px),
            None => (settings.intrinsics.ppx, settings.search_half_width_px),
        };
        let centre = centre.max(0.0) as usize;
        let left = centre.saturating_sub(half.min(MAX_COLUMNS / 2));
        let right = centre.saturating_add(half.min(MAX_COLUMNS / 2)).min(settings.intrinsics.width);
        let (top, bottom) = config.rows;
        Self { left, right, top, bottom }
    }
}

/// A borrowed image of one-byte pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grey<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) width: usize,
}

impl<'a> Grey<'a> {
    /// Pixels `left..right` of a row; empty where there is no such row.
    pub(super) fn row(&self, row: usize, left: usize, right: usize) -> &'a [u8] {
        let start = row.saturating_mul(self.width);
        self.bytes.get(start.saturating_add(left)..start.saturating_add(right)).unwrap_or(&[])
    }

    /// One pixel.
    pub(super) fn at(&self, column: usize, row: usize) -> Option<u8> {
        self.bytes.get(row.saturating_mul(self.width).saturating_add(column)).copied()
    }
}
