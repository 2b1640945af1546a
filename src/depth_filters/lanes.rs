//! Rows side by side: element `x` of [`LANES`] rows in one array, so that a sweep along the rows is a
//! sweep over arrays.

/// Rows that are swept at once.
pub const LANES: usize = 16;

/// Lays rows of `width` side by side; lanes without a row keep what they had.
pub(super) fn gather<T: Copy>(rows: &[T], width: usize, columns: &mut [[T; LANES]]) {
    for (lane, row) in super::rows(rows, width).enumerate().take(LANES) {
        for (column, &pixel) in columns.iter_mut().zip(row) {
            if let Some(place) = column.get_mut(lane) {
                *place = pixel;
            }
        }
    }
}

/// Puts them back.
pub(super) fn scatter<T: Copy>(columns: &[[T; LANES]], width: usize, rows: &mut [T]) {
    for (lane, row) in super::rows_mut(rows, width).enumerate().take(LANES) {
        for (column, pixel) in columns.iter().zip(row) {
            if let Some(&value) = column.get(lane) {
                *pixel = value;
            }
        }
    }
}

/// Two neighbouring rows, the first to read and the second to change; `second` is the index of the
/// latter and `first` that of the former, which lies directly before or behind it.
pub(super) fn pair<T>(
    image: &mut [T],
    width: usize,
    first: usize,
    second: usize,
) -> Option<(&[T], &mut [T])> {
    let middle = first.max(second).saturating_mul(width);
    let (before, behind) = image.split_at_mut_checked(middle)?;
    let above = before.get_mut(middle.checked_sub(width)?..)?;
    let below = behind.get_mut(..width)?;
    Some(if first < second { (above, below) } else { (below, above) })
}
