//! The pinhole camera in front of the glass: pixel and depth to a point in the frame of the glass.
//!
//! Frame: `x` right, `y` away from the camera, `z` up, origin at the centre of the inner bottom when
//! the glass stands at X = 0; the camera stands at `(0, -D, H)` and looks up by the pitch `p`.
//!
//! ```text
//! a = (u - ppx) / fx          b = (v - ppy) / fy          Z = depth along the optical axis
//! x = a Z                     y + D = Z (cos p + b sin p)   z - H = Z (sin p - b cos p)
//! ```

use super::settings::Settings;
use crate::math::{sincosf, sqrtf};
use crate::usb::lens::Intrinsics;

/// Intrinsics and place of the camera, with the sine and cosine of the pitch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Camera {
    lens: Intrinsics,
    height_m: f32,
    distance_m: f32,
    radius_m: f32,
    sin: f32,
    cos: f32,
}

/// One side of a silhouette: its sign (-1: left, 1: right), and the radius of the cylinder.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    pub(super) sign: f32,
    pub(super) radius_m: f32,
}

/// Direction in which a pixel looks: the ray's components per metre of depth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    /// To the right.
    pub(super) right: f32,
    /// Away from the camera, horizontally.
    pub(super) away: f32,
    /// Upwards.
    pub(super) up: f32,
}

impl Ray {
    /// The same ray turned to the right.
    pub(super) fn to_the_right(self, right: f32) -> Self {
        Self { right, ..self }
    }
}

impl Camera {
    pub(super) fn new(settings: &Settings) -> Self {
        let (sin, cos) = sincosf(settings.camera_pitch_rad);
        Self {
            lens: settings.intrinsics,
            height_m: settings.camera_height_m,
            distance_m: settings.camera_distance_m,
            radius_m: settings.radius_m,
            sin,
            cos,
        }
    }

    /// The same camera moved right, down and forward along its own axes. The axis of the glass moves to the left
    /// for it as far as it moves to the right; everything else here is the same.
    ///
    /// Forward is `(cos p, sin p)` and down `(sin p, -cos p)` in the plane of `y` and `z`.
    pub(super) fn moved(&self, [_, down, forward]: [f32; 3]) -> Self {
        Self {
            height_m: self.height_m + forward * self.sin - down * self.cos,
            distance_m: self.distance_m - forward * self.cos - down * self.sin,
            ..*self
        }
    }

    /// Pixel position at which a lens of the same intrinsics sees the point at `depth_m` on the ray through
    /// `(u, v)`, if it stands right, down and forward of this one.
    pub(super) fn seen_from(
        &self,
        [right, down, forward]: [f32; 3],
        u: f32,
        v: f32,
        depth_m: f32,
    ) -> (f32, f32) {
        let lens = &self.lens;
        let (a, b) = ((u - lens.ppx) / lens.fx, (v - lens.ppy) / lens.fy);
        let depth = depth_m - forward;
        (
            lens.ppx + lens.fx * (a * depth_m - right) / depth,
            lens.ppy + lens.fy * (b * depth_m - down) / depth,
        )
    }

    /// The ray through pixel position `(u, v)`.
    pub(super) fn ray(&self, u: f32, v: f32) -> Ray {
        self.level(v).to_the_right(self.across(u))
    }

    /// Returns how far to the right column `u` looks.
    pub(super) fn across(&self, u: f32) -> f32 {
        (u - self.lens.ppx) / self.lens.fx
    }

    /// The ray of row `v` straight ahead; all rays of the row differ from it by [`Self::across`] alone.
    pub(super) fn level(&self, v: f32) -> Ray {
        let b = (v - self.lens.ppy) / self.lens.fy;
        Ray { right: 0.0, away: self.cos + b * self.sin, up: self.sin - b * self.cos }
    }

    /// `x` and `z` of the point at `depth_m` on the ray.
    pub(super) fn point(&self, ray: Ray, depth_m: f32) -> (f32, f32) {
        (ray.right * depth_m, self.height_m + ray.up * depth_m)
    }

    /// Metres that the ray rises in a metre of depth.
    pub(super) fn rise(&self, ray: Ray) -> f32 {
        ray.up
    }

    /// Row of a point at `height_m`, `distance_m` away horizontally.
    pub(super) fn row_of(&self, height_m: f32, distance_m: f32) -> f32 {
        // From y + D = Z (cos p + b sin p), z - H = Z (sin p - b cos p), solved for b.
        let up = (height_m - self.height_m) / distance_m;
        let b = (self.sin - up * self.cos) / (self.cos + up * self.sin);
        self.lens.ppy + self.lens.fy * b
    }

