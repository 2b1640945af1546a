//! The camera's images as the page gets them: the part around the glass as JPEG, with the traced surface's pixels.
//!
//! A depth image is grey from 255, near, to 1, far; 0 is a pixel without a depth. The page gives it its colours.

use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use meniscus::runtime::Mode;
use meniscus::surface::{Config, profile_abscissa};
use meniscus::units::Micros;
use meniscus_service::snapshot::TurnSnapshot;
use meniscus_service::timed_turn::TimedTurn;

/// First byte of an image.
const IMAGE: u8 = 2;

/// Depths that are distinguished, in units of the radius of the glass before and behind its axis.
const BEFORE: f32 = 2.0;
const BEHIND: f32 = 6.0;

/// Quality of the JPEG of the outline, of 100: what the depth camera's noise leaves of the edge is kept.
const QUALITY: u8 = 60;

/// Quality of the JPEG of the depth: a pixel without a depth must stay one beside others.
const DEPTH_QUALITY: u8 = 90;

/// Room beside the glass, in units of its radius, and above and below, in pixels.
const BESIDE: f32 = 2.2;
const ABOVE: usize = 12;

/// Extent of the glass, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct GlassExtent {
    /// Inner radius.
    pub(super) radius_m: f32,
    /// Height of the rim above the inner bottom.
    pub(super) rim_m: f32,
}

/// Facts that both images of a frame share.
struct Head<'h> {
    number: u32,
    time: Micros,
    /// Traced and estimated surface, pixels.
    points: [&'h [(f32, f32)]; 2],
}

/// Returns the grey of a depth: 255 at the near end of the range, 1 at the far end and beyond, 0 without a depth.
fn grey_of(depth_m: f32, [near_m, far_m]: [f32; 2]) -> u8 {
    if depth_m <= 0.0 {
        return 0;
    }
    let share = ((far_m - depth_m) / (far_m - near_m)).clamp(0.0, 1.0);
    1 + (254.0 * share) as u8
}

/// Part of the image that is shown; it stays while the glass is in it, so that the glass moves and not the room.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Window {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
}

impl Window {
    /// Around a glass at `glass_x_m`.
    fn around(config: &Config, radius_m: f32, rim_m: f32, glass_x_m: f32) -> Self {
        let size = config.image_size();
        let within = |at: f32, most: usize| (at.max(0.0) as usize).min(most);
        let (left, top) = config.pixel_of([glass_x_m - BESIDE * radius_m, -radius_m, rim_m]);
        let (right, bottom) = config.pixel_of([glass_x_m + BESIDE * radius_m, -radius_m, 0.0]);
        let (left, top) = (within(left, size.0), within(top, size.1).saturating_sub(ABOVE));
        let (right, bottom) = (within(right, size.0), (within(bottom, size.1) + ABOVE).min(size.1));
        Self { left, top, width: right.saturating_sub(left), height: bottom.saturating_sub(top) }
    }

    /// Whether the columns of a glass at `glass_x_m` are all shown.
    fn shows(&self, config: &Config, radius_m: f32, glass_x_m: f32) -> bool {
        let column = |x: f32| config.pixel_of([x, -radius_m, 0.0]).0;
        let (left, right) = (column(glass_x_m - 1.1 * radius_m), column(glass_x_m + 1.1 * radius_m));
        self.width > 0 && left >= self.left as f32 && right <= (self.left + self.width) as f32
    }

