//! The neighbours of a particle side by side: a column for each of their numbers, so that one formula runs down the columns in
//! vectors as wide as the processor's.
//!
//! A row of the neighbour list is gathered into columns, computed, and scattered again. Each pair is computed as it would be
//! alone, and what a particle gets is added in the order of its list: vectors of any width give the same bits.

use super::state::Particle;
use meniscus::latent::nn::{Kernel as Work, widest};
use std::ops::Range;

/// Most neighbours that are computed at once; a longer row is taken in pieces.
pub(crate) const BLOCK: usize = 64;

/// A number of each neighbour.
pub(crate) type Column = [f64; BLOCK];

/// Positions and velocities, volumes and pressures of neighbours.
pub(crate) struct Near {
    x: [Column; 3],
    v: [Column; 3],
    /// Volumes, m3.
    pub(crate) volume: Column,
    /// Pressures, Pa.
    pub(crate) p: Column,
}

impl Near {
    /// Columns without content.
    pub(crate) fn new() -> Self {
        Self { x: [[0.0; BLOCK]; 3], v: [[0.0; BLOCK]; 3], volume: [0.0; BLOCK], p: [0.0; BLOCK] }
    }

    /// Takes the particles `at` of `others`.
    #[inline(always)]
    pub(crate) fn gather(&mut self, others: &[Particle], at: &[u32]) {
        for (k, j) in at.iter().enumerate().take(BLOCK) {
            let b = &others[*j as usize];
            for c in 0..3 {
                self.x[c][k] = b.x[c];
                self.v[c][k] = b.v[c];
            }
            self.volume[k] = b.volume;
            self.p[k] = b.p;
        }
    }

    /// `x_i - x_j`, m, for neighbour `k` of a particle at `x`.
    #[inline(always)]
    pub(crate) fn apart(&self, x: &[f64; 3], k: usize) -> [f64; 3] {
        [x[0] - self.x[0][k], x[1] - self.x[1][k], x[2] - self.x[2][k]]
    }

    /// `v_i - v_j`, m/s, for neighbour `k` of a particle with the velocity `v`.
    #[inline(always)]
    pub(crate) fn slower(&self, v: &[f64; 3], k: usize) -> [f64; 3] {
        [v[0] - self.v[0][k], v[1] - self.v[1][k], v[2] - self.v[2][k]]
    }

    /// `v_j` of neighbour `k`, m/s.
    #[inline(always)]
    pub(crate) fn velocity(&self, k: usize) -> [f64; 3] {
        [self.v[0][k], self.v[1][k], self.v[2][k]]
    }
}

/// `a.b`.
#[inline(always)]
pub(crate) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Takes the rows `at` of `table` into `columns`.
#[inline(always)]
pub(crate) fn gather<const N: usize>(columns: &mut [Column; N], table: &[[f64; N]], at: &[u32]) {
    for (k, j) in at.iter().enumerate().take(BLOCK) {
        for (column, x) in columns.iter_mut().zip(&table[*j as usize]) {
            column[k] = *x;
        }
    }
}

/// Takes the numbers `at` of `table` into `column`.
#[inline(always)]
pub(crate) fn gather_numbers(column: &mut Column, table: &[f64], at: &[u32]) {
    for (x, j) in column.iter_mut().zip(at) {
        *x = table[*j as usize];
    }
}

/// Row `k` of `columns`.
#[inline(always)]
pub(crate) fn row<const N: usize>(columns: &[Column; N], k: usize) -> [f64; N] {
    let mut row = [0.0; N];
    for (x, column) in row.iter_mut().zip(columns) {
        *x = column[k];
    }
    row
}

/// Puts `numbers` into row `k` of `columns`.
#[inline(always)]
pub(crate) fn put<const N: usize>(columns: &mut [Column; N], k: usize, numbers: [f64; N]) {
    for (column, x) in columns.iter_mut().zip(numbers) {
        column[k] = x;
    }
}

/// The sums of the first `rows` rows of `columns`, from the first on.
#[inline(always)]
pub(crate) fn sum<const N: usize>(columns: &[Column; N], rows: usize) -> [f64; N] {
    let mut sums = [0.0; N];
    for k in 0..rows.min(BLOCK) {
        add(&mut sums, &row(columns, k));
    }
    sums
}

/// Adds the rows of `columns` to the rows `at` of `table`.
#[inline(always)]
pub(crate) fn scatter<const N: usize>(columns: &[Column; N], at: &[u32], table: &mut [[f64; N]]) {
    for (k, j) in at.iter().enumerate().take(BLOCK) {
        add(&mut table[*j as usize], &row(columns, k));
    }
}

/// `to += numbers`.
#[inline(always)]
pub(crate) fn add<const N: usize>(to: &mut [f64; N], numbers: &[f64; N]) {
    for (to, x) in to.iter_mut().zip(numbers) {
        *to += x;
    }
}

/// A sum over the pairs of [`super::neighbours`], `N` numbers for each particle.
pub(crate) trait PairSum<const N: usize>: Sync {
    /// Memory for the columns of one block.
    type Columns;

    /// The memory, without content.
    fn columns(&self) -> Self::Columns;

    /// Adds to `out` what particle `i` and its listed partners get. Has to be `#[inline(always)]`, and so has all that it
    /// calls, or it is compiled for narrow vectors alone.
    fn row(&self, i: usize, columns: &mut Self::Columns, out: &mut [[f64; N]]);
}

/// One pair after the other.
impl<const N: usize, F: Fn(usize, &mut [[f64; N]]) + Sync> PairSum<N> for F {
    type Columns = ();

    fn columns(&self) {}

    #[inline(always)]
    fn row(&self, i: usize, (): &mut (), out: &mut [[f64; N]]) {
        self(i, out);
    }
}

/// Adds to `out` what the particles of `chunk` and their partners get.
pub(crate) fn add_rows<const N: usize>(sum: &impl PairSum<N>, chunk: Range<usize>, out: &mut [[f64; N]]) {
    widest(Rows { sum, columns: sum.columns(), chunk, out });
}

struct Rows<'a, S: PairSum<N>, const N: usize> {
    sum: &'a S,
    columns: S::Columns,
    chunk: Range<usize>,
    out: &'a mut [[f64; N]],
}

impl<S: PairSum<N>, const N: usize> Work for Rows<'_, S, N> {
    #[inline(always)]
    fn run<const WIDE: bool>(mut self) {
        for i in self.chunk {
            self.sum.row(i, &mut self.columns, self.out);
        }
    }
}
