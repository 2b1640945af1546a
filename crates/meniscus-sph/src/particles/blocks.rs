//! The neighbours of a particle side by side: a column for each of their numbers, so that one formula runs down the columns in
//! vectors as wide as the processor's.
//!
//! A row of the neighbour list is gathered into columns, computed, and turned back into rows that are added to the sums. Each
//! pair is computed as it would be alone, and what a particle gets is added in the order of its list: vectors of any width give
//! the same bits.

use super::lanes::{Quad, Row, Width, Work, rows, widest};
use super::state::Particle;
use std::ops::Range;

/// Most neighbours that are computed at once; a longer row is taken in pieces.
pub(crate) const BLOCK: usize = 64;

/// A number of each neighbour.
pub(crate) type Column = [f64; BLOCK];

/// Eight numbers of each neighbour.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Panel(pub(crate) [Column; 8]);

/// Rows that a block has to compute for `rows` neighbours: whole vectors of eight.
#[inline(always)]
pub(crate) fn whole(rows: usize) -> usize {
    ((rows + 7) & !7).min(BLOCK)
}

impl Panel {
    /// Columns without content.
    pub(crate) fn new() -> Self {
        Self([[0.0; BLOCK]; 8])
    }

    /// Takes the rows `at` of `table`. The last of them stands in for what is missing to whole vectors.
    #[inline(always)]
    pub(crate) fn gather<W: Width>(&mut self, table: &[Row<8>], at: &[u32]) {
        for (eight, at) in at.chunks(8).enumerate().take(BLOCK / 8) {
            let last = at.len() - 1;
            let from = std::array::from_fn(|k| &table[at[k.min(last)] as usize].0);
            W::transpose(from, self.eight_mut(eight));
        }
    }

    /// The columns of neighbours `8 eight` to `8 eight + 7`.
    #[inline(always)]
    pub(crate) fn eight_mut(&mut self, eight: usize) -> [&mut [f64; 8]; 8] {
        self.0.each_mut().map(|column| &mut column.as_chunks_mut().0[eight])
    }

    /// Returns the rows of neighbours `8 eight` to `8 eight + 7`.
    #[inline(always)]
    fn turned<W: Width>(&self, eight: usize) -> [Row<8>; 8] {
        let mut out = [Row([0.0; 8]); 8];
        let from = self.0.each_ref().map(|column| &column.as_chunks().0[eight]);
        W::transpose(from, out.each_mut().map(|row| &mut row.0));
        out
    }

    /// Row `k`.
    #[inline(always)]
    pub(crate) fn row<const N: usize>(&self, k: usize) -> [f64; N] {
        const { assert!(N <= 8) };
        let mut row = [0.0; N];
        for (x, column) in row.iter_mut().zip(&self.0) {
            *x = column[k];
        }
        row
    }

    /// Puts `numbers` into row `k`, from column 0 on.
    #[inline(always)]
    pub(crate) fn put<const N: usize>(&mut self, k: usize, numbers: [f64; N]) {
        const { assert!(N <= 8) };
        for (column, x) in self.0.iter_mut().zip(numbers) {
            column[k] = x;
        }
    }

    /// `x_i - x_j`, m, for neighbour `k`, a particle, of one at `x`.
    #[inline(always)]
    pub(crate) fn apart(&self, x: &[f64; 3], k: usize) -> [f64; 3] {
        [x[0] - self.0[0][k], x[1] - self.0[1][k], x[2] - self.0[2][k]]
    }

    /// `v_i - v_j`, m/s, for neighbour `k`, a particle, of one with the velocity `v`.
    #[inline(always)]
    pub(crate) fn slower(&self, v: &[f64; 3], k: usize) -> [f64; 3] {
        [v[0] - self.0[3][k], v[1] - self.0[4][k], v[2] - self.0[5][k]]
    }

    /// `v_j` of neighbour `k`, a particle, m/s.
    #[inline(always)]
    pub(crate) fn velocity(&self, k: usize) -> [f64; 3] {
        [self.0[3][k], self.0[4][k], self.0[5][k]]
    }

    /// Takes the particles `at` of `others`: position (3), velocity (3), volume, pressure.
    #[inline(always)]
    pub(crate) fn gather_particles<W: Width>(&mut self, others: &[Particle], at: &[u32]) {
        self.gather::<W>(rows(others), at);
    }
}

/// Four numbers of each neighbour.
#[repr(C, align(64))]
pub(crate) struct Quads([Column; 4]);

impl Quads {
    /// Columns without content.
    pub(crate) fn new() -> Self {
        Self([[0.0; BLOCK]; 4])
    }

