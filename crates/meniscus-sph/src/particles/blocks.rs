//! The neighbours of a particle side by side: a column for each of their numbers, so that one formula runs down the columns in
//! vectors as wide as the processor's.
//!
//! A row of the neighbour list is gathered into columns and computed. What the neighbours get is turned back into rows and added to
//! their sums; what the particle gets is the total of a column, of as many partial sums as the widest vector has. Each pair is
//! computed as it would be alone: vectors of any width give the same bits.
//!
//! The sums over pairs are formed in single precision, whose rounding (6e-8 of each term) moves frequencies, decays and effects by less than
//! 0.0003 % of theirs (`docs/validation`). What the sums change is kept in double precision: positions, velocities, densities, heat. A pair
//! gives and takes the same bits; chunks of the list are added in double precision.

use super::lanes::{Lane, Quad, Row, Single, Width, Work, widest};
use std::ops::Range;

/// Most neighbours that are computed at once; a longer row is taken in pieces.
pub(crate) const BLOCK: usize = 64;

/// A number of each neighbour.
pub(crate) type Column<T = f64> = [T; BLOCK];

/// Eight numbers of each neighbour.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Panel<T = f64>(pub(crate) [Column<T>; 8]);

/// Rows that a block has to compute for `rows` neighbours: whole vectors of sixteen.
#[inline(always)]
pub(crate) fn whole(rows: usize) -> usize {
    ((rows + 15) & !15).min(BLOCK)
}

impl<T: Lane> Panel<T> {
    /// Columns without content.
    pub(crate) fn new() -> Self {
        Self([[T::default(); BLOCK]; 8])
    }

    /// Takes the rows `at` of `table`. Rows of zeros stand in for what is missing to whole vectors.
    #[inline(always)]
    pub(crate) fn gather<W: Width>(&mut self, table: &[Row<8, T>], at: &[u32]) {
        let zeros = [T::default(); 8];
        let (eights, rest) = at.as_chunks::<8>();
        for (eight, at) in eights.iter().enumerate().take(BLOCK / 8) {
            T::transpose::<W>(at.map(|j| &table[j as usize].0), self.eight_mut(eight));
        }
        for eight in eights.len()..whole(at.len()) / 8 {
            let rest = if eight == eights.len() { rest } else { &[] };
            let from = std::array::from_fn(|k| rest.get(k).map_or(&zeros, |j| &table[*j as usize].0));
            T::transpose::<W>(from, self.eight_mut(eight));
        }
    }

    /// The columns of neighbours `8 eight` to `8 eight + 7`.
    #[inline(always)]
    pub(crate) fn eight_mut(&mut self, eight: usize) -> [&mut [T; 8]; 8] {
        self.0.each_mut().map(|column| &mut column.as_chunks_mut().0[eight])
    }

    /// Returns the rows of neighbours `8 eight` to `8 eight + 7`.
    #[inline(always)]
    fn turned<W: Width>(&self, eight: usize) -> [Row<8, T>; 8] {
        let mut out = [Row::default(); 8];
        let from = self.0.each_ref().map(|column| &column.as_chunks().0[eight]);
        T::transpose::<W>(from, out.each_mut().map(|row| &mut row.0));
        out
    }

    /// Row `k`.
    #[inline(always)]
    pub(crate) fn row<const N: usize>(&self, k: usize) -> [T; N] {
        const { assert!(N <= 8) };
        let mut row = [T::default(); N];
        for (x, column) in row.iter_mut().zip(&self.0) {
            *x = column[k];
        }
        row
    }

    /// Adds the first `rows` rows to `sum`.
    #[inline(always)]
    pub(crate) fn sum<W: Width>(&self, rows: usize, sum: &mut [T; 8]) {
        for eight in 0..rows.div_ceil(8).min(BLOCK / 8) {
            for row in self.turned::<W>(eight).iter().take(rows - 8 * eight) {
                add(sum, &row.0);
            }
        }
    }

    /// Puts `numbers` into row `k`, from column 0 on.
    #[inline(always)]
    pub(crate) fn put<const N: usize>(&mut self, k: usize, numbers: [T; N]) {
        const { assert!(N <= 8) };
        for (column, x) in self.0.iter_mut().zip(numbers) {
            column[k] = x;
        }
    }

    /// `x_i - x_j`, m, for neighbour `k`, a particle, of one at `x`.
    #[inline(always)]
    pub(crate) fn apart(&self, x: &[T; 3], k: usize) -> [T; 3] {
        [x[0] - self.0[0][k], x[1] - self.0[1][k], x[2] - self.0[2][k]]
    }

