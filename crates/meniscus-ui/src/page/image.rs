//! The camera's image as the page gets it: the part around the glass as JPEG, with the traced surface's pixels.

use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use meniscus::runtime::Mode;
use meniscus::surface::{Config, profile_abscissa};
use meniscus_service::snapshot::TurnSnapshot;

/// First byte of an image.
const IMAGE: u8 = 2;

/// Quality of the JPEG, of 100: what the depth camera's noise leaves of the edge is kept.
const QUALITY: u8 = 60;

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

    /// The bytes of image `number`; `None` if there is none yet or it cannot be encoded.
    pub(super) fn image(
        &mut self,
        config: &Config,
        glass: GlassExtent,
        snapshot: &TurnSnapshot,
        number: u32,
    ) -> Option<Vec<u8>> {
        let GlassExtent { radius_m, rim_m } = glass;
        let turn = &snapshot.image_of?.turn;
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
        self.encode(config.image_size().0, snapshot, number, [&traced, &estimated])
    }

    /// Kind, number, time, size, the two lists of pixels, then the JPEG; everything little-endian.
    fn encode(
        &self,
        across: usize,
        snapshot: &TurnSnapshot,
        number: u32,
        points: [&[(f32, f32)]; 2],
    ) -> Option<Vec<u8>> {
        let rows = snapshot.infrared.chunks_exact(across).skip(self.top).take(self.height);
        let cut: Vec<u8> =
            rows.filter_map(|row| row.get(self.left..self.left + self.width)).flatten().copied().collect();
        let mut bytes = Vec::with_capacity(16 * 1024);
        bytes.extend_from_slice(&[IMAGE, 0, 0, 0]);
        bytes.extend_from_slice(&number.to_le_bytes());
        bytes.extend_from_slice(&(snapshot.image_of?.turn.time.0 as f64 * 1e-6).to_le_bytes());
        for count in [self.width, self.height, points[0].len(), points[1].len()] {
            bytes.extend_from_slice(&u16::try_from(count).ok()?.to_le_bytes());
        }
        for (u, v) in points.into_iter().flatten() {
            bytes.extend_from_slice(&(u - self.left as f32).to_le_bytes());
            bytes.extend_from_slice(&(v - self.top as f32).to_le_bytes());
        }
        let size = (u32::try_from(self.width).ok()?, u32::try_from(self.height).ok()?);
        JpegEncoder::new_with_quality(&mut bytes, QUALITY)
            .write_image(&cut, size.0, size.1, ExtendedColorType::L8)
            .ok()?;
        Some(bytes)
    }
}
