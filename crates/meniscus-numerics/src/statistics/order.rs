//! Order statistics: every result is a value of the sample, none is interpolated.

use std::cmp::Ordering;

/// A number with a total order, in which values that are not a number stand at the ends.
pub trait Ordered: Copy {
    /// Returns the place of `self` beside `other`.
    fn order(&self, other: &Self) -> Ordering;
}

impl Ordered for f64 {
    fn order(&self, other: &Self) -> Ordering {
        self.total_cmp(other)
    }
}

impl Ordered for f32 {
    fn order(&self, other: &Self) -> Ordering {
        self.total_cmp(other)
    }
}

impl Ordered for u64 {
    fn order(&self, other: &Self) -> Ordering {
        self.cmp(other)
    }
}

/// Returns the upper median, `x_(n/2)` of the sorted sample counted from zero, or `None` for an empty sample. For an even
/// count it is the larger of the two middle values, so that it is always one that was measured.
///
/// ```
/// use meniscus_numerics::statistics::median;
///
/// assert_eq!(median([5.0, 1.0, 3.0]), Some(3.0));
/// assert_eq!(median([5.0, 1.0]), Some(5.0));
/// assert_eq!(median::<f64>([]), None);
/// ```
#[must_use]
pub fn median<T: Ordered>(values: impl IntoIterator<Item = T>) -> Option<T> {
    let values: Vec<T> = values.into_iter().collect();
    let index = values.len() / 2;
    ranked(values, index)
}

/// Returns the smallest value that a share `share` of the sample does not exceed, or `None` for an empty sample.
///
/// ```text
/// Q(p) = x_(ceil(p n)),      counted from one           (Hyndman and Fan 1996, definition 1)
/// ```
///
/// ```
/// use meniscus_numerics::statistics::quantile;
///
/// assert_eq!(quantile((1..=100_u64).rev(), 0.9), Some(90));
/// assert_eq!(quantile((1..=100_u64).rev(), 1.0), Some(100));
/// ```
#[must_use]
pub fn quantile<T: Ordered>(values: impl IntoIterator<Item = T>, share: f64) -> Option<T> {
    let values: Vec<T> = values.into_iter().collect();
    let rank = (values.len() as f64 * share).ceil() as usize;
    let index = rank.clamp(1, values.len().max(1)) - 1;
    ranked(values, index)
}

/// Returns the value with `index` smaller ones before it.
fn ranked<T: Ordered>(mut values: Vec<T>, index: usize) -> Option<T> {
    if index >= values.len() {
        return None;
    }
    let (_, value, _) = values.select_nth_unstable_by(index, T::order);
    Some(*value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_statistics_are_those_of_the_sorted_sample() {
        // python3 -c "import numpy as n; x = [3, 8, 1, 9, 4, 7, 2]; print(n.quantile(x, [.1, .5, .9],
        // method='inverted_cdf'), n.sort(x)[len(x) // 2])"
        let sample = [3.0, 8.0, 1.0, 9.0, 4.0, 7.0, 2.0];
        assert_eq!([0.1, 0.5, 0.9].map(|p| quantile(sample, p)), [Some(1.0), Some(4.0), Some(9.0)]);
        assert_eq!(median(sample), Some(4.0));
        for count in 1..40_u64 {
            let shuffled: Vec<u64> = (0..count).map(|i| i * 41 % count).collect();
            let mut sorted = shuffled.clone();
            sorted.sort_unstable();
            assert_eq!(median(shuffled), sorted.get(sorted.len() / 2).copied());
        }
    }

    #[test]
    fn shares_beyond_the_ends_give_the_ends_and_nothing_gives_nothing() {
        assert_eq!(quantile([2.0_f32, 1.0], -1.0), Some(1.0));
        assert_eq!(quantile([2.0_f32, 1.0], 2.0), Some(2.0));
        assert_eq!(quantile::<f32>([], 0.5), None);
        assert!(quantile([1.0, f64::NAN], 1.0).is_some_and(f64::is_nan));
    }
}
