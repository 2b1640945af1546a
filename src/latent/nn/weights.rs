//! A matrix whose weights may be stored coarser than f32, read in place.
//!
//! All three lie in panels of 32 rows, column after column, rows padded with zeros:
//!
//! ```text
//! f32    number ((i / 32) C + j) 32 + i mod 32
//! bf16   number ((i / 32) C + j) 32 + 2 (i mod 16) + (i mod 32) / 16
//! i8     as f32, behind one f32 scale a row (rows padded to a multiple of 32)
//! ```

use super::kernels::{self, HALF};
use super::matrix::Matrix;
use super::packing::{PANEL, packed_len};
use crate::latent::nn::cpu_width::widest;
use crate::latent::nn::dtype::{Element, f32_of};
use crate::latent::nn::int8::Bytes;

/// Returns the index of element (`row`, `column`) of a bf16 matrix.
///
/// ```
/// use meniscus::latent::nn::bf16_index;
///
/// // Rows 0 and 16 share a 32-bit word.
/// assert_eq!((bf16_index(0, 0, 1), bf16_index(16, 0, 1), bf16_index(1, 0, 1)), (0, 1, 2));
/// ```
#[must_use]
pub const fn bf16_index(row: usize, column: usize, columns: usize) -> usize {
    ((row / PANEL) * columns + column) * PANEL + 2 * (row % HALF) + (row % PANEL) / HALF
}

/// Bytes that a matrix occupies in a blob; `None` on overflow.
///
/// ```
/// use meniscus::latent::nn::{Element, section_len};
///
/// assert_eq!(section_len(Element::F32, 40, 3), Some(768));
/// assert_eq!(section_len(Element::Bf16, 40, 3), Some(384));
/// // A byte a weight and an f32 scale a row, both padded to 64 rows.
/// assert_eq!(section_len(Element::I8, 40, 3), Some(64 * 4 + 192));
/// ```
#[must_use]
pub fn section_len(element: Element, rows: usize, columns: usize) -> Option<usize> {
    let numbers = packed_len(rows, columns)?;
    match element {
        Element::F32 => numbers.checked_mul(4),
        Element::Bf16 => numbers.checked_mul(2),
        Element::I8 => packed_len(rows, 1)?.checked_mul(4)?.checked_add(numbers),
    }
}

/// A matrix in the blob, in one of the elements.
///
/// ```
/// use meniscus::latent::nn::{Element, Weights, bf16_index, bf16_of};
///
/// // W = (1.5, -2) in bf16, on a boundary of four bytes.
/// #[repr(align(4))]
/// struct Aligned([u8; 128]);
/// let mut bytes = Aligned([0; 128]);
/// for (column, value) in [1.5, -2.0].into_iter().enumerate() {
///     let at = 2 * bf16_index(0, column, 2);
///     bytes.0[at..at + 2].copy_from_slice(&bf16_of(value).to_le_bytes());
/// }
/// let weights = Weights::new(Element::Bf16, &bytes.0, 1, 2).unwrap();
/// let mut y = [0.0];
/// weights.accumulate(&[2.0, 1.0], &mut y);
/// assert_eq!((y, weights.at(0, 1)), ([1.0], -2.0));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Weights<'m> {
    stored: Stored<'m>,
    rows: usize,
    columns: usize,
}

#[derive(Clone, Copy, Debug)]
enum Stored<'m> {
    F32(Matrix<'m>),
    Bf16(&'m [[u32; HALF]]),
    I8(&'m [[f32; PANEL]], &'m [[i8; PANEL]]),
}

impl<'m> From<Matrix<'m>> for Weights<'m> {
    fn from(matrix: Matrix<'m>) -> Self {
        Self { stored: Stored::F32(matrix), rows: matrix.rows(), columns: matrix.columns() }
    }
}

