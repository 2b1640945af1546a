//! Storage formats of weights.
//!
//! ```text
//! f32    4 bytes   as trained
//! bf16   2 bytes   the upper half of an f32, rounded to even: 8 bits of mantissa, the whole range
//! i8     1 byte    w = scale k, k = -127..=127, one f32 scale a row: 1/254 of the row's largest weight
//! ```
//! Sums are in f32, of bytes in whole numbers (`byte.rs`).

use serde::{Deserialize, Serialize};

/// Storage format of the weights of a tensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Element {
    /// Single precision.
    #[default]
    F32,
    /// The upper half of single precision.
    Bf16,
    /// A byte, with a scale a row.
    I8,
}

impl core::fmt::Display for Element {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::F32 => "f32",
            Self::Bf16 => "bf16",
            Self::I8 => "i8",
        })
    }
}

/// The bf16 nearest to a finite `x`, to even where two are as near. A number that would round up to
/// infinity stays the largest.
///
/// ```
/// use meniscus::latent::nn::{bf16_of, f32_of};
///
/// assert_eq!(f32_of(bf16_of(1.5)), 1.5);
/// // Eight bits of mantissa: a tie is rounded to even.
/// assert_eq!(f32_of(bf16_of(1.0 + 1.0 / 256.0)), 1.0);
/// ```
#[must_use]
pub fn bf16_of(x: f32) -> u16 {
    const LARGEST: u32 = 0x7F7F;
    let bits = x.to_bits();
    let even = (bits >> 16) & 1;
    let magnitude = (bits & 0x7FFF_FFFF).saturating_add(0x7FFF + even) >> 16;
    ((bits >> 16 & 0x8000) | magnitude.min(LARGEST)) as u16
}

/// The f32 that a bf16 is the upper half of.
///
/// ```
/// assert_eq!(meniscus::latent::nn::f32_of(0x3f80), 1.0);
/// ```
#[must_use]
pub fn f32_of(x: u16) -> f32 {
    f32::from_bits(u32::from(x) << 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bf16_rounds_to_the_nearest_and_to_even() {
        for (x, due) in
            [(0.0, 0.0), (1.0, 1.0), (-2.5, -2.5), (1.0 + 1.0 / 256.0, 1.0), (1.0 + 3.0 / 256.0, 1.015_625)]
        {
            assert_eq!(f32_of(bf16_of(x)), due, "{x}");
        }
        assert!(f32_of(bf16_of(f32::MAX)).is_finite() && f32_of(bf16_of(f32::MIN)) < -3e38);
        for k in 1..20_000 {
            let x = 0.001 * k as f32;
            assert!((f32_of(bf16_of(x)) - x).abs() <= x / 256.0, "{x}");
        }
    }
}
