//! Faults of a real camera, put on images without noise.
//!
//! Order of the faults, as light and electronics have it: dots, gain, defocus, motion smear, noise and clipping of the
//! infrared image; border, holes, disparity noise and steps of the depth image.

use super::set::TracedScene;
use crate::render::noise::{Noise, mix};

/// Product of focal length and baseline, pixels times metres; steps of disparity in a pixel.
const STEREO: f32 = 384.0 * 0.050;
const DISPARITY_STEPS: f32 = 32.0;
/// Unit of the depth image, metres.
const UNIT_M: f32 = 1e-4;
/// Depths farther apart than this are on two sides of a border, metres.
const BORDER_M: f32 = 0.050;
/// Mean number of pixels to a dot, and standard deviation of a dot's light, pixels.
const DOT_PIXELS: u64 = 70;
const DOT_PX: f32 = 1.0;
/// Area of a hole in the depth image, pixels.
const HOLE: usize = 4;

/// Faults of one camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Faults {
    /// Noise of the infrared image, grey levels rms at mid grey.
    pub grey_rms: f32,
    /// Noise of the disparity, pixels rms.
    pub disparity_rms_px: f32,
    /// Share of the depth image in random holes.
    pub hole_share: f32,
    /// Pixels by which the nearer side of a border in depth is too wide; below zero too narrow.
    pub border_px: i32,
    /// Height of the projector's dots over white, grey levels.
    pub dots: f32,
    /// Factor on the light.
    pub gain: f32,
    /// Standard deviation of a defocus on top of the lens' blur, pixels.
    pub defocus_px: f32,
    /// Columns over which a motion smears.
    pub smear_px: usize,
}

impl Default for Faults {
    /// The noise of a D435, nothing else.
    fn default() -> Self {
        Self {
            grey_rms: 2.0,
            disparity_rms_px: 0.08,
            hole_share: 0.05,
            border_px: 0,
            dots: 0.0,
            gain: 1.0,
            defocus_px: 0.0,
            smear_px: 1,
        }
    }
}

/// A pair of images as bytes on the wire.
#[derive(Clone, Debug)]
pub struct Pair {
    /// Y8.
    pub infrared: Vec<u8>,
    /// Z16, little-endian.
    pub depth: Vec<u8>,
}

/// Returns frame `frame` of a scene under these faults; the dots stay, the noise changes from frame to frame.
#[must_use]
pub fn degrade(scene: &TracedScene, width: usize, faults: &Faults, frame: u64) -> Pair {
    let noise = Noise::new(mix(scene.truth.seed));
    let seed = mix(scene.truth.seed ^ mix(frame));
    Pair {
        infrared: infrared(scene, width, faults, &noise, seed),
        depth: depth(scene, width, faults, &noise, seed),
    }
}

fn infrared(scene: &TracedScene, width: usize, faults: &Faults, noise: &Noise, seed: u64) -> Vec<u8> {
    let mut light = scene.grey.clone();
    if faults.dots > 0.0 {
        let dots = dots(light.len(), width, mix(scene.truth.seed));
        light.iter_mut().zip(dots).for_each(|(grey, dot)| *grey += dot * faults.dots * *grey / 255.0);
    }
    light.iter_mut().for_each(|grey| *grey *= faults.gain);
    if faults.defocus_px > 0.0 {
        let kernel = gaussian(faults.defocus_px);
        light = convolved(&light, &kernel, 1);
        light = convolved(&light, &kernel, width);
    }
    if faults.smear_px > 1 {
        light = convolved(&light, &vec![1.0 / faults.smear_px as f32; faults.smear_px], 1);
    }
    let mut bytes = Vec::with_capacity(light.len());
    for (row, line) in light.chunks_exact(width).enumerate() {
        let white = noise.row(seed ^ mix(row as u64), width);
        bytes.extend(line.iter().zip(white).map(|(grey, white)| {
            // Half of the variance is read noise, half photon noise at mid grey.
            let variance = faults.grey_rms * faults.grey_rms * 0.5 * (1.0 + grey / 128.0);
            (grey + white * variance.sqrt() + 0.5).clamp(0.0, 255.0) as u8
        }));
    }
    bytes
}

