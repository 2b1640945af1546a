//! Depth to disparity and back.
//!
//! `disparity = factor / depth`, `depth = trunc(factor / disparity + 1/2)`, in single precision, with
//! `factor = B f 32 / u`: baseline `B` in metres, focal length `f` in pixels, `u` metres a depth unit; so
//! disparities are in 1/32 pixel. What is not a normal number becomes 0.
//! Source: librealsense 2.56.5, disparity transform, as measured.

use super::{SizeError, check};

/// The factor.
///
/// ```
/// use meniscus::depth_filters::disparity_factor;
///
/// // A baseline of 50 mm and 384 pixels: 400 mm away the disparity is 48 pixels, in parts of 1/32.
/// let factor = disparity_factor(0.05, 384.0, 0.001);
/// assert!((factor / 400.0 / 32.0 - 48.0).abs() < 1e-3);
/// ```
#[must_use]
pub fn disparity_factor(baseline_m: f32, fx_px: f32, depth_unit_m: f32) -> f32 {
    baseline_m * fx_px * 32.0 / depth_unit_m
}

/// Writes disparities to `out`.
///
/// ```
/// use meniscus::depth_filters::to_disparity;
///
/// let mut disparity = [0.0; 2];
/// to_disparity(&[400, 0], 800.0, &mut disparity)?;
/// assert_eq!(disparity, [2.0, 0.0]);
/// # Ok::<(), meniscus::depth_filters::SizeError>(())
/// ```
///
/// # Errors
/// [`SizeError`] if the sizes differ.
pub fn to_disparity(depth: &[u16], factor: f32, out: &mut [f32]) -> Result<(), SizeError> {
    check("disparities", out.len(), depth.len(), false)?;
    for (out, &z) in out.iter_mut().zip(depth) {
        *out = if z == 0 { 0.0 } else { factor / f32::from(z) };
    }
    Ok(())
}

/// Writes depths to `out`.
///
/// ```
/// use meniscus::depth_filters::to_depth;
///
/// let mut depth = [0; 2];
/// to_depth(&[2.0, 0.0], 800.0, &mut depth)?;
/// assert_eq!(depth, [400, 0]);
/// # Ok::<(), meniscus::depth_filters::SizeError>(())
/// ```
///
/// # Errors
/// [`SizeError`] if the sizes differ.
pub fn to_depth(disparity: &[f32], factor: f32, out: &mut [u16]) -> Result<(), SizeError> {
    check("depths", out.len(), disparity.len(), false)?;
    for (out, &d) in out.iter_mut().zip(disparity) {
        *out = if d.is_normal() { (factor / d + 0.5) as u16 } else { 0 };
    }
    Ok(())
}
