//! Packing of a matrix in panels of [`PANEL`] rows, so that one pass over the input fills a panel of
//! outputs held in registers and the weights stream through once, in order.
//!
//! Element (i, j) of a matrix with `columns` columns lies at [`packed_index`]; rows are padded with
//! zeros to a whole panel. A vector is a matrix of one column: its elements lie one after another.

/// Rows of a panel: eight SSE, four AVX2 or two AVX-512 registers of accumulators.
pub const PANEL: usize = 32;

/// Returns the index of element (`row`, `column`) of a packed matrix.
///
/// ```
/// use meniscus::latent::nn::packed_index;
///
/// // Rows 0 to 31 of column 0 come first, then those of column 1; row 32 opens the next panel.
/// assert_eq!(packed_index(3, 1, 2), 35);
/// assert_eq!(packed_index(32, 0, 2), 64);
/// ```
#[must_use]
pub const fn packed_index(row: usize, column: usize, columns: usize) -> usize {
    ((row / PANEL) * columns + column) * PANEL + row % PANEL
}

/// Numbers that a packed matrix occupies, padding included; `None` on overflow.
///
/// ```
/// use meniscus::latent::nn::packed_len;
///
/// assert_eq!(packed_len(40, 3), Some(2 * 3 * 32));
/// assert_eq!(packed_len(usize::MAX, usize::MAX), None);
/// ```
#[must_use]
pub const fn packed_len(rows: usize, columns: usize) -> Option<usize> {
    match rows.div_ceil(PANEL).checked_mul(columns) {
        Some(panels) => panels.checked_mul(PANEL),
        None => None,
    }
}