    /// `v_i - v_j`, m/s, for neighbour `k`, a particle, of one with the velocity `v`.
    #[inline(always)]
    pub(crate) fn slower(&self, v: &[T; 3], k: usize) -> [T; 3] {
        [v[0] - self.0[3][k], v[1] - self.0[4][k], v[2] - self.0[5][k]]
    }

    /// `v_j` of neighbour `k`, a particle, m/s.
    #[inline(always)]
    pub(crate) fn velocity(&self, k: usize) -> [T; 3] {
        [self.0[3][k], self.0[4][k], self.0[5][k]]
    }
}

impl Panel<f32> {
    /// Adds the rows to eight numbers of the rows `at` of `out`, the first of them `8 part`.
    #[inline(always)]
    pub(crate) fn scatter<W: Width, const N: usize>(&self, at: &[u32], out: &mut [Single<N>], part: usize) {
        for (eight, at) in at.chunks(8).enumerate().take(BLOCK / 8) {
            for (row, j) in self.turned::<W>(eight).iter().zip(at) {
                add(&mut out[*j as usize].0.as_chunks_mut().0[part], &row.0);
            }
        }
    }

    /// Adds the columns up; the rows beyond the first `rows` have to be zero.
    #[inline(always)]
    pub(crate) fn totals<W: Width>(&self, rows: usize) -> [f32; 8] {
        let mut sums = [[0.0; 8]; 8];
        // Loops, since a closure would not be compiled for wide vectors.
        for (sums, column) in sums.iter_mut().zip(&self.0) {
            *sums = eight_sums(column, rows);
        }
        let mut turned = [[0.0; 8]; 8];
        f32::transpose::<W>(sums.each_ref(), turned.each_mut());
        sum_of_eight(turned)
    }
}

/// Four numbers of each neighbour.
#[repr(C, align(64))]
pub(crate) struct Quads([Column<f32>; 4]);

impl Quads {
    /// Columns without content.
    pub(crate) fn new() -> Self {
        Self([[0.0; BLOCK]; 4])
    }

    /// Takes the rows `at` of `table`. Rows of zeros stand in for what is missing to whole vectors.
    #[inline(always)]
    pub(crate) fn gather<W: Width>(&mut self, table: &[Quad], at: &[u32]) {
        let (eights, rest) = at.as_chunks::<8>();
        for (eight, at) in eights.iter().enumerate().take(BLOCK / 8) {
            W::columns(at.map(|j| &table[j as usize].0), self.eight_mut(eight));
        }
        for eight in eights.len()..whole(at.len()) / 8 {
            let rest = if eight == eights.len() { rest } else { &[] };
            let from = std::array::from_fn(|k| rest.get(k).map_or(&[0.0; 4], |j| &table[*j as usize].0));
            W::columns(from, self.eight_mut(eight));
        }
    }

    /// The columns of neighbours `8 eight` to `8 eight + 7`.
    #[inline(always)]
    fn eight_mut(&mut self, eight: usize) -> [&mut [f32; 8]; 4] {
        self.0.each_mut().map(|column| &mut column.as_chunks_mut().0[eight])
    }

    /// The first three numbers of row `k`.
    #[inline(always)]
    pub(crate) fn three(&self, k: usize) -> [f32; 3] {
        [self.0[0][k], self.0[1][k], self.0[2][k]]
    }

    /// Puts `numbers` into row `k`, from column 0 on.
    #[inline(always)]
    pub(crate) fn put<const N: usize>(&mut self, k: usize, numbers: [f32; N]) {
        const { assert!(N <= 4) };
        for (column, x) in self.0.iter_mut().zip(numbers) {
            column[k] = x;
        }
    }

    /// Takes the rows from the rows `at` of `out`.
    #[inline(always)]
    pub(crate) fn take<W: Width>(&self, at: &[u32], out: &mut [Single<4>]) {
        for (eight, at) in at.chunks(8).enumerate().take(BLOCK / 8) {
            for (row, j) in self.turned::<W>(eight).iter().zip(at) {
                for (to, x) in out[*j as usize].0.iter_mut().zip(row.0) {
                    *to -= x;
                }
            }
        }
    }

    /// Returns the rows of neighbours `8 eight` to `8 eight + 7`.
    #[inline(always)]
    fn turned<W: Width>(&self, eight: usize) -> [Quad; 8] {
        let mut rows = [Quad::default(); 8];
        let from = self.0.each_ref().map(|column| &column.as_chunks().0[eight]);
        W::rows(from, rows.each_mut().map(|row| &mut row.0));
        rows
    }

