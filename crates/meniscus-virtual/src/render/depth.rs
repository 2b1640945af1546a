//! The depth image: true disparity, matching noise, steps of 1/32 pixel, holes.

use super::backdrop::Backdrop;
use super::clutter::Overlay;
use super::noise::{Noise, mix};
use super::outline::Outline;
use super::sensor::measure_depth;
use super::view::View;
use super::{SceneSettings, Subject, Window};

/// Share of the pixels at an edge that are holes.
const EDGE_HOLES: f64 = 0.5;
/// Share of the pixels behind empty glass that are holes.
const GLASS_HOLES: f64 = 0.4;
/// Largest radius of a random hole, and the mean area of one, pixels.
const HOLE_RADIUS: f64 = 3.5;
const HOLE_AREA: f64 = 17.5;

/// Room for the window's disparities and noise.
#[derive(Clone, Debug)]
pub(super) struct Painter {
    window: Window,
    disparity: Vec<f32>,
    correlated: Vec<f32>,
    scratch: Vec<f32>,
}

impl Painter {
    pub(super) fn new(window: Window) -> Self {
        let pixels = window.width() * window.height();
        Self { window, disparity: vec![0.0; pixels], correlated: vec![0.0; pixels], scratch: Vec::new() }
    }

    #[expect(clippy::too_many_arguments, reason = "the parts of the scene are borrowed one by one")]
    pub(super) fn paint(
        &mut self,
        settings: &SceneSettings,
        view: &View,
        backdrop: &Backdrop,
        subject: Subject<'_>,
        noise: &Noise,
        seed: u64,
        out: &mut [u8],
    ) {
        let Window { left, right, top, .. } = self.window;
        let Subject { outline, overlay, .. } = subject;
        let width = right - left;
        for (row, disparity) in self.disparity.chunks_exact_mut(width).enumerate() {
            let line = (top + row) * view.width;
            disparity.copy_from_slice(&backdrop.disparity[line + left..line + right]);
            if let Some(outline) = outline {
                draw_row(view, outline, overlay, top + row, left, seed, disparity);
            }
            for (u, pixel) in (left..right).zip(disparity) {
                if let Some((share, _, depth)) = overlay.finger(u, top + row)
                    && share > 0.5
                {
                    *pixel = (view.stereo / depth) as f32;
                }
            }
        }
        self.punch_holes(settings, seed);
        noise.correlated(mix(seed), width, &mut self.scratch, &mut self.correlated);
        let rows = self.disparity.chunks_exact(width).zip(self.correlated.chunks_exact(width));
        for (row, (disparity, correlated)) in rows.enumerate() {
            let start = 2 * ((top + row) * view.width + left);
            let pixels = out[start..start + 2 * width].chunks_exact_mut(2);
            for (pixel, (disparity, noise)) in pixels.zip(disparity.iter().zip(correlated)) {
                pixel.copy_from_slice(&measure_depth(settings, view, *disparity, *noise).to_le_bytes());
            }
        }
    }

    /// Random round holes.
    fn punch_holes(&mut self, settings: &SceneSettings, seed: u64) {
        let (width, height) = (self.window.width(), self.window.height());
        // Of `n` holes thrown at random the share `1 - exp(-n a / A)` is covered.
        let thrown = -(1.0 - settings.hole_share.clamp(0.0, 0.99)).ln() * (width * height) as f64 / HOLE_AREA;
        for index in 0..thrown as u64 {
            let draw = |salt: u64| unit(seed ^ mix(4 * index + salt));
            let (u, v, radius) =
                (draw(0) * width as f64, draw(1) * height as f64, 1.0 + draw(2) * (HOLE_RADIUS - 1.0));
            let span = |centre: f64, end: usize| {
                (centre - radius).max(0.0) as usize..((centre + radius + 1.0) as usize).min(end)
            };
            for row in span(v, height) {
                for column in span(u, width) {
                    if (column as f64 - u).hypot(row as f64 - v) <= radius {
                        self.disparity[row * width + column] = 0.0;
                    }
                }
            }
        }
    }
}

/// Puts the glass into one row of disparities.
fn draw_row(
    view: &View,
    outline: &Outline,
    overlay: &Overlay,
    v: usize,
    left: usize,
    seed: u64,
    disparity: &mut [f32],
) {
    let sides = outline.sides(view, v as f64);
    let mut shadow = None;
    for (index, pixel) in disparity.iter_mut().enumerate() {
        let u = left + index;
        if (u as f64) > sides[1] + 2.0 {
            break;
        }
        let coverage = outline.coverage(u, v, sides);
        let draw = unit(seed ^ mix(((v as u64) << 32) | u as u64));
        let [rim_v, bottom_v] = outline.glass_rows(u);
        let on_glass =
            (rim_v..bottom_v).contains(&(v as f64)) && u as f64 > sides[0] && (u as f64) < sides[1];
        if on_glass && overlay.blinds(u, sides) {
            *pixel = 0.0;
            continue;
        }
        let foamy = overlay.foam(view, outline, u, v, sides).0 > 0.5;
        // Through a clear liquid the matching sees what is behind, with as many holes as through the glass.
        let clear = overlay.clear() > 0.5;
        let depth = if (coverage.front > 0.5 && !clear) || foamy {
            outline.front_depth(view, u, v)
        } else if coverage.behind > 0.5 && !clear {
            outline.behind_depth(u, v)
        } else {
            if coverage.empty + coverage.front > 0.5 && draw < GLASS_HOLES {
                *pixel = 0.0;
            }
            if outline.near_edge(u, v, sides) && draw < EDGE_HOLES {
                *pixel = 0.0;
            }
            continue;
        };
        if let Some(depth) = depth {
            let near = (view.stereo / depth) as f32;
            shadow.get_or_insert((index, near));
            *pixel = if outline.near_edge(u, v, sides) && draw < EDGE_HOLES { 0.0 } else { near };
        }
    }
    // The right imager does not see the background just left of a near body.
    if let Some((first, near)) = shadow {
        for (index, pixel) in disparity[..first].iter_mut().enumerate() {
            if (first - index) as f32 <= near - *pixel {
                *pixel = 0.0;
            }
        }
    }
}

/// A number from 0 to 1 that belongs to `seed`.
fn unit(seed: u64) -> f64 {
    mix(seed) as f64 / u64::MAX as f64
}
