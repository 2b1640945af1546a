//! The region of interest: the columns around the expected glass, the rows from rim to foot.

use super::config::{Config, MAX_COLUMNS};

/// A rectangle of pixels, ends exclusive; at most [`MAX_COLUMNS`] wide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Region {
    pub(super) left: usize,
    pub(super) right: usize,
    pub(super) top: usize,
    pub(super) bottom: usize,
}

impl Region {
    /// Around the last known position of the glass axis, or the whole search range without one.
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
