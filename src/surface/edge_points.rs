//! Points of the liquid's edge, in the image and in space.

use super::config::MAX_COLUMNS;
use heapless::Vec;

/// Columns on either side that vote on whether a column is an outlier.
pub(super) const NEIGHBOURS: usize = 3;

/// One point of the edge in the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct EdgePoint {
    pub(super) column: usize,
    /// Sub-pixel row; whole numbers are pixel centres.
    pub(super) row: f32,
    /// Variance beside the usual scatter, square pixels: what foam and bands add.
    pub(super) own_px2: f32,
    /// Move down to the onset of a band.
    pub(super) moved: Move,
}

/// Move of an edge point down to the onset of a band.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Move {
    /// Rows.
    pub(super) rows: f32,
    /// Part of the point's own variance that it adds, square pixels.
    pub(super) variance_px2: f32,
    /// Whether the band is faint: a tone near that of the front, which a liquid that shines through has as well.
    pub(super) faint: bool,
}

/// The edge, at most one point a column, columns rising.
pub(super) type Edge = Vec<EdgePoint, MAX_COLUMNS>;

/// A point of the edge in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    /// `x` from the glass axis, metres.
    pub(super) x_m: f32,
    /// Height above the inner bottom, metres.
    pub(super) z_m: f32,
    /// Change of the height with the depth: the ray's rise.
    pub(super) rise: f32,
    /// Variance of its own beside the edge's and the depth's noise, square metres.
    pub(super) own_m2: f32,
    /// Distance by which it was lowered already, metres.
    pub(super) lowered_m: f32,
    /// Part of that which rests on a faint band alone, and the variance that it added.
    pub(super) faint_m: f32,
    pub(super) faint_m2: f32,
}

/// The edge in space, `x` rising.
pub(super) type Samples = Vec<Sample, MAX_COLUMNS>;

/// An item of a list and its neighbours, up to `reach` on either side.
pub(super) fn around<T>(list: &[T], index: usize, reach: usize) -> impl Iterator<Item = &T> + Clone {
    let start = index.saturating_sub(reach);
    list.iter().skip(start).take(index - start + reach + 1)
}