    /// The bytes of the images of frame `number`, of the outline and of the depth; `None` where there is no new one or it cannot be
    /// encoded.
    pub(super) fn images(
        &mut self,
        config: &Config,
        glass: GlassExtent,
        snapshot: &TurnSnapshot,
        number: u32,
    ) -> [Option<Vec<u8>>; 2] {
        let GlassExtent { radius_m, rim_m } = glass;
        let Some(TimedTurn { turn, .. }) = &snapshot.image_of else { return [None, None] };
        let profile = turn.profile.and_then(Result::ok);
        let glass_x_m = profile.and_then(|profile| profile.glass_x_m);
        let place = glass_x_m.unwrap_or(0.0);
        if self.width == 0 || glass_x_m.is_some_and(|x| !self.shows(config, radius_m, x)) {
            *self = Self::around(config, radius_m, rim_m, place);
        }
        let pixel = |point: usize, height: f32| {
            let [x, y, z] = config.wall_point(profile_abscissa(point) as f32, height);
            config.pixel_of([x + place, y, z])
        };
        // Without the glass's place nothing is drawn on the image: a line in the wrong place would look measured.
        let mut traced = Vec::new();
        let mut estimated = Vec::new();
        if let (Some(profile), Some(_)) = (profile, glass_x_m) {
            let points = profile.height_m.iter().zip(profile.valid).enumerate();
            traced.extend(points.filter(|(_, (_, valid))| *valid).map(|(k, (z, _))| pixel(k, *z)));
            if turn.estimate.mode != Mode::Halted {
                estimated.extend(turn.estimate.surface_m.iter().enumerate().map(|(k, z)| pixel(k, *z)));
            }
        }
        let across = config.image_size().0;
        let head = Head { number, time: turn.time, points: [&traced, &estimated] };
        let outline = self.encode(&head, None, &self.cut(&snapshot.infrared, across));
        let depth = (!snapshot.depth.is_empty()).then(|| {
            let settings = config.settings();
            let (axis_m, unit_m) = (settings.camera_distance_m, settings.depth_unit_m);
            let range_m = [axis_m - BEFORE * radius_m, axis_m + BEHIND * radius_m];
            let (pixels, _) = snapshot.depth.as_chunks::<2>();
            let grey: Vec<u8> = self
                .cut(pixels, across)
                .into_iter()
                .map(|z| grey_of(f32::from(u16::from_le_bytes(z)) * unit_m, range_m))
                .collect();
            self.encode(&head, Some(range_m), &grey)
        });
        [outline, depth.flatten()]
    }

    /// Returns the pixels of the window, of an image `across` pixels wide.
    fn cut<P: Copy>(&self, image: &[P], across: usize) -> Vec<P> {
        let rows = image.chunks_exact(across).skip(self.top).take(self.height);
        rows.filter_map(|row| row.get(self.left..self.left + self.width)).flatten().copied().collect()
    }

    /// Kind, number, time, size, depths, the two lists of pixels, then the JPEG of `grey`; everything little-endian.
    fn encode(&self, head: &Head<'_>, depths_m: Option<[f32; 2]>, grey: &[u8]) -> Option<Vec<u8>> {
        let Head { number, time, points } = *head;
        let mut bytes = Vec::with_capacity(16 * 1024);
        bytes.extend_from_slice(&[IMAGE, u8::from(depths_m.is_some()), 0, 0]);
        bytes.extend_from_slice(&number.to_le_bytes());
        bytes.extend_from_slice(&(time.0 as f64 * 1e-6).to_le_bytes());
        for count in [self.width, self.height, points[0].len(), points[1].len()] {
            bytes.extend_from_slice(&u16::try_from(count).ok()?.to_le_bytes());
        }
        for depth_m in depths_m.unwrap_or_default() {
            bytes.extend_from_slice(&depth_m.to_le_bytes());
        }
        for (u, v) in points.into_iter().flatten() {
            bytes.extend_from_slice(&(u - self.left as f32).to_le_bytes());
            bytes.extend_from_slice(&(v - self.top as f32).to_le_bytes());
        }
        let size = (u32::try_from(self.width).ok()?, u32::try_from(self.height).ok()?);
        let quality = if depths_m.is_some() { DEPTH_QUALITY } else { QUALITY };
        JpegEncoder::new_with_quality(&mut bytes, quality)
            .write_image(grey, size.0, size.1, ExtendedColorType::L8)
            .ok()?;
        Some(bytes)
    }
}
