//! The inner loops. A panel of rows is summed over the columns in registers, weights streaming through once.
//!
//! Panels are summed in halves of 16 rows: four SSE registers of accumulators or two of AVX2, so that sums
//! and products both find room, and a half without rows is left out.

use super::packing::PANEL;
use crate::latent::nn::cpu_width::{Kernel, ahead};
use crate::real::Real;

/// Rows of half a panel.
pub(super) const HALF: usize = PANEL / 2;

/// y = y + W x over f32.
pub(super) struct F32<'a> {
    pub(super) panels: &'a [[f32; PANEL]],
    pub(super) columns: usize,
    pub(super) x: &'a [f32],
    pub(super) y: &'a mut [f32],
}

impl Kernel for F32<'_> {
    #[inline(always)]
    fn run<const WIDE: bool>(self) {
        let columns = self.columns.max(1);
        // Two panels are two streams from memory, which come faster than one; their sums fill sixteen narrow registers.
        let at_once = if WIDE { 2 } else { 1 };
        let panels = self.panels.chunks(at_once * columns);
        for (out, panels) in self.y.chunks_mut(at_once * PANEL).zip(panels) {
            match (out.split_at_mut_checked(PANEL), panels.split_at_checked(columns)) {
                (Some((upper, lower)), Some((one, other))) if !lower.is_empty() => {
                    two_panels(one, other, self.x, upper, lower);
                }
                // Of two panels the second has no rows in y; x may be longer than the columns of the first.
                _ if WIDE => one_panel(panels.get(..columns).unwrap_or(panels), self.x, out),
                _ => one_panel(panels, self.x, out),
            }
        }
    }
}

/// out = out + (a panel) x.
#[inline(always)]
fn one_panel(panel: &[[f32; PANEL]], x: &[f32], out: &mut [f32]) {
    let mut sums = [0.0_f32; PANEL];
    for (column, &xj) in panel.iter().zip(x) {
        multiply(&mut sums, column, xj);
    }
    add(out, &sums);
}

/// The same for two panels, column by column.
#[inline(always)]
fn two_panels(one: &[[f32; PANEL]], other: &[[f32; PANEL]], x: &[f32], upper: &mut [f32], lower: &mut [f32]) {
    let (mut sums, mut others) = ([0.0_f32; PANEL], [0.0_f32; PANEL]);
    for ((column, below), &xj) in one.iter().zip(other).zip(x) {
        multiply(&mut sums, column, xj);
        multiply(&mut others, below, xj);
    }
    add(upper, &sums);
    add(lower, &others);
}

/// sums + column x_j.
#[inline(always)]
fn multiply(sums: &mut [f32; PANEL], column: &[f32; PANEL], xj: f32) {
    for (sum, w) in sums.iter_mut().zip(column) {
        *sum += w * xj;
    }
}

/// out + sums, as far as there is an out.
#[inline(always)]
fn add(out: &mut [f32], sums: &[f32]) {
    for (o, sum) in out.iter_mut().zip(sums) {
        *o += sum;
    }
}

/// The product with an `x` of many zeros, whose columns are left out: a sum that starts at +0 stays the same to the bit.
pub(super) struct Sparse<'a>(pub(super) F32<'a>);

impl Kernel for Sparse<'_> {
    #[inline(always)]
    fn run<const WIDE: bool>(self) {
        let F32 { panels, columns, x, y } = self.0;
        for (out, panel) in y.chunks_mut(PANEL).zip(panels.chunks_exact(columns.max(1))) {
            let mut sums = [0.0_f32; PANEL];
            for (column, &xj) in panel.iter().zip(x).filter(|(_, xj)| **xj != 0.0) {
                multiply(&mut sums, column, xj);
            }
            add(out, &sums);
        }
    }
}

/// y = y + W x over bf16: a word holds a row of the first half of a panel (its lower bits) and the row 16
/// below, so that both become f32 by one operation and no shuffle.
pub(super) struct Bf16<'a> {
    pub(super) panels: &'a [[u32; HALF]],
    pub(super) columns: usize,
    pub(super) x: &'a [f32],
    pub(super) y: &'a mut [f32],
}

