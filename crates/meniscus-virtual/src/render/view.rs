//! The pinhole camera as the renderer sees it: points to pixels, pixels to rays. Independent of the
//! reader's `surface::deproject` on purpose.

use super::{SceneSettings, Window};
use meniscus_data::recording::Glass;

/// Columns on either side of the image centre that the glass and its stereo shadow can reach, at this focal length or
/// a shorter one; at a longer one as many more.
const WINDOW_HALF_WIDTH: (f64, f32) = (140.0, 384.21);
/// Rows above the rim and below the bottom of the glass that are rendered afresh.
const WINDOW_MARGIN: f64 = 16.0;

/// Camera at `(0, -distance, height)`, looking along `forward`.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    pub(super) width: usize,
    pub(super) height: usize,
    fx: f64,
    fy: f64,
    ppx: f64,
    ppy: f64,
    height_m: f64,
    pub(super) distance_m: f64,
    sin: f64,
    cos: f64,
    /// Focal length times baseline, pixel metres: disparity times depth.
    pub(super) stereo: f64,
}

/// A point in the image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Projected {
    pub(super) u: f64,
    pub(super) v: f64,
}

impl View {
    pub(super) fn new(settings: &SceneSettings) -> Self {
        let camera = &settings.camera;
        let lens = &camera.intrinsics;
        let (sin, cos) = f64::from(camera.camera_pitch_rad).sin_cos();
        Self {
            width: lens.width,
            height: lens.height,
            fx: lens.fx.into(),
            fy: lens.fy.into(),
            ppx: lens.ppx.into(),
            ppy: lens.ppy.into(),
            height_m: camera.camera_height_m.into(),
            distance_m: camera.camera_distance_m.into(),
            sin,
            cos,
            stereo: f64::from(lens.fx) * settings.baseline_m,
        }
    }

    /// The same camera before a glass that stands `away_m` farther; places are still from where that glass stands at X = 0.
    pub(super) fn farther(&self, away_m: f64) -> Self {
        Self { distance_m: self.distance_m + away_m, ..*self }
    }

    /// Returns the image of the point `(x, y, z)` of the room; the room's origin is the glass's at X = 0.
    pub(super) fn project(&self, [x, y, z]: [f64; 3]) -> Projected {
        let (away, up) = (y + self.distance_m, z - self.height_m);
        let depth = away * self.cos + up * self.sin;
        let down = away * self.sin - up * self.cos;
        Projected { u: self.ppx + self.fx * x / depth, v: self.ppy + self.fy * down / depth }
    }

    /// Depth of a point of the room along the optical axis.
    pub(super) fn depth(&self, [_, y, z]: [f64; 3]) -> f64 {
        (y + self.distance_m) * self.cos + (z - self.height_m) * self.sin
    }

    /// Rows that `length_m` covers at a depth.
    pub(super) fn pixels(&self, length_m: f64, depth_m: f64) -> f64 {
        self.fy * length_m / depth_m
    }

    /// Direction (right, away, up) through a pixel, one metre of depth long.
    pub(super) fn ray(&self, u: f64, v: f64) -> [f64; 3] {
        let (a, b) = ((u - self.ppx) / self.fx, (v - self.ppy) / self.fy);
        [a, self.cos + b * self.sin, self.sin - b * self.cos]
    }

    /// Depths at which a ray enters and leaves an upright cylinder around `axis_m`.
    pub(super) fn cylinder(
        &self,
        [right, away, _]: [f64; 3],
        axis_m: f64,
        radius_m: f64,
    ) -> Option<(f64, f64)> {
        let a = right * right + away * away;
        let b = right * axis_m + away * self.distance_m;
        let c = axis_m.powi(2) + self.distance_m.powi(2) - radius_m.powi(2);
        let root = (b * b - a * c).sqrt();
        (root >= 0.0).then(|| ((b - root) / a, (b + root) / a))
    }

    /// Depth at which a ray meets the level plane at `z_m`.
    pub(super) fn plane(&self, [_, _, up]: [f64; 3], z_m: f64) -> Option<f64> {
        let depth = (z_m - self.height_m) / up;
        (depth > 0.0 && depth.is_finite()).then_some(depth)
    }

    /// Point of the room at which a ray meets the plane through `point` with the normal `normal`.
    pub(super) fn on_plane(&self, ray: [f64; 3], point: [f64; 3], normal: [f64; 3]) -> Option<[f64; 3]> {
        let camera = [0.0, -self.distance_m, self.height_m];
        let dot = |a: [f64; 3]| a.iter().zip(&normal).map(|(a, n)| a * n).sum::<f64>();
        let depth = dot(std::array::from_fn(|axis| point[axis] - camera[axis])) / dot(ray);
        (depth > 0.0 && depth.is_finite())
            .then(|| std::array::from_fn(|axis| camera[axis] + depth * ray[axis]))
    }

    /// Column, at row `v`, of a vertical plane through the camera at the bearing whose tangent is given.
    pub(super) fn column_of_bearing(&self, tangent: f64, v: f64) -> f64 {
        self.ppx + self.fx * tangent * (self.cos + (v - self.ppy) / self.fy * self.sin)
    }

    /// The pixels that are rendered for each frame, from `top_m` above the inner bottom downwards.
    pub(super) fn window(&self, glass: &Glass, top_m: f64) -> Window {
        let rows = [top_m, 0.0].map(|z| {
            [-glass.radius_m, glass.radius_m]
                .map(|y| self.project([0.0, y, z]).v.clamp(0.0, self.height as f64))
        });
        let (top, bottom) = (rows[0][0].min(rows[0][1]), rows[1][0].max(rows[1][1]));
        let half = WINDOW_HALF_WIDTH.0 * (self.fx / f64::from(WINDOW_HALF_WIDTH.1)).max(1.0);
        let clamp = |value: f64, end: usize| value.clamp(0.0, end as f64) as usize;
        Window {
            left: clamp(self.ppx - half, self.width),
            right: clamp(self.ppx + half, self.width),
            top: clamp(top - WINDOW_MARGIN, self.height),
            bottom: clamp(bottom + WINDOW_MARGIN, self.height),
        }
    }
}
