//! Readings of a pixel's sensors: disparity and light with their noise, in the camera's units.

use super::SceneSettings;
use super::view::View;

/// Steps of disparity in a pixel.
const STEPS: f32 = 32.0;

/// Depth in the camera's units: disparity with noise, in steps of 1/32 pixel; 0 without a disparity.
pub(super) fn measure_depth(settings: &SceneSettings, view: &View, disparity: f32, noise: f32) -> u16 {
    if disparity <= 0.0 {
        return 0;
    }
    let noisy = disparity + settings.disparity_rms_px as f32 * noise;
    let stepped = (noisy * STEPS).round() / STEPS;
    (view.stereo as f32 / (stepped.max(1.0 / STEPS) * settings.camera.depth_unit_m)).round().min(65_535.0)
        as u16
}

/// Grey level of `grey` with noise: half of the variance read noise, half photon noise at mid grey.
pub(super) fn expose(settings: &SceneSettings, grey: f32, white: f32) -> u8 {
    let variance = (settings.grey_rms * settings.grey_rms) as f32 * 0.5 * (1.0 + grey / 128.0);
    (grey + white * variance.sqrt() + 0.5).clamp(0.0, 255.0) as u8
}
