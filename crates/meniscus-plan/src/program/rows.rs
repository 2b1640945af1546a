//! A sparse matrix in the making, with its right-hand side.

use clarabel::algebra::CscMatrix;

/// Columns of a matrix in the making, and its right-hand side.
pub(super) struct Rows {
    columns: Vec<Vec<(usize, f64)>>,
    bound: Vec<f64>,
}

impl Rows {
    /// No rows over so many columns.
    pub(super) fn new(columns: usize) -> Self {
        Self { columns: vec![Vec::new(); columns], bound: Vec::new() }
    }

    /// Adds the row `sum of entries <= bound`.
    pub(super) fn push(&mut self, entries: impl Iterator<Item = (usize, f64)>, bound: f64) {
        for (column, value) in entries.filter(|(_, value)| *value != 0.0) {
            self.columns[column].push((self.bound.len(), value));
        }
        self.bound.push(bound);
    }

    /// Number of rows.
    pub(super) fn count(&self) -> usize {
        self.bound.len()
    }

    /// The matrix, and the right-hand side.
    pub(super) fn matrix(self) -> (CscMatrix<f64>, Vec<f64>) {
        (compressed(self.bound.len(), self.columns), self.bound)
    }
}

/// Returns the matrix of `rows` rows with these entries by column, each a row, ascending, and a value.
pub(super) fn compressed(rows: usize, by_column: Vec<Vec<(usize, f64)>>) -> CscMatrix<f64> {
    let columns = by_column.len();
    let mut starts = vec![0];
    let (mut places, mut values) = (Vec::new(), Vec::new());
    for column in by_column {
        for (row, value) in column {
            places.push(row);
            values.push(value);
        }
        starts.push(places.len());
    }
    CscMatrix::new(rows, columns, starts, places, values)
}
