//! The only door to transcendental functions, so that host and target compute the same bits.
//!
//! Everything goes through `libm` (pure Rust); `clippy.toml` forbids the inherent methods, which
//! would take the platform's own library once `std` is linked.

/// Square root, correctly rounded on every platform.
///
/// ```
/// assert_eq!(meniscus::math::sqrt(2.25), 1.5);
/// ```
#[must_use]
pub fn sqrt(x: f64) -> f64 {
    libm::sqrt(x)
}

/// Exponential.
///
/// ```
/// assert_eq!(meniscus::math::exp(0.0), 1.0);
/// ```
#[must_use]
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// Natural logarithm.
///
/// ```
/// assert_eq!(meniscus::math::ln(1.0), 0.0);
/// ```
#[must_use]
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// `x` to the power `y`.
///
/// ```
/// assert_eq!(meniscus::math::pow(2.0, -3.0), 0.125);
/// ```
#[must_use]
pub fn pow(x: f64, y: f64) -> f64 {
    libm::pow(x, y)
}

/// Tangent of an angle in radians.
///
/// ```
/// let angle = core::f64::consts::FRAC_PI_4;
/// assert!((meniscus::math::tan(angle) - 1.0).abs() < 1e-15);
/// ```
#[must_use]
pub fn tan(x: f64) -> f64 {
    libm::tan(x)
}

/// Sine and cosine of an angle in radians, in double precision.
///
/// ```
/// let (sine, cosine) = meniscus::math::sincos(0.3);
/// assert!((sine * sine + cosine * cosine - 1.0).abs() < 1e-15);
/// ```
#[must_use]
pub fn sincos(x: f64) -> (f64, f64) {
    libm::sincos(x)
}

/// Hyperbolic sine.
///
/// ```
/// use meniscus::math::{cosh, sinh};
///
/// assert!((cosh(1.2) * cosh(1.2) - sinh(1.2) * sinh(1.2) - 1.0).abs() < 1e-14);
/// ```
#[must_use]
pub fn sinh(x: f64) -> f64 {
    libm::sinh(x)
}

/// Hyperbolic cosine.
///
/// ```
/// assert_eq!(meniscus::math::cosh(0.0), 1.0);
/// ```
#[must_use]
pub fn cosh(x: f64) -> f64 {
    libm::cosh(x)
}

/// Hyperbolic tangent in double precision.
///
/// ```
/// // Frequency of deep water: tanh(k h) is 1 to the last bit.
/// assert_eq!(meniscus::math::tanh(20.0), 1.0);
/// ```
#[must_use]
pub fn tanh(x: f64) -> f64 {
    libm::tanh(x)
}

/// Bessel function of the first kind and whole order.
///
/// ```
/// // The first zero of J_1' gives the first sloshing mode of a cylinder: there J_0(x) = J_1(x) / x.
/// use meniscus::math::bessel_j;
///
/// let x = 1.841_183_781_340_659_3;
/// assert!((bessel_j(0, x) - bessel_j(1, x) / x).abs() < 1e-12);
/// ```
#[must_use]
pub fn bessel_j(order: i32, x: f64) -> f64 {
    libm::jn(order, x)
}

/// Square root in single precision, correctly rounded on every platform.
///
/// ```
/// assert_eq!(meniscus::math::sqrtf(0.25), 0.5);
/// ```
#[must_use]
pub fn sqrtf(x: f32) -> f32 {
    crate::square_root::sqrtf(x)
}

/// e^x without a branch, so that a loop over it becomes vectors; within 3e-7 of the value, which stays within
/// e^-87 to e^88. NaN stays NaN.
///
/// `x = n ln 2 + r`, `|r| <= ln 2 / 2`, `e^x = 2^n (1 + r + r^2 / 2! + ... + r^7 / 7!)`; what is left out is below
/// r^8 / 8! = 5e-9.
///
/// ```
/// assert!((meniscus::math::expf(1.0) - core::f32::consts::E).abs() < 1e-6);
/// assert!(meniscus::math::expf(-1000.0) > 0.0, "limited to e^-87");
/// ```
#[inline(always)]
#[must_use]
pub fn expf(x: f32) -> f32 {
    // Adding it leaves the nearest whole number in the lowest bits.
    const ROUND: f32 = 12_582_912.0;
    // ln 2 in two parts; n times the first is exact.
    const LN_2: (f32, f32) = (0.693_359_4, -2.121_944_4e-4);
    let x = if x < -87.0 { -87.0 } else { x };
    let x = if x > 88.0 { 88.0 } else { x };
    let shifted = x * core::f32::consts::LOG2_E + ROUND;
    let n = shifted - ROUND;
    let r = (x - n * LN_2.0) - n * LN_2.1;
    let mut sum = 1.0 / 5040.0;
    for factorial in [720.0, 120.0, 24.0, 6.0, 2.0, 1.0, 1.0] {
        sum = sum * r + 1.0 / factorial;
    }
    // 2^n by its exponent.
    sum * f32::from_bits((shifted.to_bits() << 23).wrapping_add(1.0_f32.to_bits()))
}

/// Hyperbolic tangent, 1 - 2 / (e^2x + 1), within 3e-7.
///
/// ```
/// assert!((meniscus::math::tanhf(0.5) - 0.462_117_16).abs() < 3e-7);
/// ```
#[inline(always)]
#[must_use]
pub fn tanhf(x: f32) -> f32 {
    1.0 - 2.0 / (expf(2.0 * x) + 1.0)
}

