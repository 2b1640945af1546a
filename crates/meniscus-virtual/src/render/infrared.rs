//! The left infrared image: tones by coverage, lens blur, vignetting, noise.

use super::backdrop::{Backdrop, tones};
use super::clutter::Overlay;
use super::noise::{Noise, mix};
use super::outline::Outline;
use super::sensor::expose;
use super::view::View;
use super::{SceneSettings, Subject, Window};

/// Pixels on either side that the lens blur reaches.
const BLUR_REACH: usize = 3;
/// Glass takes some light, and more at its limb.
const GLASS_LOSS: f64 = 0.06;
const LIMB_LOSS: f64 = 0.25;

/// Room for the window's picture, and the blur's weights.
#[derive(Clone, Debug)]
pub(super) struct Painter {
    window: Window,
    kernel: [f32; 2 * BLUR_REACH + 1],
    sharp: Vec<f32>,
    blurred: Vec<f32>,
}

impl Painter {
    pub(super) fn new(window: Window, blur_px: f64) -> Self {
        let mut kernel = [0.0; 2 * BLUR_REACH + 1];
        for (k, weight) in kernel.iter_mut().enumerate() {
            let offset = k as f64 - BLUR_REACH as f64;
            *weight = (-0.5 * (offset / blur_px.max(1e-3)).powi(2)).exp() as f32;
        }
        let sum: f32 = kernel.iter().sum();
        let pixels = window.width() * window.height();
        Self { window, kernel: kernel.map(|w| w / sum), sharp: vec![0.0; pixels], blurred: vec![0.0; pixels] }
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
        self.draw(settings, view, backdrop, subject.outline, subject.overlay);
        if let Some(tag) = &settings.tag {
            tag.paint(view, subject.axis_m, settings.camera.radius_m.into(), self.window, &mut self.sharp);
        }
        self.blur();
        let Window { left, right, top, .. } = self.window;
        for (row, blurred) in self.blurred.chunks_exact(right - left).enumerate() {
            let line = (top + row) * view.width;
            let white = noise.row(seed ^ mix(row as u64), right - left);
            let lit = backdrop.vignette[line + left..line + right].iter().zip(blurred).zip(white);
            let pixels = out[line + left..line + right].iter_mut();
            pixels.zip(lit).for_each(|(pixel, ((vignette, grey), white))| {
                *pixel = expose(settings, grey * vignette, *white);
            });
        }
    }

    /// The sharp picture.
    fn draw(
        &mut self,
        settings: &SceneSettings,
        view: &View,
        backdrop: &Backdrop,
        outline: Option<&Outline>,
        overlay: &Overlay,
    ) {
        let Window { left, right, top, .. } = self.window;
        for (row, pixels) in self.sharp.chunks_exact_mut(right - left).enumerate() {
            let v = top + row;
            let line = v * view.width;
            for (u, pixel) in (left..right).zip(pixels.iter_mut()) {
                let (grey, disparity) = (backdrop.grey[line + u], backdrop.disparity[line + u]);
                *pixel = grey + backdrop.dot(settings, u, v, view.width, disparity, grey);
            }
            if let Some(outline) = outline {
                draw_glass(settings, view, backdrop, outline, overlay, v, left, pixels);
            }
            for (u, pixel) in (left..right).zip(pixels) {
                if let Some((share, tone, _)) = overlay.finger(u, v) {
                    *pixel = *pixel * (1.0 - share as f32) + (share * tone) as f32;
                }
            }
        }
    }

    /// Separable blur; the outermost pixels of the window stay sharp (there is only background).
    fn blur(&mut self) {
        let width = self.window.width();
        self.blurred.copy_from_slice(&self.sharp);
        for (out, line) in self.blurred.chunks_exact_mut(width).zip(self.sharp.chunks_exact(width)) {
            for (out, near) in out[BLUR_REACH..].iter_mut().zip(line.windows(self.kernel.len())) {
                *out = near.iter().zip(&self.kernel).map(|(x, w)| x * w).sum();
            }
        }
        self.sharp.copy_from_slice(&self.blurred);
        let rows = self.window.height();
        for row in BLUR_REACH..rows.saturating_sub(BLUR_REACH) {
            let out = &mut self.blurred[row * width..(row + 1) * width];
            out.fill(0.0);
            let lines = self.sharp[(row - BLUR_REACH) * width..].chunks_exact(width);
            for (line, weight) in lines.zip(&self.kernel) {
                out.iter_mut().zip(line).for_each(|(out, x)| *out += weight * x);
            }
        }
    }
}

/// The glass in one row, over the background.
#[expect(clippy::too_many_arguments, reason = "the parts of the scene are borrowed one by one")]
fn draw_glass(
    settings: &SceneSettings,
    view: &View,
    backdrop: &Backdrop,
    outline: &Outline,
    overlay: &Overlay,
    v: usize,
    left: usize,
    pixels: &mut [f32],
) {
    let tones = tones(settings);
    let sides = outline.sides(view, v as f64);
    let inside = |u: f64| (u.max(left as f64) as usize).min(left + pixels.len());
    let clear = overlay.clear();
    for u in inside(sides[0] - 1.0)..inside(sides[1] + 2.0) {
        let coverage = outline.coverage(u, v, sides);
        let across = Outline::across(u as f64, sides).abs().min(1.0);
        // Lit from the camera, a little more from the right; darker towards the limb.
        let facing = (1.0 - across * across).sqrt();
        let shade = (0.6 + 0.4 * facing) * (1.0 + 0.06 * Outline::across(u as f64, sides));
        let front = tones.front * shade;
        let depth = outline.front_depth(view, u, v).unwrap_or(view.distance_m);
        let dot = backdrop.dot(settings, u, v, view.width, (view.stereo / depth) as f32, front as f32);
        let limb_px = (1.0 - across) * 0.5 * (sides[1] - sides[0]);
        let kept = 1.0 - coverage.empty * (GLASS_LOSS + LIMB_LOSS * (-limb_px).exp());
        let pixel = &mut pixels[u - left];
        let opaque = (1.0 - clear) * (coverage.front + coverage.behind);
        // Foam stands on the contact line, before what else is seen above it.
        let (foam, foam_tone) = overlay.foam(view, outline, u, v, sides);
        let bare = if foam > 0.0 { (1.0 - foam / (1.0 - coverage.front)).max(0.0) } else { 1.0 };
        *pixel = *pixel * ((1.0 - opaque) * kept * bare) as f32
            + ((1.0 - clear) * (coverage.front * front + coverage.behind * bare * tones.behind)) as f32
            + (foam * foam_tone) as f32
            + ((1.0 - clear) * coverage.front) as f32 * dot;
        let [rim_v, bottom_v] = outline.glass_rows(u);
        if (rim_v..bottom_v).contains(&(v as f64)) && (sides[0]..sides[1]).contains(&(u as f64)) {
            *pixel += overlay.glare(u, sides) as f32;
        }
    }
}
