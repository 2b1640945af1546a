//! The edge-preserving spatial filter on disparities: another algorithm, a recursion with hidden state.
//!
//! In each sweep, along a line: `s` is the filter's state, `p` the previous value before this sweep.
//!
//! | pixel `c`, previous pixel | |
//! |---|---|
//! | valid, valid | `d = p - c`; if `-delta < d < delta`: `s = c alpha + s (1 - alpha)`, `c` becomes `s`; else `s = c`; `p` = old `c` |
//! | valid, invalid | `s = p = c` |
//! | invalid | nothing, but it is now the previous pixel |
//!
//! Sweeps: right, left over all rows, then down, up. All in single precision.
//! Source: E. S. L. Gastal and M. M. Oliveira, Domain transform for edge-aware image and video processing,
//! ACM TOG 30 (2011), in the form of librealsense 2.56.5, as measured.

use super::lanes::{LANES, gather, scatter};
use super::spatial::radius;
use super::{SizeError, check, rows_mut};

/// Settings of the filter; [`SpatialDisparity::default`] are the library's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpatialDisparity {
    /// Share of the pixel itself, 0.25 to 1.
    pub alpha: f32,
    /// Largest difference of pixels that are mixed, 1/32 pixel of disparity.
    pub delta: f32,
    /// Repetitions, 1 to 5.
    pub iterations: u8,
    /// Hole filling as in [`super::Spatial`], one pass behind all iterations.
    pub holes: u8,
}

impl Default for SpatialDisparity {
    fn default() -> Self {
        Self { alpha: 0.5, delta: 20.0, iterations: 2, holes: 0 }
    }
}

/// Visits a pixel: `s` is the state of its line and `p` its previous value, NaN where that was invalid, so
/// that no difference to it is small. A state behind an invalid pixel is never used.
#[inline(always)]
fn visit(pixel: &mut f32, s: &mut f32, p: &mut f32, [alpha, rest, delta]: [f32; 3]) {
    let c = *pixel;
    // As the library tests it: by the sign and the bits.
    let valid = c.to_bits().cast_signed() > 0;
    let d = *p - c;
    let near = valid & (d < delta) & (d > -delta);
    let out = if near { c * alpha + *s * rest } else { c };
    (*pixel, *s) = (out, out);
    *p = if valid { c } else { f32::NAN };
}

impl SpatialDisparity {
    /// Filters an image of rows of `width` in place; `room` takes [`LANES`] rows and must have `width`
    /// elements or more.
    ///
    /// ```
    /// use meniscus::depth_filters::{LANES, SpatialDisparity};
    ///
    /// let mut image = [40.0, 40.0, 44.0, 44.0, 400.0, 400.0];
    /// let mut room = [[0.0; LANES]; 6];
    /// SpatialDisparity::default().apply(&mut image, 6, &mut room)?;
    /// assert!(image[1] > 40.0 && image[2] < 44.0 && image[4] == 400.0, "{image:?}");
    /// # Ok::<(), meniscus::depth_filters::SizeError>(())
    /// ```
    ///
    /// # Errors
    /// [`SizeError`] if the room is too small or the image no whole number of rows; nothing is changed then.
    pub fn apply(&self, image: &mut [f32], width: usize, room: &mut [[f32; LANES]]) -> Result<(), SizeError> {
        check("room", room.len(), width, true)?;
        let height = image.len().checked_div(width).unwrap_or(0);
        check("image", image.len(), width.saturating_mul(height), false)?;
        let columns = room.get_mut(..width).unwrap_or(&mut []);
        for _ in 0..self.iterations {
            for rows in image.chunks_mut(width.saturating_mul(LANES).max(1)) {
                gather(rows, width, columns);
                self.along(columns.iter_mut());
                self.along(columns.iter_mut().rev());
                scatter(columns, width, rows);
            }
            // Down and up a row is one visit of all columns; the room takes their states.
            let (states, rest) = columns.as_flattened_mut().split_at_mut_checked(width).unwrap_or_default();
            let previous = rest.get_mut(..width).unwrap_or(&mut []);
            previous.fill(f32::NAN);
            rows_mut(image, width).for_each(|row| self.across(row, states, previous));
            previous.fill(f32::NAN);
            rows_mut(image, width).rev().for_each(|row| self.across(row, states, previous));
        }
        if self.holes > 0 {
            self.fill(image, width);
        }
        Ok(())
    }

    fn constants(&self) -> [f32; 3] {
        [self.alpha, 1.0 - self.alpha, self.delta]
    }

    fn along<'c>(&self, columns: impl Iterator<Item = &'c mut [f32; LANES]>) {
        let constants = self.constants();
        let (mut states, mut previous) = ([0.0; LANES], [f32::NAN; LANES]);
        for column in columns {
            for ((pixel, s), p) in column.iter_mut().zip(&mut states).zip(&mut previous) {
                visit(pixel, s, p, constants);
            }
        }
    }

    fn across(&self, row: &mut [f32], states: &mut [f32], previous: &mut [f32]) {
        let constants = self.constants();
        for ((pixel, s), p) in row.iter_mut().zip(states).zip(previous) {
            visit(pixel, s, p, constants);
        }
    }

    /// Holes from the left, then from the right. On the way back the last pixel of a row takes the first
    /// one of the next row, as the library does by reading on in memory; that of the last row, which would
    /// be read from behind the image, stays.
    fn fill(&self, image: &mut [f32], width: usize) {
        let radius = radius(self.holes);
        for row in rows_mut(image, width) {
            let mut run = 0_u16;
            let mut before = row.first().copied().unwrap_or(0.0);
            for pixel in row.iter_mut().skip(1) {
                copy_into_hole(pixel, before, &mut run, radius);
                before = *pixel;
            }
        }
        let mut next_row: Option<f32> = None;
        for row in rows_mut(image, width).rev() {
            let (mut run, mut behind) = (0_u16, next_row);
            for pixel in row.iter_mut().skip(1).rev() {
                match behind {
                    Some(behind) => copy_into_hole(pixel, behind, &mut run, radius),
                    None => run = u16::from(*pixel == 0.0),
                }
                behind = Some(*pixel);
            }
            next_row = row.first().copied();
        }
    }
}

fn copy_into_hole(pixel: &mut f32, neighbour: f32, run: &mut u16, radius: u16) {
    *run = if *pixel == 0.0 { run.saturating_add(1) } else { 0 };
    if *pixel == 0.0 && *run < radius {
        *pixel = neighbour;
    }
}