impl<'m> Weights<'m> {
    /// A matrix over the bytes of a section; `None` unless there are exactly as many as it takes, on a boundary
    /// of four bytes, and there is at least one column.
    #[must_use]
    pub fn new(element: Element, bytes: &'m [u8], rows: usize, columns: usize) -> Option<Self> {
        if columns == 0 || bytes.len() != section_len(element, rows, columns)? {
            return None;
        }
        let stored = match element {
            Element::F32 => {
                return Matrix::new(bytemuck::try_cast_slice(bytes).ok()?, rows, columns).map(Self::from);
            }
            Element::Bf16 => Stored::Bf16(bytemuck::try_cast_slice::<u8, u32>(bytes).ok()?.as_chunks().0),
            Element::I8 => {
                let (scales, packed) = bytes.split_at_checked(packed_len(rows, 1)?.checked_mul(4)?)?;
                let scales = bytemuck::try_cast_slice::<u8, f32>(scales).ok()?;
                Stored::I8(
                    scales.as_chunks().0,
                    bytemuck::try_cast_slice::<u8, i8>(packed).ok()?.as_chunks().0,
                )
            }
        };
        Some(Self { stored, rows, columns })
    }

    /// Returns the storage format of the weights.
    #[must_use]
    pub fn element(&self) -> Element {
        match self.stored {
            Stored::F32(_) => Element::F32,
            Stored::Bf16(_) => Element::Bf16,
            Stored::I8(..) => Element::I8,
        }
    }

    /// Number of outputs.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of inputs.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// The rows from the panel of row `first` on, and how many of these lie before it.
    #[must_use]
    pub fn from_row(&self, first: usize) -> (Self, usize) {
        let first = first.min(self.rows);
        let (panel, before) = (first / PANEL, first % PANEL);
        let skipped = panel.saturating_mul(self.columns);
        let stored = match self.stored {
            Stored::F32(matrix) => Stored::F32(matrix.from_row(first).0),
            Stored::Bf16(panels) => Stored::Bf16(panels.get(skipped..).unwrap_or_default()),
            Stored::I8(scales, panels) => {
                Stored::I8(scales.get(panel..).unwrap_or_default(), panels.get(skipped..).unwrap_or_default())
            }
        };
        (Self { stored, rows: self.rows.saturating_sub(first - before), ..*self }, before)
    }

    /// y = y + W x. Numbers of `x` beyond the columns and of `y` beyond the rows are left alone;
    /// where `x` is shorter, the rest counts as zero.
    pub fn accumulate(&self, x: &[f32], y: &mut [f32]) {
        let columns = self.columns;
        let rows = self.rows.min(y.len());
        let y = y.get_mut(..rows).unwrap_or_default();
        match self.stored {
            Stored::F32(matrix) => matrix.accumulate(x, y),
            Stored::Bf16(panels) => widest(kernels::Bf16 { panels, columns, x, y }),
            Stored::I8(scales, panels) => Bytes { panels, scales, columns }.accumulate(x, y),
        }
    }

    /// [`Self::accumulate`], quicker where many numbers of `x` are zero and the weights are f32.
    pub fn accumulate_sparse(&self, x: &[f32], y: &mut [f32]) {
        match self.stored {
            Stored::F32(matrix) => matrix.accumulate_sparse(x, y),
            Stored::Bf16(_) | Stored::I8(..) => self.accumulate(x, y),
        }
    }

    /// Element (`row`, `column`) as a number, zero outside.
    #[must_use]
    pub fn at(&self, row: usize, column: usize) -> f32 {
        if column >= self.columns {
            return 0.0;
        }
        let panel = (row / PANEL).saturating_mul(self.columns).saturating_add(column);
        let place = row % PANEL;
        match self.stored {
            Stored::F32(matrix) => matrix.at(row, column),
            Stored::Bf16(panels) => {
                let word = panels.get(panel).and_then(|entry| entry.get(place % HALF)).copied().unwrap_or(0);
                f32_of(if place < HALF { word as u16 } else { (word >> 16) as u16 })
            }
            Stored::I8(scales, panels) => {
                let scale = scales.as_flattened().get(row).copied().unwrap_or(0.0);
                let k = panels.get(panel).and_then(|entry| entry.get(place)).copied().unwrap_or(0);
                scale * f32::from(k)
            }
        }
    }

