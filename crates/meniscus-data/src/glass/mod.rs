//! The glass: a vessel of revolution with its fill.

mod error;
mod profile;

pub use error::{MOST_POINTS, WallError};
pub use profile::{Nearest, Profile};

use serde::{Deserialize, Serialize};

/// A glass of revolution; lengths in metres, inner surfaces.
///
/// ```
/// use meniscus_data::glass::{Glass, WallShape};
///
/// let tumbler = Glass { radius_m: 0.03, fill_m: 0.05, rim_m: 0.1, wall: WallShape::Straight { taper: 0.1 } };
/// assert!((tumbler.radius_at(0.05) - 0.035).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct Glass {
    /// Inner radius at the bottom; everywhere in a cylinder.
    pub radius_m: f64,
    /// Height of the liquid at rest above the inner bottom.
    pub fill_m: f64,
    /// Height of the rim above the inner bottom.
    pub rim_m: f64,
    /// Shape of the side wall.
    pub wall: WallShape,
}

/// Shape of a side wall.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "a box would not be Copy, and there are few glasses")]
pub enum WallShape {
    /// Upright, or a cone.
    Straight {
        /// Growth of the radius with height, `dr/dz`; 0 in a cylinder.
        taper: f64,
    },
    /// Any line through points, from the bottom to the rim; its first radius is that of the bottom.
    Curved(Profile),
}

/// A glass as files have it: with a taper, with a profile, or, upright, with neither.
#[derive(Serialize, Deserialize)]
struct Written {
    radius_m: f64,
    fill_m: f64,
    rim_m: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    taper: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    profile_m: Option<Profile>,
}

impl TryFrom<Written> for Glass {
    type Error = &'static str;

    fn try_from(file: Written) -> Result<Self, Self::Error> {
        let Written { radius_m, fill_m, rim_m, taper, profile_m } = file;
        let wall = match (taper, profile_m) {
            (Some(_), Some(_)) => return Err("a glass with a taper and a profile: it has one of them"),
            (_, Some(profile)) => WallShape::Curved(profile),
            (taper, None) => WallShape::Straight { taper: taper.unwrap_or(0.0) },
        };
        Ok(Self { radius_m, fill_m, rim_m, wall })
    }
}

impl From<Glass> for Written {
    fn from(glass: Glass) -> Self {
        let Glass { radius_m, fill_m, rim_m, wall } = glass;
        let (taper, profile_m) = match wall {
            WallShape::Straight { taper } => (Some(taper), None),
            WallShape::Curved(profile) => (None, Some(profile)),
        };
        Self { radius_m, fill_m, rim_m, taper, profile_m }
    }
}

impl WallShape {
    /// The wall of a cylinder.
    pub const UPRIGHT: Self = Self::Straight { taper: 0.0 };
}

/// The side wall as seen from a place in the glass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// Distance from the wall, m; negative outside.
    pub distance_m: f64,
    /// Outward normal of the wall.
    pub normal: [f64; 3],
    /// Curvature of the wall in the plane through the axis, 1/m; positive where the glass bulges.
    pub curvature: f64,
}

/// Largest `dr/dz` at the bottom with which side wall and bottom meet in a corner that mirrors both ways: 45 degrees.
const CORNER: f64 = 1.0;

impl Glass {
    /// The glass whose side wall goes through the points of `profile`, up to `rim_m`.
    #[must_use]
    pub fn curved(profile: Profile, fill_m: f64, rim_m: f64) -> Self {
        Self { radius_m: profile.points()[0][1], fill_m, rim_m, wall: WallShape::Curved(profile) }
    }

    /// Inner radius at height `z_m` above the bottom, m.
    #[must_use]
    pub fn radius_at(&self, z_m: f64) -> f64 {
        match &self.wall {
            WallShape::Straight { taper } => self.radius_m + taper * z_m,
            WallShape::Curved(profile) => profile.radius(z_m),
        }
    }

    /// Inner radius by which its size is judged, m: that of a straight wall at the bottom, and else that of the surface at rest.
    #[must_use]
    pub fn size_m(&self) -> f64 {
        match &self.wall {
            WallShape::Straight { .. } => self.radius_m,
            WallShape::Curved(_) => self.radius_at(self.fill_m),
        }
    }

    /// Largest inner radius between bottom and rim, m.
    #[must_use]
    pub fn widest_m(&self) -> f64 {
        self.radii().fold(0.0, f64::max)
    }

    /// Farthest that the wall is from below or above the edge of the surface at rest, horizontally, m.
    #[must_use]
    pub fn lean_m(&self) -> f64 {
        let edge = self.radius_at(self.fill_m);
        match &self.wall {
            WallShape::Straight { taper } => taper.abs() * self.rim_m,
            WallShape::Curved(_) => {
                self.radii().fold(0.0, |lean, radius| f64::max(lean, (radius - edge).abs()))
            }
        }
    }

    /// Radii from bottom to rim.
    fn radii(&self) -> impl Iterator<Item = f64> {
        const HEIGHTS: i32 = 200;
        (0..=HEIGHTS).map(|k| self.radius_at(self.rim_m * f64::from(k) / f64::from(HEIGHTS)))
    }

    /// Whether its sides are upright.
    #[must_use]
    pub fn is_cylinder(&self) -> bool {
        self.wall == WallShape::UPRIGHT
    }

    /// Whether bottom and side meet in a corner. Where they do not, the bottom is the end of one round wall.
    #[must_use]
    pub fn has_corner(&self) -> bool {
        match &self.wall {
            WallShape::Straight { .. } => true,
            // q' = 2 r dr/dz.
            WallShape::Curved(profile) => {
                let [_, rise, _] = profile.square(0.0);
                self.radius_m > 0.0 && rise < 2.0 * self.radius_m * CORNER
            }
        }
    }

