//! Hole filling on Z16: a hole takes one of its neighbours' depths, in place, row by row.
//!
//! | mode | rows | a hole becomes |
//! |---|---|---|
//! | left | all | the pixel to its left |
//! | farthest | 1 to H-2 | the largest of up, up-left, left, down-left, down |
//! | nearest | 1 to H-2 | up, then each of the others that is valid and less: stays a hole where up is one |
//!
//! Column 0 stays. What was filled is a neighbour of the next hole, so a fill runs to the right and
//! down without limit: before glass it makes up a surface that is not there.
//! Source: librealsense 2.56.5, hole filling filter, as measured.

use super::lanes::pair;
use super::{SizeError, check, rows_mut};

/// Neighbour whose depth a hole takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HoleFilling {
    /// The left one.
    Left,
    /// The farthest of five.
    #[default]
    Farthest,
    /// The nearest of five.
    Nearest,
}

/// Fills the holes of an image of rows of `width`.
///
/// ```
/// use meniscus::depth_filters::{HoleFilling, fill_holes};
///
/// let mut image = [400, 0, 402, 0];
/// fill_holes(&mut image, 4, HoleFilling::Left)?;
/// assert_eq!(image, [400, 400, 402, 402]);
/// # Ok::<(), meniscus::depth_filters::SizeError>(())
/// ```
///
/// # Errors
/// [`SizeError`] if the image is no whole number of rows.
pub fn fill_holes(image: &mut [u16], width: usize, mode: HoleFilling) -> Result<(), SizeError> {
    let height = image.len().checked_div(width).unwrap_or(0);
    check("image", image.len(), width.saturating_mul(height), false)?;
    match mode {
        HoleFilling::Left => rows_mut(image, width).for_each(from_left),
        HoleFilling::Farthest => {
            inner(image, width, height, |near| near.into_iter().fold(0, u16::max));
        }
        HoleFilling::Nearest => inner(image, width, height, |[up, rest @ ..]| {
            rest.into_iter().fold(up, |t, z| if z != 0 && z < t { z } else { t })
        }),
    }
    Ok(())
}

fn from_left(row: &mut [u16]) {
    let mut left = row.first().copied().unwrap_or(0);
    for pixel in row.iter_mut().skip(1) {
        *pixel = if *pixel == 0 { left } else { *pixel };
        left = *pixel;
    }
}

/// Every inner row with the row above, which is filled already, and the one below, which is not;
/// `choose` gets up, up-left, left, down-left, down.
#[inline(always)]
fn inner(image: &mut [u16], width: usize, height: usize, choose: impl Fn([u16; 5]) -> u16) {
    for row in 1..height.saturating_sub(1) {
        let end = (row + 1).saturating_mul(width);
        let Some((before, below)) = image.split_at_mut_checked(end) else { return };
        let Some((above, current)) = pair(before, width, row - 1, row) else { return };
        // Most rows have no hole, and finding that out is faster than walking them.
        if !current.contains(&0) {
            continue;
        }
        let mut left = current.first().copied().unwrap_or(0);
        let ups = above.array_windows::<2>();
        let downs = below.get(..width).unwrap_or(&[]).array_windows::<2>();
        for ((pixel, &[up_left, up]), &[down_left, down]) in current.iter_mut().skip(1).zip(ups).zip(downs) {
            if *pixel == 0 {
                *pixel = choose([up, up_left, left, down_left, down]);
            }
            left = *pixel;
        }
    }
}