    /// Position of the first stored number that is not finite. A byte always is one; its scale may not be.
    #[must_use]
    pub fn not_finite(&self) -> Option<usize> {
        match self.stored {
            Stored::F32(matrix) => matrix.not_finite(),
            Stored::Bf16(panels) => {
                let halves = panels.as_flattened().iter().flat_map(|w| [*w as u16, (*w >> 16) as u16]);
                halves.into_iter().position(|half| !f32_of(half).is_finite())
            }
            Stored::I8(scales, _) => scales.as_flattened().iter().position(|scale| !scale.is_finite()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::latent::nn::{bf16_of, packed_index};

    const ROWS: usize = 40;
    const COLUMNS: usize = 3;

    /// Element (i, j), the same in all three elements.
    fn weight(i: usize, j: usize) -> f32 {
        (i as f32 - 20.0) * 0.5 + j as f32 * 16.0
    }

    fn bytes(element: Element) -> heapless::Vec<u8, 2048> {
        let mut bytes: heapless::Vec<u8, 2048> = heapless::Vec::new();
        bytes.resize(section_len(element, ROWS, COLUMNS).expect("small"), 0).expect("room");
        for i in 0..ROWS {
            for j in 0..COLUMNS {
                match element {
                    Element::F32 => {
                        let at = 4 * packed_index(i, j, COLUMNS);
                        bytes[at..at + 4].copy_from_slice(&weight(i, j).to_le_bytes());
                    }
                    Element::Bf16 => {
                        let at = 2 * bf16_index(i, j, COLUMNS);
                        bytes[at..at + 2].copy_from_slice(&bf16_of(weight(i, j)).to_le_bytes());
                    }
                    Element::I8 => {
                        bytes[4 * i..4 * i + 4].copy_from_slice(&0.5_f32.to_le_bytes());
                        bytes[4 * 64 + packed_index(i, j, COLUMNS)] = ((2.0 * weight(i, j)) as i8) as u8;
                    }
                }
            }
        }
        bytes
    }

    /// A place on the boundary that a blob has.
    #[repr(align(64))]
    struct Aligned([u8; 2048]);

    #[test]
    fn every_element_gives_the_product_and_the_entries() {
        for element in [Element::F32, Element::Bf16, Element::I8] {
            let packed = bytes(element);
            let mut place = Aligned([0; 2048]);
            place.0[..packed.len()].copy_from_slice(&packed);
            let bytes = &place.0[..packed.len()];
            let weights = Weights::new(element, bytes, ROWS, COLUMNS).expect("the length fits");
            assert_eq!(weights.element(), element);
            let x = [1.0, -0.5, 0.25];
            let mut y = [1.0_f32; ROWS + 1];
            weights.accumulate(&x, &mut y);
            for (i, said) in y.iter().enumerate().take(ROWS) {
                let due = 1.0 + weight(i, 0) - 0.5 * weight(i, 1) + 0.25 * weight(i, 2);
                // Beside bytes x is rounded to a step of its largest number, which is 1 here, over 32767.
                let size: f32 = (0..COLUMNS).map(|j| weight(i, j).abs()).sum();
                let lost = if element == Element::I8 { size / 65_534.0 } else { 0.0 };
                assert!((said - due).abs() < 1e-5 + lost, "{element} row {i}: {said} for {due}");
                (0..COLUMNS).for_each(|j| assert_eq!(weights.at(i, j), weight(i, j), "{element} {i} {j}"));
            }
            assert_eq!(y[ROWS], 1.0, "a longer output keeps its tail");
            assert_eq!((weights.at(ROWS + 40, 0), weights.at(0, COLUMNS)), (0.0, 0.0));
            assert!(Weights::new(element, &bytes[1..], ROWS, COLUMNS).is_none());
            assert!(Weights::new(element, bytes, ROWS, COLUMNS + 1).is_none());
            assert!(weights.not_finite().is_none());
        }
    }

    #[test]
    fn what_is_not_a_number_is_found() {
        let mut place = Aligned([0; 2048]);
        place.0[2 * bf16_index(33, 1, COLUMNS)..][..2].copy_from_slice(&0x7FC0_u16.to_le_bytes());
        let length = section_len(Element::Bf16, ROWS, COLUMNS).expect("small");
        let weights = Weights::new(Element::Bf16, &place.0[..length], ROWS, COLUMNS).expect("fits");
        assert_eq!(weights.not_finite(), Some(bf16_index(33, 1, COLUMNS)));
        let mut place = Aligned([0; 2048]);
        place.0[4 * 7..4 * 8].copy_from_slice(&f32::INFINITY.to_le_bytes());
        let length = section_len(Element::I8, ROWS, COLUMNS).expect("small");
        let weights = Weights::new(Element::I8, &place.0[..length], ROWS, COLUMNS).expect("fits");
        assert_eq!(weights.not_finite(), Some(7));
    }
}
