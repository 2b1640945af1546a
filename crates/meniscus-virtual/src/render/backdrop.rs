//! Still parts of the scene: wall, table, vignetting, the projector's dots; rendered once.

use super::SceneSettings;
use super::noise::{Noise, mix};
use super::sensor::{expose, measure_depth};
use super::view::View;
use meniscus::surface::Liquid;

/// The wall behind, metres beyond the glass axis.
const WALL_Y_M: f64 = 0.35;
/// The table top below the inner bottom of the glass.
const TABLE_Z_M: f64 = -0.004;
/// The table's near end, metres from the camera.
const TABLE_NEAR_M: f64 = 0.25;
/// Share of pixels on which a projector dot is centred.
const DOT_SHARE: f64 = 0.06;

/// Grey levels of the scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tones {
    wall: f64,
    table: f64,
    /// Liquid at the front wall, seen head-on.
    pub(super) front: f64,
    /// Liquid surface behind the contact line; it mirrors some of the wall of the room.
    pub(super) behind: f64,
}

/// Tones for a dark or a bright liquid.
pub(super) fn tones(settings: &SceneSettings) -> Tones {
    let (wall, table, front) = match settings.camera.liquid {
        Liquid::Dark => (165.0, 140.0, 38.0),
        Liquid::Bright => (45.0, 60.0, 190.0),
        // Water of 70 mm in light of 850 nm before a bright card, as the path tracer has it.
        Liquid::Clear => (200.0, 170.0, 140.0),
    };
    let front = settings.tone.unwrap_or(front);
    Tones { wall, table, front, behind: front + settings.mirror * (wall - front) }
}

/// The cached background, of the size of the image.
#[derive(Clone, Debug)]
pub(super) struct Backdrop {
    /// Grey levels before blur and vignetting, without dots.
    pub(super) grey: Vec<f32>,
    /// Disparity, pixels; 0 where nothing is.
    pub(super) disparity: Vec<f32>,
    /// Projector dots, 0 to 1.
    pub(super) dots: Vec<f32>,
    /// Share of the light that the lens passes.
    pub(super) vignette: Vec<f32>,
    /// The finished background as bytes.
    pub(super) infrared: Vec<u8>,
    pub(super) depth: Vec<u8>,
}

impl Backdrop {
    pub(super) fn new(settings: &SceneSettings, view: &View, noise: &Noise) -> Self {
        let tones = tones(settings);
        let pixels = view.width * view.height;
        let mut backdrop = Self {
            grey: Vec::with_capacity(pixels),
            disparity: Vec::with_capacity(pixels),
            dots: dots(settings, view.width, view.height),
            vignette: Vec::with_capacity(pixels),
            infrared: vec![0; pixels],
            depth: vec![0; 2 * pixels],
        };
        for v in 0..view.height {
            for u in 0..view.width {
                let ray = view.ray(u as f64, v as f64);
                let wall = (WALL_Y_M + view.distance_m) / ray[1];
                let table = view.plane(ray, TABLE_Z_M).filter(|depth| *depth < wall);
                let (depth, grey) = match table {
                    Some(depth) if depth * ray[1] < TABLE_NEAR_M => (f64::INFINITY, 0.5 * tones.table),
                    Some(depth) => (depth, tones.table),
                    None => (wall, tones.wall),
                };
                backdrop.grey.push(grey as f32);
                backdrop.disparity.push((view.stereo / depth) as f32);
                // Cosine to the fourth of the angle to the optical axis.
                let across =
                    ((u as f64 / view.width as f64 - 0.5).hypot(v as f64 / view.height as f64 - 0.5)).powi(2);
                backdrop.vignette.push((1.0 + 0.8 * across).powi(-2) as f32);
            }
        }
        backdrop.finish(settings, view, noise);
        backdrop
    }

    /// Freezes one noisy picture of the background; the window around the glass is painted over it.
    fn finish(&mut self, settings: &SceneSettings, view: &View, noise: &Noise) {
        let (mut scratch, mut correlated) = (Vec::new(), vec![0.0; self.disparity.len()]);
        noise.correlated(settings.seed, view.width, &mut scratch, &mut correlated);
        for v in 0..view.height {
            let white = noise.row(settings.seed.wrapping_add(mix(v as u64)), view.width);
            for (u, white) in white.iter().enumerate() {
                let at = v * view.width + u;
                let lit =
                    self.grey[at] + self.dot(settings, u, v, view.width, self.disparity[at], self.grey[at]);
                self.infrared[at] = expose(settings, lit * self.vignette[at], *white);
                let raw = measure_depth(settings, view, self.disparity[at], correlated[at]);
                self.depth[2 * at..2 * at + 2].copy_from_slice(&raw.to_le_bytes());
            }
        }
    }

    /// Light of the projector's dots on a surface; the pattern shifts with the surface's disparity.
    pub(super) fn dot(
        &self,
        settings: &SceneSettings,
        u: usize,
        v: usize,
        width: usize,
        disparity: f32,
        grey: f32,
    ) -> f32 {
        let column = (u + disparity as usize).min(width - 1);
        self.dots[v * width + column] * settings.dots as f32 * grey / 255.0
    }
}

/// Dots at random pixels, a pixel and a half wide.
fn dots(settings: &SceneSettings, width: usize, height: usize) -> Vec<f32> {
    let mut dots = vec![0.0; width * height];
    for v in 1..height - 1 {
        for u in 1..width - 1 {
            let draw = mix(settings.seed ^ mix((v * width + u) as u64)) as f64 / u64::MAX as f64;
            if draw < DOT_SHARE {
                for (dv, du, light) in [(0, 0, 1.0), (0, 1, 0.3), (1, 0, 0.3), (0, -1, 0.3), (-1, 0, 0.3)] {
                    let at = (v as isize + dv) as usize * width + (u as isize + du) as usize;
                    dots[at] = f32::max(dots[at], light);
                }
            }
        }
    }
    dots
}
