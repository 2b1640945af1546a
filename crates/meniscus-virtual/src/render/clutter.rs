//! Disturbances of the view: foam, a highlight on the glass, a finger before it, a liquid that is clear.

use super::noise::mix;
use super::outline::Outline;
use super::view::View;

/// Tone of foam, and by how much its bubbles scatter it, grey levels.
const FOAM_TONE: f64 = 222.0;
const FOAM_GRAIN: f64 = 14.0;
/// Light of a highlight's middle, grey levels.
const GLARE_LIGHT: f64 = 210.0;
/// A highlight brighter than this blinds the stereo matching.
const GLARE_BLINDS: f64 = 70.0;
/// Tone of skin in the near infrared.
const SKIN_TONE: f64 = 176.0;

/// A finger that points across the glass, level, from its left or right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finger {
    /// Height of its middle above the inner bottom, metres.
    pub height_m: f64,
    /// Radius, metres.
    pub radius_m: f64,
    /// Reach of its tip, in radii of the glass from the axis; it comes from the left.
    pub tip: f64,
    /// Distance of its middle before the glass, metres.
    pub before_m: f64,
    /// It comes from the right instead.
    pub from_right: bool,
}

/// A highlight: a lamp mirrored by the glass as an upright streak.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glare {
    /// Place across the silhouette, -1 to 1.
    pub across: f64,
    /// Standard deviation of its width, pixels.
    pub width_px: f64,
}

/// Everything that disturbs; nothing by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clutter {
    /// Height of foam on the liquid, metres.
    pub foam_m: f64,
    /// Span of the foam across the silhouette, -1 to 1.
    pub foam_span: [f64; 2],
    /// A highlight.
    pub glare: Option<Glare>,
    /// A finger.
    pub finger: Option<Finger>,
    /// Share of the background's light that the liquid lets through; above 1/2 the stereo matching sees
    /// through it too.
    pub clear: f64,
}

/// The clutter in the image of one frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Overlay {
    clutter: Clutter,
    seed: u64,
    finger: Option<Capsule>,
}

/// The finger's outline: everything within a radius of a line.
#[derive(Clone, Copy, Debug)]
struct Capsule {
    from: [f64; 2],
    to: [f64; 2],
    radius_px: f64,
    /// Depth of its middle and its radius, metres.
    depth_m: f64,
    radius_m: f64,
}

impl Overlay {
    pub(super) fn new(view: &View, clutter: Clutter, axis_m: f64, radius_m: f64, seed: u64) -> Self {
        let finger = clutter.finger.map(|finger| {
            let side = if finger.from_right { 1.0 } else { -1.0 };
            let y = -radius_m - finger.before_m;
            let ends = [3.0, finger.tip].map(|reach| {
                let seen = view.project([axis_m + side * reach * radius_m, y, finger.height_m]);
                [seen.u, seen.v]
            });
            let depth_m = view.depth([axis_m, y, finger.height_m]);
            let radius_px = view.pixels(finger.radius_m, depth_m);
            Capsule { from: ends[0], to: ends[1], radius_px, depth_m, radius_m: finger.radius_m }
        });
        Self { clutter, seed, finger }
    }

    pub(super) fn clear(&self) -> f64 {
        self.clutter.clear
    }

    /// Foam's share of a pixel, and its tone.
    pub(super) fn foam(
        &self,
        view: &View,
        outline: &Outline,
        u: usize,
        v: usize,
        sides: [f64; 2],
    ) -> (f64, f64) {
        let [from, to] = self.clutter.foam_span;
        let across = Outline::across(u as f64, sides);
        if self.clutter.foam_m <= 0.0 || across < from || across > to {
            return (0.0, 0.0);
        }
        // It thins out towards its ends.
        let edge = ((across - from).min(to - across) / 0.15).min(1.0);
        let depth_m = outline.front_depth(view, u, v).unwrap_or(view.distance_m);
        let rows = edge * view.pixels(self.clutter.foam_m, depth_m);
        let grain = mix(self.seed ^ mix(((v as u64) << 20) | u as u64)) as f64 / u64::MAX as f64 - 0.5;
        let facing = (1.0 - across * across).max(0.0).sqrt();
        (outline.above(u, v, sides, rows), (FOAM_TONE + FOAM_GRAIN * grain) * (0.7 + 0.3 * facing))
    }

    /// Light of the highlight on a pixel of the glass.
    pub(super) fn glare(&self, u: usize, sides: [f64; 2]) -> f64 {
        self.clutter.glare.map_or(0.0, |glare| {
            let middle = 0.5 * (sides[0] + sides[1] + glare.across * (sides[1] - sides[0]));
            GLARE_LIGHT * (-0.5 * ((u as f64 - middle) / glare.width_px).powi(2)).exp()
        })
    }

    /// Whether the highlight blinds the stereo matching.
    pub(super) fn blinds(&self, u: usize, sides: [f64; 2]) -> bool {
        self.glare(u, sides) > GLARE_BLINDS
    }

    /// The finger's share of a pixel, its tone and its depth.
    pub(super) fn finger(&self, u: usize, v: usize) -> Option<(f64, f64, f64)> {
        let Capsule { from, to, radius_px, depth_m, radius_m } = self.finger?;
        let along = [to[0] - from[0], to[1] - from[1]];
        let at = [u as f64 - from[0], v as f64 - from[1]];
        let length2 = along[0] * along[0] + along[1] * along[1];
        let t = ((at[0] * along[0] + at[1] * along[1]) / length2).clamp(0.0, 1.0);
        let off_px = (at[0] - t * along[0]).hypot(at[1] - t * along[1]);
        let share = (radius_px - off_px + 0.5).clamp(0.0, 1.0);
        let bulge = (1.0 - (off_px / radius_px).powi(2)).max(0.0).sqrt();
        (share > 0.0).then_some((share, SKIN_TONE * (0.7 + 0.3 * bulge), depth_m - radius_m * bulge))
    }
}
