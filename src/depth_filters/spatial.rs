//! The edge-preserving spatial filter on Z16.
//!
//! Each iteration sweeps every row to the right and back, then the image down and up. A pixel is mixed
//! with the one before it in the sweep, which is already filtered, if the two are near:
//!
//! `mix(c, p) = trunc(c alpha + p (1 - alpha) + 1/2)`, in single precision.
//!
//! | sweep | visits | mixes where |
//! |---|---|---|
//! | right | 1 to W-2 | both valid, `abs(c - p) <= delta` |
//! | left | W-2 to 0 | `p >= 1`, `c > 1`, `abs(c - p) <= delta` |
//! | down | 1 to H-1 | `abs(c - p) < delta`, valid or not |
//! | up | H-2 to 0 | both valid, `abs(c - p) < delta` |
//!
//! With a hole radius `R`, the horizontal sweeps also copy a valid `p` into an invalid `c`, at most `R - 1`
//! times in a row. Source: librealsense 2.56.5, spatial filter, as measured.

use super::lanes::{LANES, gather, pair, scatter};
use super::{SizeError, check, rows_mut};

/// Settings of the filter; [`Spatial::default`] are the library's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spatial {
    /// Share of the pixel itself, 0.25 to 1.
    pub alpha: f32,
    /// Largest difference of pixels that are mixed, depth units, 1 to 50.
    pub delta: u16,
    /// Repetitions, 1 to 5.
    pub iterations: u8,
    /// Hole filling: 0 none; 1 to 4 a radius of 2, 4, 8, 16 pixels; 5 unlimited (255).
    pub holes: u8,
}

impl Default for Spatial {
    fn default() -> Self {
        Self { alpha: 0.5, delta: 20, iterations: 2, holes: 0 }
    }
}

/// `R` of a hole mode; 0 without filling.
pub(super) fn radius(holes: u8) -> u16 {
    match holes {
        0 => 0,
        1..=4 => 1 << holes,
        _ => 255,
    }
}

impl Spatial {
    /// Filters an image of rows of `width` in place; `room` takes [`LANES`] rows and must have `width`
    /// elements or more.
    ///
    /// ```
    /// use meniscus::depth_filters::{LANES, Spatial};
    ///
    /// // A step of more than `delta` stays, a smaller one is smoothed.
    /// let mut image = [400, 400, 404, 404, 900, 900];
    /// let mut room = [[0; LANES]; 6];
    /// Spatial::default().apply(&mut image, 6, &mut room)?;
    /// assert!(image[1] > 400 && image[2] < 404 && image[4] == 900, "{image:?}");
    /// # Ok::<(), meniscus::depth_filters::SizeError>(())
    /// ```
    ///
    /// # Errors
    /// [`SizeError`] if the room is too small or the image no whole number of rows; nothing is changed then.
    pub fn apply(&self, image: &mut [u16], width: usize, room: &mut [[u16; LANES]]) -> Result<(), SizeError> {
        check("room", room.len(), width, true)?;
        let height = image.len().checked_div(width).unwrap_or(0);
        check("image", image.len(), width.saturating_mul(height), false)?;
        let columns = room.get_mut(..width).unwrap_or(&mut []);
        for _ in 0..self.iterations {
            for rows in rows_mut(image, width.saturating_mul(LANES)) {
                self.sweep(rows, width, columns);
            }
            let last = height - height % LANES;
            if let Some(rows) = image.get_mut(last.saturating_mul(width)..) {
                self.sweep(rows, width, columns);
            }
            self.vertical(image, width, height);
        }
        Ok(())
    }

    /// Rows to the right and back. The plain case has a form of its own: it is the default.
    fn sweep(&self, rows: &mut [u16], width: usize, columns: &mut [[u16; LANES]]) {
        gather(rows, width, columns);
        match (self.alpha == 0.5, self.holes == 0) {
            (true, true) => self.horizontal::<false>(columns, half),
            (false, true) => self.horizontal::<false>(columns, self.mix()),
            (true, false) => self.horizontal::<true>(columns, half),
            (false, false) => self.horizontal::<true>(columns, self.mix()),
        }
        scatter(columns, width, rows);
    }

    fn mix(&self) -> impl Fn(u16, u16) -> u16 + Copy + use<> {
        let (alpha, rest) = (self.alpha, 1.0 - self.alpha);
        move |c, p| (f32::from(c) * alpha + f32::from(p) * rest + 0.5) as u16
    }

    fn horizontal<const FILL: bool>(&self, columns: &mut [[u16; LANES]], mix: impl Fn(u16, u16) -> u16) {
        let (delta, radius) = (self.delta, radius(self.holes));
        // The last column is not visited to the right.
        let end = columns.len().saturating_sub(1);
        let right = columns.get_mut(..end).unwrap_or(&mut []).iter_mut();
        along::<FILL>(right, 0, radius, delta, &mix);
        along::<FILL>(columns.iter_mut().rev(), 1, radius, delta, &mix);
    }

    fn vertical(&self, image: &mut [u16], width: usize, height: usize) {
        if self.alpha == 0.5 {
            self.down_and_up(image, width, height, half);
        } else {
            self.down_and_up(image, width, height, self.mix());
        }
    }

    fn down_and_up(&self, image: &mut [u16], width: usize, height: usize, mix: impl Fn(u16, u16) -> u16) {
        let delta = self.delta;
        for row in 1..height {
            if let Some((above, below)) = pair(image, width, row - 1, row) {
                for (c, &p) in below.iter_mut().zip(above) {
                    *c = if apart(*c, p) < delta { mix(*c, p) } else { *c };
                }
            }
        }
        for row in (1..height).rev() {
            if let Some((below, above)) = pair(image, width, row, row - 1) {
                for (c, &p) in above.iter_mut().zip(below) {
                    let near = (apart(*c, p) < delta) & (*c != 0) & (p != 0);
                    *c = if near { mix(*c, p) } else { *c };
                }
            }
        }
    }
}

/// One sweep; `hole` is the largest invalid value of the pixel visited (1 on the way to the left).
#[inline(always)]
fn along<'c, const FILL: bool>(
    mut columns: impl Iterator<Item = &'c mut [u16; LANES]>,
    hole: u16,
    radius: u16,
    delta: u16,
    mix: &impl Fn(u16, u16) -> u16,
) {
    let Some(first) = columns.next() else { return };
    let mut before = *first;
    let mut filled = [0_u16; LANES];
    for column in columns {
        let lanes = column.iter_mut().zip(&mut before).zip(&mut filled);
        for ((c, p), n) in lanes {
            let (seen, known) = (*c > hole, *p != 0);
            let near = seen & known & (apart(*c, *p) <= delta);
            let mut out = if near { mix(*c, *p) } else { *c };
            if FILL {
                let gap = known & !seen;
                *n = if seen & known { 0 } else { n.saturating_add(u16::from(gap)) };
                out = if gap & (*n < radius) { *p } else { out };
            }
            (*c, *p) = (out, out);
        }
    }
}

/// `abs(c - p)`.
#[inline(always)]
fn apart(c: u16, p: u16) -> u16 {
    c.saturating_sub(p) | p.saturating_sub(c)
}

/// The mix with alpha 1/2 in whole numbers: sums of halves are exact in single precision.
#[inline(always)]
fn half(c: u16, p: u16) -> u16 {
    ((u32::from(c) + u32::from(p) + 1) >> 1) as u16
}
