//! Colour images to the grey images that the outline is traced in.
//!
//! Of YUY2 (`Y0 U Y1 V`) the luma `Y` is taken. The grey image is the one that a lens with the intrinsics and the
//! axes of the depth image would take from the place of the colour lens; what remains between the two images is the
//! distance of the lenses ([`Settings::depth_lens_m`](super::Settings)), which the geometry knows.
//!
//! ```text
//! a = (u - ppx) / fx, b = (v - ppy) / fy           of the grey image
//! (x, y, z) = Q (a, b, 1),  x /= z, y /= z         Q: axes of the depth image to those of the colour image
//! r2 = x^2 + y^2,  f = 1 + k1 r2 + k2 r2^2 + k3 r2^3,  x *= f, y *= f
//! x' = x + 2 p1 x y + p2 (r2 + 2 x^2)
//! y' = y + 2 p2 x y + p1 (r2 + 2 y^2)
//! u' = fx' x' + ppx',  v' = fy' y' + ppy'          in the colour image
//! ```
//!
//! The distortion is the "inverse Brown-Conrady" one of the D400's colour table, projected as librealsense 2.56
//! does. It is worked out at every eighth pixel and linear between them. A grey pixel is the mean of four bilinear places,
//! as a larger pixel of a camera would be: the colour lens has the longer focal length, and edges that are sampled
//! more coarsely than they are sharp cannot be placed to a tenth of a pixel.

use super::region::Region;
use crate::usb::lens::{ColourLens, Intrinsics};

/// Pixels from one exact place to the next: with fx' = 612 and k1 = 0.2 the straight line between them is off by 0.02
/// pixel at most.
const STEP: usize = 8;
/// Parts of a pixel in the fixed-point places.
const PARTS: u32 = 256;
/// Bytes of a YUY2 pixel; the luma is the first.
const BYTES: usize = 2;

/// Makes grey images of colour images.
///
/// ```
/// use meniscus::surface::{ColourLens, Intrinsics, Rectifier, Region};
///
/// // A colour lens like the depth lens, straight and without distortion.
/// let lens = Intrinsics { width: 16, height: 16, fx: 20.0, fy: 20.0, ppx: 7.5, ppy: 7.5 };
/// let rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let rectifier = Rectifier::new(ColourLens { intrinsics: lens, distortion: [0.0; 5], rotation }, lens);
///
/// let yuy2 = vec![90; rectifier.colour_bytes()];
/// let mut grey = vec![0; rectifier.grey_bytes()];
/// rectifier.rectify(&yuy2, &mut grey, Region::whole((16, 16)));
/// assert_eq!(grey[8 * 16 + 8], 90);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectifier {
    lens: ColourLens,
    to: Intrinsics,
}

impl Rectifier {
    /// From the images of `lens` to those of a lens with the intrinsics `to`.
    #[must_use]
    pub const fn new(lens: ColourLens, to: Intrinsics) -> Self {
        Self { lens, to }
    }

    /// Bytes of a colour image.
    #[must_use]
    pub const fn colour_bytes(&self) -> usize {
        BYTES * self.lens.intrinsics.width * self.lens.intrinsics.height
    }

    /// Bytes of a grey image.
    #[must_use]
    pub const fn grey_bytes(&self) -> usize {
        self.to.width * self.to.height
    }

    /// Fills a region of `grey` (Y8, row-major) from `yuy2`; what the colour lens does not see is 0, and so is
    /// everything there if `yuy2` is not [`colour_bytes`](Self::colour_bytes) long. Other pixels stay as they are.
    pub fn rectify(&self, yuy2: &[u8], grey: &mut [u8], region: Region) {
        let Intrinsics { width, fx, fy, ppx, ppy, .. } = self.to;
        let Region { left, right, top, bottom } = region;
        let whole = yuy2.len() == self.colour_bytes();
        let rows = grey.chunks_exact_mut(width.max(1)).enumerate().take(bottom).skip(top);
        for (v, row) in rows {
            let Some(row) = row.get_mut(left..right.min(width)) else { return };
            if !whole {
                row.fill(0);
                continue;
            }
            let b = (v as f32 - ppy) / fy;
            let place = |u: usize| self.lens.pixel_of((u as f32 - ppx) / fx, b);
            let mut from = place(left);
            for (block, pixels) in row.chunks_mut(STEP).enumerate() {
                let to = place(left + (block + 1) * STEP);
                self.span(yuy2, from, to, pixels);
                from = to;
            }
        }
    }

