//! Figures of a sample, and quantiles of distributions.

#[cfg(feature = "distributions")]
mod distribution;
mod order;

#[cfg(feature = "distributions")]
pub use distribution::{f_exceeded, student_t_exceeded};
pub use order::{Ordered, median, quantile};

/// Returns the arithmetic mean `sum x / n`; not a number for an empty sample.
///
/// ```
/// assert_eq!(meniscus_numerics::statistics::mean(&[1.0, 2.0, 6.0]), 3.0);
/// ```
#[must_use]
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Returns the sample variance `sum (x - mean)^2 / (n - 1)` (Bessel's correction); not a number for fewer than two values.
///
/// ```
/// assert_eq!(meniscus_numerics::statistics::variance(&[1.0, 2.0, 6.0]), 7.0);
/// ```
#[must_use]
pub fn variance(values: &[f64]) -> f64 {
    if values.len() < 2 {
        return f64::NAN;
    }
    let mean = mean(values);
    values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (values.len() as f64 - 1.0)
}

/// Returns the root mean square `sqrt(sum x^2 / n)`; not a number for an empty sample.
///
/// ```
/// assert_eq!(meniscus_numerics::statistics::rms([3.0, -4.0, 5.0, 0.0]), f64::sqrt(12.5));
/// ```
#[must_use]
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    f64::sqrt(sum / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_a_sample_agree_with_numpy() {
        // python3 -c "import numpy as n; x = n.sqrt(n.arange(1, 9)); print(x.mean(), x.var(ddof=1), (x**2).mean()**.5)"
        let roots: Vec<f64> = (1..9).map(|i| f64::from(i).sqrt()).collect();
        assert!((mean(&roots) - 2.038_250_065_754_465_5).abs() < 1e-15, "{}", mean(&roots));
        assert!((variance(&roots) - 0.394_899_050_802_192_84).abs() < 1e-14, "{}", variance(&roots));
        assert!((rms(roots) - 4.5_f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn samples_that_are_too_small_give_no_number() {
        assert!(mean(&[]).is_nan() && rms([]).is_nan());
        assert!(variance(&[]).is_nan() && variance(&[2.0]).is_nan());
    }
}
