//! Refraction by the glass wall: which point of the inner wall a ray meets.
//!
//! A wall of thickness `t` and index `n` around the inner radius `R` is a weak lens. Seen from above, with the
//! impact parameter `p` of the ray (its distance from the axis):
//!
//! ```text
//! outside  sin a = p / (R + t)      in the glass  p' = p / n      inner wall  sin b = p' / R
//! ```
//!
//! (Snell's law; p' is constant along a straight ray). As `n R > R + t`, liquid at the inner wall fills the whole
//! silhouette of the outer one, and a point of the inner wall is seen up to `t` farther from the axis than it is.
//! A ray that rises by `s` in a metre rises by `s / sqrt(n^2 + (n^2 - 1) s^2)` in the glass; the square root is
//! also the index seen from above.

use super::config::Config;
use super::deproject::Ray;
use crate::math::sqrtf;

/// Index of refraction of glass, near infrared (soda-lime glass 1.51, borosilicate 1.47).
const INDEX: f32 = 1.5;
/// A thinner wall is taken for none, metres: what the silhouette tells is not more certain.
const THINNEST_M: f32 = 6e-4;

/// Glass wall before the liquid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GlassWall {
    pub(super) thickness_m: f32,
}

/// Point of the inner wall, from the glass axis: right, height above the inner bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct InnerPoint {
    pub(super) x_m: f32,
    pub(super) z_m: f32,
}

impl GlassWall {
    /// The wall of the settings, or the one that the silhouette's radius tells.
    pub(super) fn of(config: &Config, silhouette_m: Option<f32>) -> Self {
        let settings = &config.settings;
        let measured = || {
            let wall = silhouette_m.map_or(0.0, |radius| radius - settings.radius_m);
            if wall < THINNEST_M { 0.0 } else { wall.min(super::config::THICKEST_WALL_M) }
        };
        Self { thickness_m: settings.wall_m.unwrap_or_else(measured) }
    }

    /// Whether rays are bent at all.
    pub(super) fn bends(self) -> bool {
        self.thickness_m > 0.0
    }

    /// Distance by which stereo sees the middle of the inner wall too near: `t (1 - 1 / n)`, metres.
    pub(super) fn lift_m(self) -> f32 {
        self.thickness_m * (1.0 - 1.0 / INDEX)
    }

    /// The point of the inner wall that `ray` meets, the axis of the glass being at `axis_m` and `offset_m` farther
    /// than the settings state; `None` if the ray passes by.
    pub(super) fn inner_point(
        self,
        config: &Config,
        ray: Ray,
        axis_m: f32,
        offset_m: f32,
    ) -> Option<InnerPoint> {
        let [height_m, distance_m] = config.camera.place();
        let inner = config.settings.radius_m;
        let outer = inner + self.thickness_m;
        let along = sqrtf(ray.right * ray.right + ray.away * ray.away);
        let (dx, dy, s) = (ray.right / along, ray.away / along, ray.up / along);
        let (ox, oy) = (-axis_m, -(distance_m + offset_m));
        let b = ox * dx + oy * dy;
        let to_outer = -b - sqrtf(positive(b * b - (ox * ox + oy * oy - outer * outer))?);
        let (hx, hy) = (ox + to_outer * dx, oy + to_outer * dy);
        let (nx, ny) = (hx / outer, hy / outer);
        // Snell's law for vectors: d' = r d + (r c - sqrt(1 - r^2 (1 - c^2))) n, r = 1 / index, c = -d . n.
        let index = sqrtf(INDEX * INDEX + (INDEX * INDEX - 1.0) * s * s);
        let (r, c) = (1.0 / index, -(dx * nx + dy * ny));
        let k = r * c - sqrtf(positive(1.0 - r * r * (1.0 - c * c))?);
        let (gx, gy) = (r * dx + k * nx, r * dy + k * ny);
        let g = hx * gx + hy * gy;
        let in_glass = -g - sqrtf(positive(g * g - (outer * outer - inner * inner))?);
        Some(InnerPoint { x_m: hx + in_glass * gx, z_m: height_m + s * to_outer + s * r * in_glass })
    }
}

fn positive(value: f32) -> Option<f32> {
    (value >= 0.0).then_some(value)
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "a test may take the platform's functions")]
mod tests {
    use super::*;
    use crate::surface::Settings;

    fn point(thickness_m: f32, column: f32) -> InnerPoint {
        let config = Config::new(Settings::default()).unwrap();
        let ray = config.camera.ray(column, 200.0);
        GlassWall { thickness_m }.inner_point(&config, ray, 0.0, 0.0).unwrap()
    }

    /// Snell's law in angles: `phi = asin(p / (n R)) + asin(p / R_o) - asin(p / (n R_o))`.
    #[test]
    fn the_point_is_that_of_snells_law_in_angles() {
        let config = Config::new(Settings { camera_pitch_rad: 0.0, ..Settings::default() }).unwrap();
        for (thickness, column) in [(0.0_f64, 340.0_f32), (0.0012, 345.0), (0.003, 350.0), (0.004, 353.0)] {
            // A level ray: its row is that of the optical axis.
            let ray = config.camera.ray(column, 236.35);
            let found =
                GlassWall { thickness_m: thickness as f32 }.inner_point(&config, ray, 0.0, 0.0).unwrap();
            let bearing = (f64::from(column - 319.48) / 384.21).atan();
            let (p, outer) = (0.4 * bearing.sin(), 0.035 + thickness);
            let phi = (p / (1.5 * 0.035)).asin() + (p / outer).asin() - (p / (1.5 * outer)).asin();
            let x = 0.035 * (phi - bearing).sin();
            assert!((f64::from(found.x_m) - x).abs() < 2e-5, "{thickness} {column}: {found:?} {x}");
        }
    }

    #[test]
    fn a_thick_wall_shows_the_liquid_farther_from_the_axis_than_it_is() {
        assert!(point(0.003, 348.0).x_m < point(0.0, 348.0).x_m - 5e-4);
        // Beyond the inner radius the inner wall is seen through a thick glass alone.
        let config = Config::new(Settings::default()).unwrap();
        let ray = config.camera.ray(354.5, 200.0);
        assert!(GlassWall { thickness_m: 0.0 }.inner_point(&config, ray, 0.0, 0.0).is_none());
        assert!(GlassWall { thickness_m: 0.003 }.inner_point(&config, ray, 0.0, 0.0).is_some());
    }
}
