//! The only door to transcendental functions, so that host and target compute the same bits.
//!
//! Everything goes through `libm` (pure Rust); `clippy.toml` forbids the inherent methods, which
//! would take the platform's own library once `std` is linked.

/// Square root, correctly rounded on every platform.
#[must_use]
pub fn sqrt(x: f64) -> f64 {
    libm::sqrt(x)
}

/// Exponential.
#[must_use]
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// Natural logarithm.
#[must_use]
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// `x` to the power `y`.
#[must_use]
pub fn pow(x: f64, y: f64) -> f64 {
    libm::pow(x, y)
}

/// Tangent of an angle in radians.
#[must_use]
pub fn tan(x: f64) -> f64 {
    libm::tan(x)
}

/// Sine and cosine of an angle in radians, in double precision.
#[must_use]
pub fn sincos(x: f64) -> (f64, f64) {
    libm::sincos(x)
}

/// Hyperbolic sine.
#[must_use]
pub fn sinh(x: f64) -> f64 {
    libm::sinh(x)
}

/// Hyperbolic cosine.
#[must_use]
pub fn cosh(x: f64) -> f64 {
    libm::cosh(x)
}

/// Hyperbolic tangent in double precision.
#[must_use]
pub fn tanh(x: f64) -> f64 {
    libm::tanh(x)
}

/// Bessel function of the first kind and whole order.
#[must_use]
pub fn bessel_j(order: i32, x: f64) -> f64 {
    libm::jn(order, x)
}

/// Square root in single precision, correctly rounded on every platform.
#[must_use]
pub fn sqrtf(x: f32) -> f32 {
    libm::sqrtf(x)
}

/// Hyperbolic tangent.
#[must_use]
pub fn tanhf(x: f32) -> f32 {
    libm::tanhf(x)
}

/// The logistic function 1 / (1 + e^-x).
#[must_use]
pub fn sigmoidf(x: f32) -> f32 {
    1.0 / (1.0 + libm::expf(-x))
}

/// Sine and cosine of an angle in radians.
#[must_use]
pub fn sincosf(x: f32) -> (f32, f32) {
    libm::sincosf(x)
}

/// Median of `numbers` (the upper one of an even count); `None` of no numbers.
///
/// It halves the range of values instead of sorting: the sort of `core` keeps a path that panics,
/// and the lists here are short. NaN counts as the largest value.
#[must_use]
pub fn median(numbers: impl Iterator<Item = f32> + Clone) -> Option<f32> {
    let count = numbers.clone().count();
    if count == 0 {
        return None;
    }
    // Keys in the order of the values: the smallest key with more than half of the numbers at or
    // below it is the median's.
    let (mut low, mut high) = (0_u32, u32::MAX);
    while low < high {
        let middle = low + (high - low) / 2;
        if numbers.clone().filter(|&x| order_key(x) <= middle).count() > count / 2 {
            high = middle;
        } else {
            low = middle.saturating_add(1);
        }
    }
    numbers.into_iter().find(|&x| order_key(x) == low)
}

/// A key that orders like the numbers: the bits, with the sign's meaning turned round.
fn order_key(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_is_the_middle_of_the_sorted_list() {
        let numbers = [3.5, -1.0, 0.0, -7.25, 1e30, 2.0, -0.0, 2.0];
        let mut sorted = numbers;
        for n in 1..=numbers.len() {
            sorted = numbers;
            sorted[..n].sort_by(f32::total_cmp);
            assert_eq!(median(numbers[..n].iter().copied()), Some(sorted[n / 2]));
        }
        assert_eq!(median([].into_iter()), None);
        assert_eq!(sorted[0], -7.25);
    }
}