    /// Puts `numbers` into row `k`.
    #[inline(always)]
    pub(crate) fn put(&mut self, k: usize, numbers: [f64; 4]) {
        for (column, x) in self.0.iter_mut().zip(numbers) {
            column[k] = x;
        }
    }

    /// Returns rows `8 eight` to `8 eight + 7`.
    #[inline(always)]
    fn turned<W: Width>(&self, eight: usize) -> [Quad; 8] {
        let mut out = [Quad([0.0; 4]); 8];
        let from = self.0.each_ref().map(|column| &column.as_chunks().0[eight]);
        W::rows(from, out.each_mut().map(|row| &mut row.0));
        out
    }

    /// Takes the rows from the rows `at` of `out`, and adds them to `sum`.
    #[inline(always)]
    pub(crate) fn exchange<W: Width>(&self, at: &[u32], out: &mut [Row<4>], sum: &mut [f64; 4]) {
        for (eight, at) in at.chunks(8).enumerate().take(BLOCK / 8) {
            let rows = self.turned::<W>(eight);
            for (row, j) in rows.iter().zip(at) {
                out[*j as usize].0.iter_mut().zip(row.0).for_each(|(to, x)| *to -= x);
                add(sum, &row.0);
            }
        }
    }

    /// Adds the first `rows` rows to `sum`.
    #[inline(always)]
    pub(crate) fn sum<W: Width>(&self, rows: usize, sum: &mut [f64; 4]) {
        for eight in 0..rows.div_ceil(8).min(BLOCK / 8) {
            for row in self.turned::<W>(eight).iter().take(rows - 8 * eight) {
                add(sum, &row.0);
            }
        }
    }
}

/// Column of the volume of a particle.
pub(crate) const VOLUME: usize = 6;

/// Column of its pressure.
pub(crate) const PRESSURE: usize = 7;

/// Adds the rows of `panel` to the rows `at` of `out` and to `sum`.
#[inline(always)]
pub(crate) fn exchange<W: Width>(panel: &Panel, at: &[u32], out: &mut [Row<8>], sum: &mut [f64; 8]) {
    for (eight, at) in at.chunks(8).enumerate().take(BLOCK / 8) {
        let rows = panel.turned::<W>(eight);
        for (row, j) in rows.iter().zip(at) {
            add(&mut out[*j as usize].0, &row.0);
            add(sum, &row.0);
        }
    }
}

/// Adds the rows of `panel` to eight numbers of the rows `at` of `out`, the first of them `8 part`.
#[inline(always)]
pub(crate) fn scatter<W: Width, const N: usize>(panel: &Panel, at: &[u32], out: &mut [Row<N>], part: usize) {
    for (eight, at) in at.chunks(8).enumerate().take(BLOCK / 8) {
        let rows = panel.turned::<W>(eight);
        for (row, j) in rows.iter().zip(at) {
            add(&mut out[*j as usize].0.as_chunks_mut().0[part], &row.0);
        }
    }
}

/// Adds the first `rows` rows of `panel` to `sum`.
#[inline(always)]
pub(crate) fn sum<W: Width>(panel: &Panel, rows: usize, sum: &mut [f64; 8]) {
    for eight in 0..rows.div_ceil(8).min(BLOCK / 8) {
        for row in panel.turned::<W>(eight).iter().take(rows - 8 * eight) {
            add(sum, &row.0);
        }
    }
}

/// `a.b`.
#[inline(always)]
pub(crate) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
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
    fn row<W: Width>(&self, i: usize, columns: &mut Self::Columns, out: &mut [Row<N>]);
}

/// One pair after the other.
impl<const N: usize, F: Fn(usize, &mut [Row<N>]) + Sync> PairSum<N> for F {
    type Columns = ();

    fn columns(&self) {}

    #[inline(always)]
    fn row<W: Width>(&self, i: usize, (): &mut (), out: &mut [Row<N>]) {
        self(i, out);
    }
}

/// Adds to `out` what the particles of `chunk` and their partners get.
pub(crate) fn add_rows<const N: usize>(sum: &impl PairSum<N>, chunk: Range<usize>, out: &mut [Row<N>]) {
    widest(Chunk { sum, columns: sum.columns(), chunk, out });
}

struct Chunk<'a, S: PairSum<N>, const N: usize> {
    sum: &'a S,
    columns: S::Columns,
    chunk: Range<usize>,
    out: &'a mut [Row<N>],
}

impl<S: PairSum<N>, const N: usize> Work for Chunk<'_, S, N> {
    #[inline(always)]
    fn run<W: Width>(mut self) {
        for i in self.chunk {
            self.sum.row::<W>(i, &mut self.columns, self.out);
        }
    }
}
