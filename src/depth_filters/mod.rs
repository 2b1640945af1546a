//! The reference depth filters, bit for bit as librealsense computes them, in the caller's buffers.
//!
//! The turn of 60 Hz does without them: a filter that smooths or fills makes the liquid's edge up. They are
//! here for recordings, for programs that expect them, and as a yardstick.
//!
//! ```text
//! Z16 --decimate--threshold--> [to_disparity] --> spatial --temporal--> [to_depth] --fill_holes--> Z16
//! ```
//!
//! Each filter was written from its description and compared with the library's own frames
//! (`tests/filters.rs`). "Invalid" is 0 for Z16; for disparities it is what is not above zero.
//!
//! Rows of one image do not depend on each other in the horizontal sweeps, so [`LANES`] of them are laid
//! side by side and swept at once: the recursion along a row then costs one vector operation where it
//! cost one dependent scalar each.

mod decimate;
mod disparity;
mod holes;
mod lanes;
mod spatial;
mod spatial_disparity;
mod temporal;
mod threshold;

pub use decimate::{Decimation, decimate};
pub use disparity::{disparity_factor, to_depth, to_disparity};
pub use holes::{HoleFilling, fill_holes};
pub use lanes::LANES;
pub use spatial::Spatial;
pub use spatial_disparity::SpatialDisparity;
pub use temporal::{Persistence, Temporal, TemporalState};
pub use threshold::threshold;

/// A buffer has not the size that the image asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SizeError {
    /// Purpose of the buffer.
    pub buffer: &'static str,
    /// Elements it has.
    pub has: usize,
    /// Elements that are needed.
    pub needs: usize,
}

impl core::fmt::Display for SizeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { buffer, has, needs } = self;
        write!(f, "the {buffer} has {has} elements, {needs} are needed")
    }
}

impl core::error::Error for SizeError {}

/// Refuses a buffer that has not exactly (or, if `more` may be, at least) the elements it needs.
fn check(buffer: &'static str, has: usize, needs: usize, more: bool) -> Result<(), SizeError> {
    let fits = if more { has >= needs } else { has == needs };
    if fits { Ok(()) } else { Err(SizeError { buffer, has, needs }) }
}

/// Rows of an image; an image without width has none.
fn rows<T>(image: &[T], width: usize) -> core::slice::ChunksExact<'_, T> {
    image.chunks_exact(width.max(1))
}

/// The same to be changed.
fn rows_mut<T>(image: &mut [T], width: usize) -> core::slice::ChunksExactMut<'_, T> {
    image.chunks_exact_mut(width.max(1))
}