/// The logistic function 1 / (1 + e^-x).
///
/// ```
/// assert_eq!(meniscus::math::sigmoidf(0.0), 0.5);
/// ```
#[inline(always)]
#[must_use]
pub fn sigmoidf(x: f32) -> f32 {
    1.0 / (1.0 + expf(-x))
}

/// Sine and cosine of an angle in radians.
///
/// ```
/// assert_eq!(meniscus::math::sincosf(0.0), (0.0, 1.0));
/// ```
#[must_use]
pub fn sincosf(x: f32) -> (f32, f32) {
    libm::sincosf(x)
}

/// Median of `numbers` (the upper one of an even count); `None` of no numbers.
///
/// It halves the range of values instead of sorting: the sort of `core` keeps a path that panics,
/// and the lists here are short. NaN counts as the largest value.
///
/// ```
/// use meniscus::math::median;
///
/// assert_eq!(median([3.0, f32::NAN, 1.0].into_iter()), Some(3.0));
/// assert_eq!(median(core::iter::empty()), None);
/// ```
#[must_use]
pub fn median(numbers: impl Iterator<Item = f32> + Clone) -> Option<f32> {
    let (mut keys, mut count) = ([u32::MAX; MEDIAN_ROOM], 0_usize);
    let mut all = numbers.clone();
    for (key, x) in keys.iter_mut().zip(&mut all) {
        *key = order_key(x);
        count = count.saturating_add(1);
    }
    match all.next() {
        None => median_key(keys.get(..count)?).map(number_of),
        Some(_) => median_of_many(numbers),
    }
}

/// Numbers that [`median`] keeps the keys of: as many as a region of the image has columns.
const MEDIAN_ROOM: usize = 256;

/// Numbers of which [`median_key`] takes the ranks.
const MEDIAN_FEW: usize = 40;

/// The key with as many before as behind it, as [`median_of_many`] finds it, over a list that is there.
fn median_key(keys: &[u32]) -> Option<u32> {
    let half = u32::try_from(keys.len() / 2).ok()?;
    if keys.len() <= MEDIAN_FEW {
        // The ranks of some keys cost less than the halvings, of which numbers of both signs take 31.
        let ranks = |key: u32| {
            keys.iter().fold([0_u32; 2], |[less, upto], &other| {
                [less.wrapping_add(u32::from(other < key)), upto.wrapping_add(u32::from(other <= key))]
            })
        };
        // What is known to lie before or behind the median is passed over.
        let (mut least, mut most) = (u32::MIN, u32::MAX);
        return keys.iter().copied().find(|&key| {
            if key < least || key > most {
                return false;
            }
            let [less, upto] = ranks(key);
            if less > half {
                most = key.saturating_sub(1);
            } else if upto <= half {
                least = key.saturating_add(1);
            }
            less <= half && half < upto
        });
    }
    let mut low = keys.iter().copied().min()?;
    let mut high = keys.iter().copied().max()?;
    while low < high {
        let middle = low + (high - low) / 2;
        let below = keys.iter().fold(0_u32, |sum, &key| sum.wrapping_add(u32::from(key <= middle)));
        if below > half {
            high = middle;
        } else {
            low = middle.saturating_add(1);
        }
    }
    Some(low)
}

/// The same without a list: the numbers are counted anew for every halving.
fn median_of_many(numbers: impl Iterator<Item = f32> + Clone) -> Option<f32> {
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

/// The number with the key.
fn number_of(key: u32) -> f32 {
    f32::from_bits(if key >> 31 == 1 { key & !(1 << 31) } else { !key })
}

#[cfg(test)]
mod tests {
    use super::*;
    use heapless::Vec;

    #[test]
    fn exponential_and_what_is_made_of_it_are_right() {
        for k in -9000..=9000 {
            let x = 0.01 * k as f32;
            let exact = f64::from(x).clamp(-87.0, 88.0);
            let relative = f64::from(expf(x)) / libm::exp(exact) - 1.0;
            assert!(relative.abs() < 3e-7, "e^{x}: {relative}");
            assert!((f64::from(tanhf(x)) - libm::tanh(f64::from(x))).abs() < 3e-7, "tanh {x}");
            let sigmoid = 1.0 / (1.0 + libm::exp(-f64::from(x)));
            assert!((f64::from(sigmoidf(x)) - sigmoid).abs() < 3e-7, "sigmoid {x}");
        }
        assert!(expf(f32::NAN).is_nan() && tanhf(f32::NAN).is_nan());
        assert_eq!((tanhf(f32::INFINITY), tanhf(f32::NEG_INFINITY)), (1.0, -1.0));
        assert_eq!((tanhf(0.0), sigmoidf(0.0), expf(0.0)), (0.0, 0.5, 1.0));
    }

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
        // One list that fits and one that does not.
        for n in [MEDIAN_ROOM, MEDIAN_ROOM + 1, 3 * MEDIAN_ROOM] {
            let number = |k: usize| ((k * 7919) % 1009) as f32 - 500.0;
            let mut sorted: Vec<f32, 1024> = (0..n).map(number).collect();
            sorted.sort_by(f32::total_cmp);
            assert_eq!(median((0..n).map(number)), Some(sorted[n / 2]));
        }
        assert_eq!(sorted[0], -7.25);
    }
}