    /// Eight pixels along a straight line of the colour image. A grey pixel covers `fx' / fx` by `fy' / fy` colour
    /// pixels; it is the mean of four places in the middles of its quarters.
    fn span(&self, yuy2: &[u8], from: (f32, f32), to: (f32, f32), pixels: &mut [u8]) {
        let parts = PARTS as f32;
        let (mut u, mut v) = (from.0 * parts, from.1 * parts);
        let (du, dv) = ((to.0 - from.0) * parts / STEP as f32, (to.1 - from.1) * parts / STEP as f32);
        let quarter = |own: f32, other: f32| (0.25 * parts * own / other) as i32;
        let (own, other) = (&self.lens.intrinsics, &self.to);
        let (across, down) = (quarter(own.fx, other.fx), quarter(own.fy, other.fy));
        for pixel in pixels {
            *pixel = self.mean(yuy2, Footprint { u: u as i32, v: v as i32, across, down }).unwrap_or(0);
            u += du;
            v += dv;
        }
    }

    /// Mean of the luma at four places around one, each bilinear: places are in parts of a pixel. `None` where one
    /// of them lies outside of the image.
    fn mean(&self, yuy2: &[u8], footprint: Footprint) -> Option<u8> {
        let Footprint { u, v, across, down } = footprint;
        let Intrinsics { width, height, .. } = self.lens.intrinsics;
        let (column, columns) = taps(u, across)?;
        let (row, rows) = taps(v, down)?;
        if column + 2 >= width || row + 2 >= height {
            return None;
        }
        let start = (row * width + column) * BYTES;
        let mut sum = 0;
        for (line, weight) in rows.into_iter().enumerate() {
            let [left, _, middle, _, right] = *yuy2.get(start + line * width * BYTES..)?.first_chunk()?;
            let [l, m, r] = columns;
            sum += weight * (l * u32::from(left) + m * u32::from(middle) + r * u32::from(right));
        }
        // Two places along each axis, each of whose weights make PARTS.
        Some(((sum + 2 * PARTS * PARTS) / (4 * PARTS * PARTS)) as u8)
    }
}

/// Centre of a grey pixel in the colour image, and the distances of its four places from it, in parts of a pixel.
#[derive(Clone, Copy)]
struct Footprint {
    u: i32,
    v: i32,
    across: i32,
    down: i32,
}