    /// Column and row of a point `x_m` to the right, `distance_m` away horizontally, at `height_m`.
    pub(super) fn pixel_of(&self, x_m: f32, distance_m: f32, height_m: f32) -> (f32, f32) {
        let depth_m = distance_m * self.cos + (height_m - self.height_m) * self.sin;
        (self.lens.ppx + self.lens.fx * x_m / depth_m, self.row_of(height_m, distance_m))
    }

    /// Column of the glass axis at `x_m`.
    pub(super) fn column_of(&self, x_m: f32) -> f32 {
        self.lens.ppx + self.lens.fx * x_m / self.distance_m
    }

    /// Depth at which the ray meets the wall that faces the camera, the glass axis being at `axis_m`;
    /// `None` if it passes by.
    ///
    /// `(t right - X)^2 + (t away - D)^2 = R^2`, the smaller root `t`.
    pub(super) fn wall_depth(&self, ray: Ray, axis_m: f32) -> Option<f32> {
        let a = ray.right * ray.right + ray.away * ray.away;
        let b = ray.right * axis_m + ray.away * self.distance_m;
        let c = axis_m * axis_m + self.distance_m * self.distance_m - self.radius_m * self.radius_m;
        let discriminant = b * b - a * c;
        (discriminant > 0.0).then(|| (b - sqrtf(discriminant)) / a)
    }

    /// Tangent of the angle to the right under which a ray is seen from above.
    pub(super) fn bearing(&self, ray: Ray) -> f32 {
        ray.right / ray.away
    }

    /// Position X of the axis of the cylinder whose silhouette is tangent to two vertical planes
    /// through the camera at the bearings `l` and `r`.
    ///
    /// The axis lies on the bisector: `X = D tan((atan l + atan r) / 2)`. With `s = l + r` and
    /// `q = 1 - l r`, `tan(angle / 2) = s / (q + sqrt(q^2 + s^2))`. The silhouette is wider than the
    /// diameter (tangent rays meet the cylinder in front of its axis); the bisector does not care.
    pub(super) fn axis_of(&self, left: f32, right: f32) -> f32 {
        let s = left + right;
        let q = 1.0 - left * right;
        self.distance_m * s / (q + sqrtf(q * q + s * s))
    }

    /// Position X of the axis of the cylinder of radius `radius_m` of which one side of the silhouette is seen at
    /// the bearing `edge` (`side` -1: left, 1: right), the axis being near `near_m`.
    ///
    /// `tan(atan e - side asin(R / A)) = (e - side s) / (1 + side e s)`, `s = R / sqrt(A^2 - R^2)`,
    /// `A^2 = D^2 + X^2`.
    pub(super) fn axis_beside(&self, edge: f32, side: Side, near_m: f32) -> f32 {
        let Side { sign, radius_m } = side;
        let away = self.distance_m * self.distance_m + near_m * near_m;
        let s = sign * radius_m / sqrtf(away - radius_m * radius_m);
        self.distance_m * (edge - s) / (1.0 + edge * s)
    }

    /// Column in row `row` of the vertical plane that is seen in column `u` of row `from`.
    pub(super) fn follow(&self, u: f32, from: f32, row: f32) -> f32 {
        let away = |v: f32| self.cos + (v - self.lens.ppy) / self.lens.fy * self.sin;
        self.lens.ppx + (u - self.lens.ppx) * away(row) / away(from)
    }

    /// Radius of a cylinder with its axis at `axis_m`, `distance_m` away, whose silhouette is tangent to two vertical
    /// planes at two bearings `l` and `r`.
    ///
    /// `R = A sin h`, `h` half of the angle between them: with `t = tan 2h = (r - l) / (1 + l r)`,
    /// `sin^2 h = (1 - 1 / sqrt(1 + t^2)) / 2`.
    pub(super) fn silhouette_radius([left, right]: [f32; 2], [axis_m, distance_m]: [f32; 2]) -> f32 {
        let t = (right - left) / (1.0 + left * right);
        let sin2 = 0.5 * (1.0 - 1.0 / sqrtf(1.0 + t * t));
        sqrtf((axis_m * axis_m + distance_m * distance_m) * sin2)
    }

    /// Height and distance of the camera, metres.
    pub(super) fn place(&self) -> [f32; 2] {
        [self.height_m, self.distance_m]
    }

    /// Height of a pixel at the wall that faces the camera, metres.
    pub(super) fn pitch_m(&self) -> f32 {
        (self.distance_m - self.radius_m) / self.lens.fy
    }

    /// Tangent of half the angle that the silhouette subtends, `R / sqrt(D^2 - R^2)`, straight ahead.
    pub(super) fn silhouette_slope(&self) -> f32 {
        self.radius_m / sqrtf(self.distance_m * self.distance_m - self.radius_m * self.radius_m)
    }
}