    /// The side wall as seen from `x`.
    #[must_use]
    pub fn side(&self, x: &[f64; 3]) -> Side {
        // Never nothing: on the axis the normal has no azimuth.
        let r = (x[0] * x[0] + x[1] * x[1]).sqrt().max(1e-9);
        match &self.wall {
            WallShape::Straight { taper } => {
                let length = (1.0 + taper * taper).sqrt();
                let normal = [x[0] / r / length, x[1] / r / length, -taper / length];
                Side { distance_m: (self.radius_at(x[2]) - r) / length, normal, curvature: 0.0 }
            }
            WallShape::Curved(profile) => {
                let near = profile.nearest(r, x[2]);
                let [out, up] = near.normal;
                let normal = [out * x[0] / r, out * x[1] / r, up];
                Side { distance_m: near.distance_m, normal, curvature: near.curvature }
            }
        }
    }

    /// The side wall as seen from `x`, where it is nearer than `reach_m`.
    #[must_use]
    pub fn side_within(&self, x: &[f64; 3], reach_m: f64) -> Option<Side> {
        if let WallShape::Curved(profile) = &self.wall {
            let r = (x[0] * x[0] + x[1] * x[1]).sqrt();
            // The estimate is within a part of the distance over the radius of curvature.
            if profile.estimate(r, x[2]) > 2.0 * reach_m {
                return None;
            }
        }
        Some(self.side(x)).filter(|side| side.distance_m < reach_m)
    }

    /// Distance of a place in the glass from side or bottom, whichever is nearer, m; negative outside.
    #[must_use]
    pub fn wall_distance(&self, x: &[f64; 3]) -> f64 {
        self.side(x).distance_m.min(x[2])
    }

    /// Volume between the heights `low_m` and `high_m`, m3: `int pi r^2 dz` by Simpson's rule on short parts.
    #[must_use]
    pub fn volume_m3(&self, low_m: f64, high_m: f64) -> f64 {
        const PARTS: i32 = 64;
        let part = (high_m - low_m) / f64::from(PARTS);
        let square = |z: f64| self.radius_at(z).powi(2);
        let sum: f64 = (0..PARTS)
            .map(|k| {
                let z = low_m + part * f64::from(k);
                square(z) + 4.0 * square(z + 0.5 * part) + square(z + part)
            })
            .sum();
        std::f64::consts::PI * part / 6.0 * sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TUMBLER: Glass =
        Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11, wall: WallShape::Straight { taper: 0.05 } };

    #[test]
    fn files_say_taper_or_profile_or_neither() {
        let read = |text: &str| serde_json::from_str::<Glass>(text).expect("a glass");
        let plain = r#"{"radius_m":0.035,"fill_m":0.07,"rim_m":0.11"#;
        assert_eq!(read(&format!("{plain}}}")).wall, WallShape::UPRIGHT);
        assert_eq!(read(&format!("{plain},\"taper\":0.05}}")), TUMBLER);
        assert_eq!(serde_json::to_string(&TUMBLER).expect("text"), format!("{plain},\"taper\":0.05}}"));
        let profile = Profile::new(&[[0.0, 0.0], [0.02, 0.03], [0.11, 0.035]]).expect("a profile");
        let bowl = Glass::curved(profile, 0.07, 0.11);
        assert_eq!(read(&serde_json::to_string(&bowl).expect("text")), bowl);
        let wrong = format!("{plain},\"profile_m\":[[0.0,0.03],[0.05,0.03]]}}");
        let why = serde_json::from_str::<Glass>(&wrong).expect_err("two points");
        assert!(format!("{why}").contains("it needs 3 to 32"), "{why}");
    }

    #[test]
    fn a_curved_wall_through_the_points_of_a_cone_is_that_cone() {
        let profile = Profile::new(&[0.0, 0.05, 0.11].map(|z| [z, TUMBLER.radius_at(z)])).expect("a profile");
        let curved = Glass::curved(profile, TUMBLER.fill_m, TUMBLER.rim_m);
        assert!(curved.has_corner() && TUMBLER.has_corner());
        let (near, straight) = (curved.side(&[0.02, 0.015, 0.03]), TUMBLER.side(&[0.02, 0.015, 0.03]));
        assert!((near.distance_m - straight.distance_m).abs() < 1e-9, "{near:?} {straight:?}");
        for (a, b) in near.normal.iter().zip(straight.normal) {
            assert!((a - b).abs() < 1e-7, "{near:?} {straight:?}");
        }
        assert!((curved.lean_m() - 0.0035).abs() < 1e-4 && (curved.widest_m() - 0.0405).abs() < 1e-9);
    }

    #[test]
    fn the_volume_of_a_bowl_is_that_of_a_cap() {
        // A cap of the height h in a sphere of the radius R: pi h^2 (R - h/3).
        let point = |z: f64| [z, (0.08 * z - z * z).sqrt()];
        let profile = Profile::new(&[0.0, 0.01, 0.02, 0.03, 0.04, 0.05].map(point)).expect("a bowl");
        let bowl = Glass::curved(profile, 0.03, 0.05);
        let cap = std::f64::consts::PI * 0.03_f64.powi(2) * (0.04 - 0.01);
        assert!((bowl.volume_m3(0.0, 0.03) / cap - 1.0).abs() < 1e-9);
        assert!(!bowl.has_corner());
    }
}