/// The first of three pixels along an axis, and the sum of the weights that they have for two places, `half` before
/// and behind `place`; with `half` below half a pixel these lie between the first and the last of the three.
fn taps(place: i32, half: i32) -> Option<(usize, [u32; 3])> {
    let half = half.min(PARTS as i32 / 2 - 1);
    // A place that is no number of a pixel saturates far outside.
    let [before, behind] = [place.saturating_sub(half), place.saturating_add(half)];
    let (before, behind) = (u32::try_from(before).ok()?, u32::try_from(behind).ok()?);
    let first = before / PARTS;
    let (f, g) = (before % PARTS, behind % PARTS);
    let weights =
        if behind / PARTS == first { [2 * PARTS - f - g, f + g, 0] } else { [PARTS - f, f + PARTS - g, g] };
    Some((first as usize, weights))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sincosf;
    extern crate std;
    use std::vec;
    use std::vec::Vec;

    const DEPTH: Intrinsics =
        Intrinsics { width: 640, height: 480, fx: 384.21, fy: 384.21, ppx: 319.48, ppy: 236.35 };
    const COLOUR: Intrinsics =
        Intrinsics { width: 640, height: 480, fx: 612.4, fy: 610.6, ppx: 322.1, ppy: 244.7 };

    /// Turned by 0.6 degrees about x and 0.8 about y, distorted.
    fn lens() -> ColourLens {
        let (sx, cx) = sincosf(0.0105);
        let (sy, cy) = sincosf(0.0140);
        ColourLens {
            intrinsics: COLOUR,
            distortion: [0.18, -0.4, 0.0006, -0.0009, 0.25],
            rotation: [[cy, 0.0, sy], [sx * sy, cx, -sx * cy], [-cx * sy, sx, cx * cy]],
        }
    }

    /// The pattern of the world by the direction in which it is seen; smooth, so that it may be sampled.
    fn world(a: f32, b: f32) -> f32 {
        let ((across, _), (_, down), (aslant, _)) =
            (sincosf(9.0 * a), sincosf(8.0 * b), sincosf(5.0 * b - 3.0 * a));
        120.0 + 60.0 * across * down + 40.0 * aslant
    }

    /// The pattern as the colour lens takes it: every pixel's direction by Newton's method on its projection.
    fn taken(lens: &ColourLens) -> Vec<u8> {
        let mut yuy2 = vec![128; 2 * 640 * 480];
        for v in 0..480_usize {
            for u in 0..640_usize {
                let (mut a, mut b) =
                    ((u as f32 - COLOUR.ppx) / COLOUR.fx, (v as f32 - COLOUR.ppy) / COLOUR.fy);
                for _ in 0..6 {
                    let (pu, pv) = lens.pixel_of(a, b);
                    a -= (pu - u as f32) / COLOUR.fx;
                    b -= (pv - v as f32) / COLOUR.fy;
                }
                yuy2[2 * (v * 640 + u)] = (world(a, b) + 0.5) as u8;
            }
        }
        yuy2
    }

    #[test]
    fn a_world_seen_through_a_turned_and_distorted_lens_comes_out_straight() {
        let rectifier = Rectifier::new(lens(), DEPTH);
        let mut grey = vec![0; rectifier.grey_bytes()];
        rectifier.rectify(&taken(&lens()), &mut grey, Region::whole((640, 480)));
        let (mut worst, mut seen) = (0.0_f32, 0);
        for (at, &got) in grey.iter().enumerate() {
            let (u, v) = (at % 640, at / 640);
            let (a, b) = ((u as f32 - DEPTH.ppx) / DEPTH.fx, (v as f32 - DEPTH.ppy) / DEPTH.fy);
            let (pu, pv) = lens().pixel_of(a, b);
            if (1.0..638.0).contains(&pu) && (1.0..478.0).contains(&pv) {
                seen += 1;
                worst = worst.max((f32::from(got) - world(a, b)).abs());
            }
        }
        // Rounded twice, and a bilinear sample of a pattern that turns once in 400 pixels: a grey level and a half.
        assert!(worst < 1.6, "{worst}");
        // The colour lens sees less of the world than the depth lens: fx / fx' by fy / fy' of it.
        assert!((0.36..0.42).contains(&(seen as f32 / grey.len() as f32)), "{seen}");
    }

    /// The longest way from the exact place of a pixel to the straight line that stands for it.
    #[test]
    fn the_straight_lines_are_near_enough() {
        let straight = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let lens =
            ColourLens { intrinsics: COLOUR, distortion: [0.2, 0.0, 0.0, 0.0, 0.0], rotation: straight };
        let at = |u: f32, v: f32| lens.pixel_of((u - DEPTH.ppx) / DEPTH.fx, (v - DEPTH.ppy) / DEPTH.fy);
        let mut worst = 0.0_f32;
        for (v, u) in (0..480).flat_map(|v| (0..640).step_by(STEP).map(move |u| (v as f32, u as f32))) {
            let (from, to) = (at(u, v), at(u + STEP as f32, v));
            if !((0.0..640.0).contains(&from.0) && (0.0..480.0).contains(&from.1)) {
                continue;
            }
            for k in 1..STEP {
                let share = k as f32 / STEP as f32;
                let (x, y) = at(u + k as f32, v);
                let line = (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
                worst = worst.max((x - line.0).abs()).max((y - line.1).abs());
            }
        }
        assert!(worst < 0.021, "{worst}");
    }

    #[test]
    fn what_the_colour_lens_does_not_see_is_black_and_a_cut_image_is_none() {
        let rectifier = Rectifier::new(lens(), DEPTH);
        let mut grey = vec![9; rectifier.grey_bytes()];
        let region = Region { left: 0, right: 600, top: 0, bottom: 400 };
        rectifier.rectify(&vec![200; rectifier.colour_bytes()], &mut grey, region);
        let at = |row: usize, column: usize| row * 640 + column;
        assert_eq!([grey[0], grey[at(240, 320)]], [0, 200]);
        assert_eq!(
            [grey[at(240, 600)], grey[at(400, 320)]],
            [9, 9],
            "outside of the region nothing is touched"
        );
        rectifier.rectify(&vec![200; rectifier.colour_bytes() - 1], &mut grey, region);
        assert_eq!([grey[at(240, 320)], grey[at(399, 599)], grey[at(400, 320)]], [0, 0, 9]);
    }
}
