//! Contact line of a first mode on the wall that faces the camera, fitted to points of it.
//!
//! `z = c + a x - b y0`, `y0 = sqrt(R^2 - x^2)`, for the surface `c + (a x + b y)` at the wall of an upright circular glass
//! (Ibrahim, Liquid Sloshing Dynamics, 2005). In the shipped recording of glycerine, whose contact lines span 25 mm, they differ
//! from the nearest one by 1.1 mm at most (`tests/study.rs`).

use super::config::Config;
use crate::math::sqrtf;

/// A first mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FirstMode {
    /// Mean height `c`, metres.
    pub(super) mean_m: f32,
    /// Slope `a` across the line of sight.
    pub(super) along: f32,
    /// Slope `b` away from the camera.
    pub(super) towards: f32,
    /// Radius of the glass `R`, metres.
    pub(super) radius_m: f32,
}

impl FirstMode {
    /// The mode nearest to `points`, `x` and height in metres, by least squares; `None` if they do not fix it.
    ///
    /// Normal equations of the basis `1, x, -y0`, by Cramer's rule.
    pub(super) fn fit(config: &Config, points: impl Iterator<Item = (f32, f32)>) -> Option<Self> {
        Sums::of(config, points).mode(config)
    }

    /// The same, or the nearest straight line where the points lie on an arc that is too short to fix a mode.
    pub(super) fn fit_arc(config: &Config, points: impl Iterator<Item = (f32, f32)>) -> Option<Self> {
        let sums = Sums::of(config, points);
        sums.mode(config).or_else(|| sums.line(config))
    }

    fn of(config: &Config, [c, a, b]: [f32; 3]) -> Self {
        let radius_m = config.settings.radius_m;
        Self { mean_m: c + config.settings.fill_m, along: a / radius_m, towards: b / radius_m, radius_m }
    }

    /// Distance `y0` of the wall that faces the camera before the axis at `x`, metres.
    pub(super) fn front_m(&self, x_m: f32) -> f32 {
        let x = x_m.max(-self.radius_m).min(self.radius_m);
        sqrtf((self.radius_m * self.radius_m - x * x).max(0.0))
    }

    /// Height of the contact line at `x`, metres.
    pub(super) fn contact_m(&self, x_m: f32) -> f32 {
        let x = x_m.max(-self.radius_m).min(self.radius_m);
        self.mean_m + self.along * x - self.towards * self.front_m(x)
    }
}

/// Normal equations of some points; `x` is in radii, heights are counted from the fill.
struct Sums {
    matrix: [[f32; 3]; 3],
    heights: [f32; 3],
    count: f32,
}

/// Least determinant of the equations of `n` points, in units of `n^3` and `n^2`: points on a short arc fix no mode, and
/// points in one place no line.
const LEAST_ARC: f32 = 1e-4;

impl Sums {
    fn of(config: &Config, points: impl Iterator<Item = (f32, f32)>) -> Self {
        let mut sums = Self { matrix: [[0.0; 3]; 3], heights: [0.0; 3], count: 0.0 };
        for (x_m, z_m) in points {
            let s = x_m / config.settings.radius_m;
            let basis = [1.0, s, -sqrtf((1.0 - s * s).max(0.0))];
            for ((row, height), &p) in sums.matrix.iter_mut().zip(&mut sums.heights).zip(&basis) {
                row.iter_mut().zip(&basis).for_each(|(sum, &q)| *sum += p * q);
                *height += p * (z_m - config.settings.fill_m);
            }
            sums.count += 1.0;
        }
        sums
    }

    fn mode(&self, config: &Config) -> Option<FirstMode> {
        // The matrix is symmetric: its rows are its columns.
        let ([p, q, r], v) = (self.matrix, self.heights);
        let whole = triple(p, q, r);
        if whole <= LEAST_ARC * self.count * self.count * self.count {
            return None;
        }
        let [c, a, b] = [triple(v, q, r) / whole, triple(p, v, r) / whole, triple(p, q, v) / whole];
        Some(FirstMode::of(config, [c, a, b]))
    }

    fn line(&self, config: &Config) -> Option<FirstMode> {
        let ([[n, s, _], [_, ss, _], _], [z, sz, _]) = (self.matrix, self.heights);
        let whole = n * ss - s * s;
        if whole <= LEAST_ARC * n * n {
            return None;
        }
        Some(FirstMode::of(config, [(z * ss - s * sz) / whole, (n * sz - s * z) / whole, 0.0]))
    }
}

/// The determinant of three columns.
fn triple([a, b, c]: [f32; 3], [d, e, f]: [f32; 3], [g, h, i]: [f32; 3]) -> f32 {
    a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
}