impl Kernel for Bf16<'_> {
    #[inline(always)]
    fn run<const WIDE: bool>(self) {
        let panels = self.panels.chunks_exact(self.columns.max(1));
        for (out, panel) in self.y.chunks_mut(PANEL).zip(panels) {
            let (mut upper, mut lower) = ([0.0_f32; HALF], [0.0_f32; HALF]);
            for (column, &xj) in panel.iter().zip(self.x) {
                ahead(column);
                for ((up, low), &word) in upper.iter_mut().zip(&mut lower).zip(column) {
                    *up += f32::from_bits(word << 16) * xj;
                    *low += f32::from_bits(word & 0xFFFF_0000) * xj;
                }
            }
            for (o, sum) in out.iter_mut().zip(upper.iter().chain(&lower)) {
                *o += sum;
            }
        }
    }
}

/// y = y + W x in double precision over f32.
pub(super) struct Exact<'a, R> {
    pub(super) panels: &'a [[f32; PANEL]],
    pub(super) columns: usize,
    pub(super) x: &'a [R],
    pub(super) y: &'a mut [R],
}

impl<R: Real> Kernel for Exact<'_, R> {
    #[inline(always)]
    fn run<const WIDE: bool>(self) {
        let panels = self.panels.chunks_exact(self.columns.max(1));
        for (out, panel) in self.y.chunks_mut(PANEL).zip(panels) {
            match out.split_at_mut_checked(HALF) {
                Some((upper, lower)) => {
                    half::<0, R>(panel, self.x, upper);
                    if !lower.is_empty() {
                        half::<1, R>(panel, self.x, lower);
                    }
                }
                None => half::<0, R>(panel, self.x, out),
            }
        }
    }
}

/// out = out + (rows 16 `WHICH` to 16 `WHICH` + 15 of the panel) x.
#[inline(always)]
fn half<const WHICH: usize, R: Real>(panel: &[[f32; PANEL]], x: &[R], out: &mut [R]) {
    let mut sums = [R::default(); HALF];
    for (column, &xj) in panel.iter().zip(x) {
        let halves: &[[f32; HALF]; 2] = column.as_chunks().0.first_chunk().unwrap_or(&[[0.0; HALF]; 2]);
        let [first, second] = halves;
        let half = if WHICH == 0 { first } else { second };
        for (sum, &w) in sums.iter_mut().zip(half) {
            *sum += R::from(w) * xj;
        }
    }
    for (o, sum) in out.iter_mut().zip(sums) {
        *o += sum;
    }
}

/// y = y + W^T x in double precision over f32.
pub(super) struct Transposed<'a, R> {
    pub(super) panels: &'a [[f32; PANEL]],
    pub(super) columns: usize,
    pub(super) x: &'a [R],
    pub(super) y: &'a mut [R],
}

impl<R: Real> Kernel for Transposed<'_, R> {
    #[inline(always)]
    fn run<const WIDE: bool>(self) {
        let panels = self.panels.chunks_exact(self.columns.max(1));
        for (input, panel) in self.x.chunks(PANEL).zip(panels) {
            // Behind the last row stand zeros, so that every column is summed in the same straight line.
            let mut padded = [R::default(); PANEL];
            padded.iter_mut().zip(input).for_each(|(to, x)| *to = *x);
            for (out, column) in self.y.iter_mut().zip(panel) {
                // Four running sums instead of one, so that additions need not wait for each other.
                let mut sums = [R::default(); 4];
                for (xs, ws) in padded.as_chunks::<4>().0.iter().zip(column.as_chunks::<4>().0) {
                    for ((sum, &w), &xi) in sums.iter_mut().zip(ws).zip(xs) {
                        *sum += R::from(w) * xi;
                    }
                }
                *out += sums.iter().sum::<R>();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With y shorter than the matrix has rows and x longer than it has columns, too.
    #[test]
    fn two_panels_at_once_give_the_bits_of_one_after_the_other() {
        const COLUMNS: usize = 3;
        let panels: [[f32; PANEL]; 4 * COLUMNS] = core::array::from_fn(|at| {
            core::array::from_fn(|row| ((at * PANEL + row) as f32 * 0.37).rem_euclid(1.3) - 0.6)
        });
        let x = [0.3, -1.7, 0.9, 11.0, 13.0, 17.0];
        for rows in [1, 20, 32, 33, 64, 70, 96, 100, 128] {
            for x in [&x[..2], &x[..COLUMNS], &x] {
                let (mut one, mut two) = ([0.1_f32; 128], [0.1_f32; 128]);
                F32 { panels: &panels, columns: COLUMNS, x, y: &mut one[..rows] }.run::<false>();
                F32 { panels: &panels, columns: COLUMNS, x, y: &mut two[..rows] }.run::<true>();
                assert_eq!(one.map(f32::to_bits), two.map(f32::to_bits), "{rows} rows, {} of x", x.len());
            }
        }
    }
}
