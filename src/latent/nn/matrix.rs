//! Matrices over packed weights ([`super::packing`]), read in place.

use super::kernels;
use super::packing::{PANEL, packed_len};
use crate::latent::nn::cpu_width::widest;
use crate::real::Real;
use core::num::NonZeroUsize;

/// A matrix in the blob, read in place.
///
/// ```
/// use meniscus::latent::nn::{Matrix, PANEL, packed_index};
///
/// // W = [[1, 2], [3, 4]], packed.
/// let mut packed = [0.0; 2 * PANEL];
/// for (row, column, value) in [(0, 0, 1.0), (0, 1, 2.0), (1, 0, 3.0), (1, 1, 4.0)] {
///     packed[packed_index(row, column, 2)] = value;
/// }
/// let matrix = Matrix::new(&packed, 2, 2).unwrap();
/// let mut y = [0.5, 0.5];
/// matrix.accumulate(&[1.0, -1.0], &mut y);
/// assert_eq!(y, [-0.5, -0.5]);
/// assert!(Matrix::new(&packed, 2, 3).is_none(), "the length does not fit");
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Matrix<'m> {
    /// One entry a panel and column, panel after panel.
    packed: &'m [[f32; PANEL]],
    rows: usize,
    columns: NonZeroUsize,
}

impl<'m> Matrix<'m> {
    /// A `rows` x `columns` matrix over packed numbers; `None` unless there are exactly as many as
    /// that takes, and at least one column.
    #[must_use]
    pub fn new(packed: &'m [f32], rows: usize, columns: usize) -> Option<Self> {
        let wanted = packed_len(rows, columns)?;
        let columns = NonZeroUsize::new(columns)?;
        let (packed, rest) = packed.as_chunks();
        (rest.is_empty() && packed.len().checked_mul(PANEL)? == wanted).then_some(Self {
            packed,
            rows,
            columns,
        })
    }

    /// Number of outputs.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of inputs.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.columns.get()
    }

    /// The rows from the panel of row `first` on, and how many of these lie before it.
    #[must_use]
    pub fn from_row(&self, first: usize) -> (Self, usize) {
        let first = first.min(self.rows);
        let packed =
            self.packed.get((first / PANEL).saturating_mul(self.columns.get())..).unwrap_or_default();
        let before = first % PANEL;
        (Self { packed, rows: self.rows.saturating_sub(first - before), ..*self }, before)
    }

    /// y = y + W x. Numbers of `x` beyond the columns and of `y` beyond the rows are left alone;
    /// where `x` is shorter, the rest counts as zero.
    pub fn accumulate(&self, x: &[f32], y: &mut [f32]) {
        let y = y.get_mut(..self.rows.min(y.len())).unwrap_or_default();
        widest(kernels::F32 { panels: self.packed, columns: self.columns.get(), x, y });
    }

    /// [`Self::accumulate`], quicker where many numbers of `x` are zero.
    pub fn accumulate_sparse(&self, x: &[f32], y: &mut [f32]) {
        let y = y.get_mut(..self.rows.min(y.len())).unwrap_or_default();
        let dense = kernels::F32 { panels: self.packed, columns: self.columns.get(), x, y };
        widest(kernels::Sparse(dense));
    }

    /// y = y + W x in the precision of `x`, which rounds nothing but the sums: for the energy, whose differences must not be
    /// rounding.
    pub fn accumulate_exact<R: Real>(&self, x: &[R], y: &mut [R]) {
        let y = y.get_mut(..self.rows.min(y.len())).unwrap_or_default();
        widest(kernels::Exact { panels: self.packed, columns: self.columns.get(), x, y });
    }

    /// y = y + W^T x in the precision of `x`.
    pub fn accumulate_transposed<R: Real>(&self, x: &[R], y: &mut [R]) {
        let x = x.get(..self.rows.min(x.len())).unwrap_or_default();
        widest(kernels::Transposed { panels: self.packed, columns: self.columns.get(), x, y });
    }

    /// Position of the first number that is not finite.
    #[must_use]
    pub fn not_finite(&self) -> Option<usize> {
        self.packed.as_flattened().iter().position(|w| !w.is_finite())
    }

    /// Row `row` as a vector of N numbers; zeros where the matrix has none.
    #[must_use]
    pub fn row<R: Real, const N: usize>(&self, row: usize) -> nalgebra::SVector<R, N> {
        nalgebra::SVector::from_fn(|column, _| R::from(self.at(row, column)))
    }

    /// Element (`row`, `column`), zero outside.
    #[must_use]
    pub fn at(&self, row: usize, column: usize) -> f32 {
        if column >= self.columns.get() {
            return 0.0;
        }
        let panel = (row / PANEL).saturating_mul(self.columns.get()).saturating_add(column);
        self.packed.get(panel).and_then(|entry| entry.get(row % PANEL)).copied().unwrap_or(0.0)
    }
}

/// A vector in the blob, read in place; the padding behind it is not part of it.
pub type Vector<'m> = &'m [f32];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::latent::nn::packed_index;

    /// A 40 x 3 matrix with element (i, j) = i + 100 j, so that every element is different.
    fn packed() -> [f32; 2 * 3 * PANEL] {
        let mut out = [0.0; 2 * 3 * PANEL];
        for i in 0..40 {
            for j in 0..3 {
                out[packed_index(i, j, 3)] = (i + 100 * j) as f32;
            }
        }
        out
    }

    #[test]
    fn products_agree_with_the_definition() {
        let packed = packed();
        let matrix = Matrix::new(&packed, 40, 3).expect("the length fits");
        let x = [1.0, -2.0, 0.5];
        let mut y = [1.0_f32; 41];
        matrix.accumulate(&x, &mut y);
        let mut y64 = [1.0_f64; 40];
        matrix.accumulate_exact(&x.map(f64::from), &mut y64);
        for i in 0..40 {
            let expected = 1.0 + i as f32 - 2.0 * (i + 100) as f32 + 0.5 * (i + 200) as f32;
            assert_eq!(y[i], expected);
            assert_eq!(y64[i], f64::from(expected));
        }
        assert_eq!(y[40], 1.0, "a longer output keeps its tail");
    }

    #[test]
    fn the_transposed_product_is_the_adjoint() {
        let packed = packed();
        let matrix = Matrix::new(&packed, 40, 3).expect("the length fits");
        let mut x = [0.0_f64; 40];
        x.iter_mut().enumerate().for_each(|(i, x)| *x = 1.0 / (i as f64 + 1.0));
        let z = [0.3, -0.7, 1.1];
        let (mut wz, mut wtx) = ([0.0; 40], [0.0; 3]);
        matrix.accumulate_exact(&z, &mut wz);
        matrix.accumulate_transposed(&x, &mut wtx);
        let left: f64 = x.iter().zip(wz).map(|(a, b)| a * b).sum();
        let right: f64 = z.iter().zip(wtx).map(|(a, b)| a * b).sum();
        assert!((left - right).abs() < 1e-9 * left.abs());
    }

    #[test]
    fn a_wrong_length_is_refused() {
        let packed = packed();
        assert!(Matrix::new(&packed, 40, 4).is_none());
        assert!(Matrix::new(&packed, 40, 0).is_none());
        assert!(Matrix::new(&packed[1..], 40, 3).is_none());
        assert_eq!(Matrix::new(&packed, 40, 3).expect("fits").at(33, 1), 133.0);
    }
}