/// Light of the dots over white that is 1: round spots at random places.
fn dots(pixels: usize, width: usize, seed: u64) -> Vec<f32> {
    let mut dots = vec![0.0_f32; pixels];
    let height = pixels / width;
    for index in 0..pixels as u64 / DOT_PIXELS {
        let unit = |salt: u64| mix(seed ^ mix(2 * index + salt)) as f32 / u64::MAX as f32;
        let (u, v) = (unit(0) * width as f32, unit(1) * height as f32);
        let span = |at: f32, end: usize| (at - 4.0).max(0.0) as usize..((at + 5.0) as usize).min(end);
        for row in span(v, height) {
            for column in span(u, width) {
                let square = (column as f32 - u).powi(2) + (row as f32 - v).powi(2);
                dots[row * width + column] += (-0.5 * square / (DOT_PX * DOT_PX)).exp();
            }
        }
    }
    dots
}

/// Weights of a Gaussian, sum 1.
fn gaussian(deviation: f32) -> Vec<f32> {
    let reach = (3.0 * deviation).ceil() as i32;
    let weights: Vec<f32> =
        (-reach..=reach).map(|at| (-0.5 * (at as f32 / deviation).powi(2)).exp()).collect();
    let sum: f32 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / sum).collect()
}

/// Convolution along a row (`stride` 1) or a column (`stride` the width); pixels at the image's rim stay.
fn convolved(light: &[f32], kernel: &[f32], stride: usize) -> Vec<f32> {
    let half = kernel.len() / 2 * stride;
    let mut out = light.to_vec();
    let inner = half..light.len().saturating_sub(half);
    for (at, out) in out.iter_mut().enumerate().take(inner.end).skip(inner.start) {
        *out = kernel.iter().zip(light[at - half..].iter().step_by(stride)).map(|(w, x)| w * x).sum();
    }
    out
}

fn depth(scene: &TracedScene, width: usize, faults: &Faults, noise: &Noise, seed: u64) -> Vec<u8> {
    let mut depth_m = bordered(&scene.depth_m, width, faults.border_px);
    // Of `n` holes thrown at random the share `1 - exp(-n a / A)` is covered.
    let pixels = depth_m.len();
    let thrown = -(1.0 - f64::from(faults.hole_share)).ln() * pixels as f64 / (HOLE * HOLE) as f64;
    for index in 0..thrown as u64 {
        let at = mix(seed ^ mix(index)) as usize % pixels;
        for row in 0..HOLE {
            let start = at + row * width;
            depth_m.get_mut(start..start + HOLE).unwrap_or_default().fill(0.0);
        }
    }
    let (mut scratch, mut correlated) = (Vec::new(), vec![0.0; pixels]);
    noise.correlated(mix(seed), width, &mut scratch, &mut correlated);
    let raw = depth_m.iter().zip(&correlated).map(|(depth_m, noise)| {
        if *depth_m <= 0.0 {
            return 0;
        }
        let noisy = STEREO / depth_m + faults.disparity_rms_px * noise;
        let stepped = (noisy * DISPARITY_STEPS).round().max(1.0) / DISPARITY_STEPS;
        (STEREO / (stepped * UNIT_M)).round().min(65_535.0) as u16
    });
    raw.flat_map(u16::to_le_bytes).collect()
}

/// The depths with their borders moved: within `px` pixels of a border the nearer side wins, or the farther one.
fn bordered(depth_m: &[f32], width: usize, px: i32) -> Vec<f32> {
    let reach = px.unsigned_abs() as usize;
    let height = depth_m.len() / width;
    let mut out = depth_m.to_vec();
    if reach == 0 {
        return out;
    }
    for row in 0..height {
        for column in 0..width {
            let own = depth_m[row * width + column];
            // The nearest pixel of the other side, by the city-block order of the window.
            let mut taken: Option<(usize, f32)> = None;
            for v in row.saturating_sub(reach)..(row + reach + 1).min(height) {
                for u in column.saturating_sub(reach)..(column + reach + 1).min(width) {
                    let other = depth_m[v * width + u];
                    let across = if px > 0 { own - other } else { other - own };
                    let away = v.abs_diff(row) + u.abs_diff(column);
                    if other > 0.0 && across > BORDER_M && taken.is_none_or(|(least, _)| away < least) {
                        taken = Some((away, other));
                    }
                }
            }
            if let Some((_, other)) = taken.filter(|_| own > 0.0) {
                out[row * width + column] = other;
            }
        }
    }
    out
}
