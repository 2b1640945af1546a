//! The only door to transcendental functions, so that host and target compute the same bits.
//!
//! Everything goes through `libm` (pure Rust); `clippy.toml` forbids the inherent methods, which
//! would take the platform's own library once `std` is linked.

/// Square root, correctly rounded on every platform.
#[must_use]
pub fn sqrt(x: f64) -> f64 {
    libm::sqrt(x)
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
