//! Lenses of the camera: pinhole intrinsics, and the colour lens with its distortion.

/// Pinhole intrinsics of an image in pixels; pixel `u` is centred on the number `u`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intrinsics {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Focal length, horizontal.
    pub fx: f32,
    /// Focal length, vertical.
    pub fy: f32,
    /// Principal point, horizontal.
    pub ppx: f32,
    /// Principal point, vertical.
    pub ppy: f32,
}

/// The lens of the colour image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColourLens {
    /// Of the colour image.
    pub intrinsics: Intrinsics,
    /// k1, k2, p1, p2, k3.
    pub distortion: [f32; 5],
    /// Rows of `Q`, which turns directions from the axes of the depth image to those of the colour image.
    pub rotation: [[f32; 3]; 3],
}

impl ColourLens {
    /// Returns the pixel at which the lens sees the direction `(a, b, 1)` of the depth image's axes.
    #[must_use]
    pub fn pixel_of(&self, a: f32, b: f32) -> (f32, f32) {
        let [k1, k2, p1, p2, k3] = self.distortion;
        let [x, y, z] = self.rotation.map(|[r0, r1, r2]| r0 * a + r1 * b + r2);
        let (x, y) = (x / z, y / z);
        let r2 = x * x + y * y;
        let f = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let (x, y) = (x * f, y * f);
        let across = x + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
        let down = y + 2.0 * p2 * x * y + p1 * (r2 + 2.0 * y * y);
        let lens = &self.intrinsics;
        (lens.fx * across + lens.ppx, lens.fy * down + lens.ppy)
    }
}
