//! Decimation: one pixel for `k` by `k` of them, holes left out.
//!
//! `k` = 2, 3: the median of the valid pixels, the lower middle of an even count; otherwise their mean,
//! truncated. No valid pixel gives a hole. Width and height are `w / k` and `h / k`, rounded down, then padded
//! with holes to multiples of four; intrinsics are divided by `k`.
//! Source: librealsense 2.56.5, decimation filter, as measured.

use super::{SizeError, check, rows, rows_mut};

/// Most pixels of which a median is taken.
const MEDIAN: usize = 9;

/// A factor and the image it belongs to.
///
/// ```
/// use meniscus::depth_filters::Decimation;
///
/// // 213 x 160 blocks, padded to multiples of four.
/// assert_eq!(Decimation::new(3, (640, 480)).output_size(), (216, 160));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decimation {
    factor: usize,
    size: (usize, usize),
}

impl Decimation {
    /// For images of `size` (width, height) by a `factor` of 1 to 8; outside of that it is brought inside.
    #[must_use]
    pub fn new(factor: usize, size: (usize, usize)) -> Self {
        Self { factor: factor.clamp(1, 8), size }
    }

    /// Width and height that come out.
    #[must_use]
    pub fn output_size(&self) -> (usize, usize) {
        let side = |length: usize| length.checked_div(self.factor).unwrap_or(0).saturating_add(3) / 4 * 4;
        (side(self.size.0), side(self.size.1))
    }
}

/// Writes the smaller image to `out`.
///
/// ```
/// use meniscus::depth_filters::{Decimation, decimate};
///
/// let settings = Decimation::new(2, (2, 2));
/// let mut out = [0; 16];
/// // The median of the valid pixels, the lower middle of an even count; the rest is padding.
/// decimate(settings, &[900, 0, 910, 905], &mut out)?;
/// assert_eq!((out[0], out[1]), (905, 0));
/// # Ok::<(), meniscus::depth_filters::SizeError>(())
/// ```
///
/// # Errors
/// [`SizeError`] if an image has not its size; nothing is changed then.
pub fn decimate(settings: Decimation, image: &[u16], out: &mut [u16]) -> Result<(), SizeError> {
    let Decimation { factor: k, size: (width, height) } = settings;
    let (small, tall) = settings.output_size();
    check("image", image.len(), width.saturating_mul(height), false)?;
    check("output", out.len(), small.saturating_mul(tall), false)?;
    out.fill(0);
    let bands = image.chunks_exact(width.saturating_mul(k).max(1));
    for (row, band) in rows_mut(out, small).zip(bands) {
        for (index, pixel) in row.iter_mut().enumerate().take(width / k.max(1)) {
            let start = index.saturating_mul(k);
            let block =
                rows(band, width).flat_map(|line| line.get(start..start.saturating_add(k)).unwrap_or(&[]));
            let valid = block.copied().filter(|&z| z != 0);
            *pixel = if k == 2 || k == 3 { median(valid) } else { mean(valid) };
        }
    }
    Ok(())
}

/// The lower middle of at most nine values: the one with at most `(n - 1) / 2` smaller ones, and more than that
/// not larger.
fn median(values: impl Iterator<Item = u16>) -> u16 {
    let values: heapless::Vec<u16, MEDIAN> = values.take(MEDIAN).collect();
    let rank = values.len().saturating_sub(1) / 2;
    let count = |keep: &dyn Fn(u16) -> bool| values.iter().filter(|&&value| keep(value)).count();
    let middle = |value: &u16| count(&|x| x < *value) <= rank && count(&|x| x <= *value) > rank;
    values.iter().copied().find(|value| middle(value)).unwrap_or(0)
}

fn mean(values: impl Iterator<Item = u16>) -> u16 {
    let (sum, count) = values.fold((0_u32, 0_u32), |(sum, n), z| (sum + u32::from(z), n + 1));
    sum.checked_div(count).unwrap_or(0) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_leave_holes_out_and_sides_are_padded() {
        // 6 x 5 by 4: one block, padded to 4 x 4.
        let mut image = [0_u16; 30];
        (image[0], image[7], image[21]) = (10, 11, 13);
        let settings = Decimation::new(4, (6, 5));
        assert_eq!(settings.output_size(), (4, 4));
        let mut out = [7; 16];
        decimate(settings, &image, &mut out).expect("sizes fit");
        assert_eq!((out[0], out[1..].iter().all(|&z| z == 0)), (34 / 3, true));
    }

    #[test]
    fn medians_take_the_lower_middle() {
        assert_eq!(median([9, 1, 5, 3].into_iter()), 3);
        assert_eq!(median([9, 1, 5].into_iter()), 5);
        assert_eq!(median([].into_iter()), 0);
    }
}