    /// Adds the columns up; the rows beyond the first `rows` have to be zero.
    #[inline(always)]
    pub(crate) fn totals<W: Width>(&self, rows: usize) -> [f32; 4] {
        let mut sums = [[0.0; 8]; 4];
        for (sums, column) in sums.iter_mut().zip(&self.0) {
            *sums = eight_sums(column, rows);
        }
        let mut turned = [[0.0; 4]; 8];
        W::rows(sums.each_ref(), turned.each_mut());
        sum_of_eight(turned)
    }
}

/// Eight partial sums of a column, of sixteen at first, so that vectors of any width add in the same order.
#[inline(always)]
fn eight_sums(column: &Column<f32>, rows: usize) -> [f32; 8] {
    let mut sums = [0.0; 16];
    for sixteen in column.as_chunks().0.iter().take(whole(rows) / 16) {
        add::<16, f32>(&mut sums, sixteen);
    }
    let mut eight = [0.0; 8];
    for k in 0..8 {
        eight[k] = sums[k] + sums[k + 8];
    }
    eight
}

/// Sum of eight rows.
#[inline(always)]
fn sum_of_eight<const N: usize>([a, b, c, d, e, f, g, h]: [[f32; N]; 8]) -> [f32; N] {
    let mut sum = [0.0; N];
    for k in 0..N {
        sum[k] = ((a[k] + e[k]) + (c[k] + g[k])) + ((b[k] + f[k]) + (d[k] + h[k]));
    }
    sum
}

/// Column of the volume of a particle.
pub(crate) const VOLUME: usize = 6;

/// Column of its pressure, or of what stands in for that.
pub(crate) const LAST: usize = 7;

/// The particle whose neighbours are computed, in single precision as they are.
pub(crate) struct Own {
    /// Position, m.
    pub(crate) x: [f32; 3],
    /// Velocity, m/s.
    pub(crate) v: [f32; 3],
    /// Volume, m3.
    pub(crate) volume: f32,
    /// The last number of its row: its pressure, Pa, or what stands in for that.
    pub(crate) last: f32,
}

impl Own {
    /// Reads a row.
    #[inline(always)]
    pub(crate) fn new(row: &Single<8>) -> Self {
        let [x, y, z, u, v, w, volume, last] = row.0;
        Self { x: [x, y, z], v: [u, v, w], volume, last }
    }
}

/// `a.b`.
#[inline(always)]
pub(crate) fn dot<T: Lane>(a: &[T; 3], b: &[T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `to += numbers`.
#[inline(always)]
pub(crate) fn add<const N: usize, T: Lane>(to: &mut [T; N], numbers: &[T; N]) {
    for (to, x) in to.iter_mut().zip(numbers) {
        *to += *x;
    }
}

/// A sum over the pairs of [`super::neighbours`], `N` numbers for each particle.
pub(crate) trait PairSum<const N: usize, T: Lane = f32>: Sync {
    /// Memory for the columns of one block.
    type Columns;

    /// The memory, without content.
    fn columns(&self) -> Self::Columns;

    /// Adds to `out` what particle `i` and its listed partners get. Has to be `#[inline(always)]`, and so has all that it
    /// calls, or it is compiled for narrow vectors alone.
    fn row<W: Width>(&self, i: usize, columns: &mut Self::Columns, out: &mut [Row<N, T>]);
}

/// One pair after the other, in double precision.
impl<const N: usize, F: Fn(usize, &mut [Row<N>]) + Sync> PairSum<N, f64> for F {
    type Columns = ();

    fn columns(&self) {}

    #[inline(always)]
    fn row<W: Width>(&self, i: usize, (): &mut (), out: &mut [Row<N>]) {
        self(i, out);
    }
}

/// Adds to `out` what the particles of `chunk` and their partners get.
pub(crate) fn add_rows<const N: usize, T: Lane>(
    sum: &impl PairSum<N, T>,
    chunk: Range<usize>,
    out: &mut [Row<N, T>],
) {
    widest(Chunk { sum, columns: sum.columns(), chunk, out });
}

struct Chunk<'a, S: PairSum<N, T>, T: Lane, const N: usize> {
    sum: &'a S,
    columns: S::Columns,
    chunk: Range<usize>,
    out: &'a mut [Row<N, T>],
}

impl<S: PairSum<N, T>, T: Lane, const N: usize> Work for Chunk<'_, S, T, N> {
    #[inline(always)]
    fn run<W: Width>(mut self) {
        for i in self.chunk {
            self.sum.row::<W>(i, &mut self.columns, self.out);
        }
    }
}
