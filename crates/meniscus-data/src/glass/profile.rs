//! Inner profile of a glass of revolution: its radius over the height, through points that somebody measured.
//!
//! ```text
//! q(z) = r(z)^2    cubic between neighbouring points; its slope in a point is that of the parabola through three
//! F(r, z) = r^2 - q(z)            below zero inside,  grad F = (2 r, -q')
//! curvature = (2 q'^2 - 4 r^2 q'') / (4 r^2 + q'^2)^(3/2)        of the wall's line in a plane through the axis
//! ```
//! The square of the radius is smooth where a round bottom meets the axis, `q = 2 R z - z^2` in a sphere; cylinder, cone,
//! sphere and paraboloid are met exactly. Beyond both ends `q` goes on straight.

use super::error::{MOST_POINTS, WallError};
use serde::{Deserialize, Serialize};

/// Steps of Newton's method to the nearest point; four suffice within a curvature's radius.
const STEPS: usize = 12;

/// Inner radius of a glass over its height.
///
/// ```
/// use meniscus_data::glass::Profile;
///
/// // A bowl: the lower half of a sphere of 40 mm.
/// let point = |z: f64| [z, (0.08 * z - z * z).sqrt()];
/// let bowl = Profile::new(&[0.0, 0.01, 0.02, 0.03, 0.04].map(point)).expect("a profile");
/// assert!((bowl.radius(0.015) - point(0.015)[1]).abs() < 1e-9);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<[f64; 2]>", into = "Vec<[f64; 2]>")]
pub struct Profile {
    count: usize,
    /// Height and radius of each point, m.
    point: [[f64; 2]; MOST_POINTS],
    /// Slope `dq/dz` in each point, m.
    slope: [f64; MOST_POINTS],
}

/// Nearest point of the wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Distance from it, m; negative outside.
    pub distance_m: f64,
    /// Outward normal there: its part away from the axis, and upwards.
    pub normal: [f64; 2],
    /// Curvature of the wall's line there, 1/m; positive where the glass bulges.
    pub curvature: f64,
}

impl Profile {
    /// The profile through `points`, each a height above the inner bottom and a radius, m, from the bottom to the rim. A
    /// first radius of 0 is a round bottom.
    ///
    /// # Errors
    /// [`WallError`], when they are not 3 to 32, do not rise from 0, or a radius is out of range.
    pub fn new(points: &[[f64; 2]]) -> Result<Self, WallError> {
        let count = points.len();
        if !(3..=MOST_POINTS).contains(&count) {
            return Err(WallError::Count(count));
        }
        if points[0][0] != 0.0 {
            return Err(WallError::Start(points[0][0]));
        }
        for (i, &[z, r]) in points.iter().enumerate() {
            if !z.is_finite() || (i > 0 && z <= points[i - 1][0]) {
                return Err(WallError::Height(i, [z, r]));
            }
            if !(0.0..=0.2).contains(&r) || (i > 0 && r == 0.0) {
                return Err(WallError::Radius(i, [z, r]));
            }
        }
        let mut profile = Self { count, point: [[0.0; 2]; MOST_POINTS], slope: [0.0; MOST_POINTS] };
        profile.point[..count].copy_from_slice(points);
        for i in 0..count {
            // The parabola through the point and its neighbours; through the three nearest at the ends.
            let middle = i.clamp(1, count - 2);
            let [before, here, after] =
                [middle - 1, middle, middle + 1].map(|k| [points[k][0], points[k][1].powi(2)]);
            let rise = |a: [f64; 2], b: [f64; 2]| (b[1] - a[1]) / (b[0] - a[0]);
            let bend = (rise(here, after) - rise(before, here)) / (after[0] - before[0]);
            profile.slope[i] = rise(before, here) + bend * (2.0 * points[i][0] - before[0] - here[0]);
        }
        profile.open().map(|()| profile)
    }

    /// Whether the line between the points stays away from the axis.
    fn open(&self) -> Result<(), WallError> {
        const BETWEEN: usize = 16;
        let first = if self.point[0][1] == 0.0 { 1 } else { 0 };
        let total = BETWEEN * (self.count - 1);
        let mut heights = (first..=total).map(|k| {
            let (low, part) = ((k / BETWEEN).min(self.count - 2), k as f64 / BETWEEN as f64);
            let [z, next] = [self.point[low][0], self.point[low + 1][0]];
            z + (part - low as f64) * (next - z)
        });
        heights.find(|z| self.square(*z)[0] <= 0.0).map_or(Ok(()), |z| Err(WallError::Pinched(z)))
    }

    /// The points, height and radius, m.
    #[must_use]
    pub fn points(&self) -> &[[f64; 2]] {
        &self.point[..self.count]
    }

    /// Height of the last point, m.
    #[must_use]
    pub fn top_m(&self) -> f64 {
        self.point[self.count - 1][0]
    }

    /// Radius at height `z_m`, m; 0 below a round bottom.
    #[must_use]
    pub fn radius(&self, z_m: f64) -> f64 {
        self.square(z_m)[0].max(0.0).sqrt()
    }

    /// `q`, `q'` and `q''` at height `z_m`.
    #[must_use]
    pub fn square(&self, z_m: f64) -> [f64; 3] {
        let last = self.count - 1;
        let beyond = |end: usize| {
            let [z, r] = self.point[end];
            [r * r + self.slope[end] * (z_m - z), self.slope[end], 0.0]
        };
        if z_m <= self.point[0][0] {
            return beyond(0);
        }
        if z_m >= self.point[last][0] {
            return beyond(last);
        }
        let low = self.points().partition_point(|[z, _]| *z <= z_m) - 1;
        let [[z_0, r_0], [z_1, r_1]] = [self.point[low], self.point[low + 1]];
        let length = z_1 - z_0;
        let [a, b] = [r_0 * r_0, r_1 * r_1];
        let [slope_a, slope_b] = [self.slope[low] * length, self.slope[low + 1] * length];
        // a + slope_a t + two t^2 + three t^3 on 0 <= t <= 1.
        let two = 3.0 * (b - a) - 2.0 * slope_a - slope_b;
        let three = 2.0 * (a - b) + slope_a + slope_b;
        let t = (z_m - z_0) / length;
        [
            a + t * (slope_a + t * (two + t * three)),
            (slope_a + t * (2.0 * two + 3.0 * t * three)) / length,
            (2.0 * two + 6.0 * t * three) / (length * length),
        ]
    }

    /// `-F/|grad F|`, m: the distance from the wall, to a part of it over the radius of curvature.
    #[must_use]
    pub fn estimate(&self, r_m: f64, z_m: f64) -> f64 {
        let [q, rise, _] = self.square(z_m);
        (q - r_m * r_m) / length(2.0 * r_m, rise).max(1e-12)
    }

    /// The point of the wall nearest to the place `r_m` from the axis at height `z_m`, by Newton's method on
    /// `F = 0` and `(r - a) q' + 2 a (z - s) = 0` for the foot `(a, s)`: the line to it is normal to the wall.
    ///
    /// Far from the wall, beyond its centre of curvature, the distance is an estimate that is too large.
    #[must_use]
    pub fn nearest(&self, r_m: f64, z_m: f64) -> Nearest {
        let (mut a, mut s) = (r_m, z_m);
        let estimate = self.estimate(r_m, z_m);
        let (inside, longest) = (estimate >= 0.0, estimate.abs());
        for _ in 0..STEPS {
            let [q, rise, bend] = self.square(s);
            let [line, normal] = [a * a - q, (r_m - a) * rise + 2.0 * a * (z_m - s)];
            let [line_a, line_s] = [2.0 * a, -rise];
            let [normal_a, normal_s] = [2.0 * (z_m - s) - rise, (r_m - a) * bend - 2.0 * a];
            let determinant = line_a * normal_s - line_s * normal_a;
            if determinant >= 0.0 {
                // Beyond the centre of curvature: the wall is far.
                break;
            }
            let step_a = (line_s * normal - normal_s * line) / determinant;
            let step_s = (normal_a * line - line_a * normal) / determinant;
            let length = length(step_a, step_s);
            // No longer than the first one, which is too long already where the glass bulges.
            let part = if length > longest { longest / length } else { 1.0 };
            (a, s) = ((a + part * step_a).max(0.0), s + part * step_s);
            if length < 1e-9 {
                break;
            }
        }
        let [_, rise, bend] = self.square(s);
        let steep = length(2.0 * a, rise).max(1e-12);
        let distance = length(r_m - a, z_m - s);
        Nearest {
            distance_m: if inside { distance } else { -distance },
            normal: [2.0 * a / steep, -rise / steep],
            curvature: (2.0 * rise * rise - 4.0 * a * a * bend) / steep.powi(3),
        }
    }
}

/// Length of a vector; `hypot` guards against sizes that no glass has, at four times the cost.
fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

impl TryFrom<Vec<[f64; 2]>> for Profile {
    type Error = WallError;

    fn try_from(points: Vec<[f64; 2]>) -> Result<Self, WallError> {
        Self::new(&points)
    }
}

impl From<Profile> for Vec<[f64; 2]> {
    fn from(profile: Profile) -> Self {
        profile.points().to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sphere of `radius` m, cut off at the height `top`.
    fn sphere(radius: f64, top: f64) -> Profile {
        let point = |k: usize| {
            let z = top * k as f64 / 12.0;
            [z, (2.0 * radius * z - z * z).max(0.0).sqrt()]
        };
        Profile::new(&(0..=12).map(point).collect::<Vec<_>>()).expect("a sphere")
    }

    #[test]
    fn the_nearest_point_of_a_sphere_is_on_the_line_from_its_centre() {
        let bowl = sphere(0.04, 0.06);
        for (r, z) in [(0.0, 0.002), (0.001, 0.001), (0.02, 0.02), (0.036, 0.05), (0.03, 0.0), (0.0, -0.003)]
        {
            let near = bowl.nearest(r, z);
            let from_centre = f64::hypot(r, z - 0.04);
            assert!((near.distance_m - (0.04 - from_centre)).abs() < 1e-9, "{r} {z}: {near:?}");
            assert!((near.normal[0] - r / from_centre).abs() < 1e-7, "{r} {z}: {near:?}");
            assert!((near.normal[1] - (z - 0.04) / from_centre).abs() < 1e-7, "{r} {z}: {near:?}");
            assert!((near.curvature * 0.04 - 1.0).abs() < 1e-7, "{r} {z}: {near:?}");
        }
    }

    #[test]
    fn a_wine_glass_has_the_nearest_point_of_a_fine_search() {
        // Points of a bowl that bulges below and narrows to the rim.
        let points = [
            [0.0, 0.0],
            [0.005, 0.018],
            [0.015, 0.029],
            [0.03, 0.036],
            [0.05, 0.038],
            [0.07, 0.035],
            [0.1, 0.03],
        ];
        let glass = Profile::new(&points).expect("a wine glass");
        for (r, z) in [(0.012, 0.006), (0.03, 0.03), (0.033, 0.05), (0.03, 0.08), (0.004, 0.004)] {
            let steps = (0..200_000).map(|k| 0.1 * f64::from(k) / 200_000.0);
            let found = steps.map(|s| (r - glass.radius(s)).hypot(z - s)).fold(f64::INFINITY, f64::min);
            let near = glass.nearest(r, z);
            assert!((near.distance_m - found).abs() < 1e-7, "{r} {z}: {near:?} for {found}");
        }
    }

    #[test]
    fn cylinder_and_cone_are_met_exactly() {
        let cone = Profile::new(&[0.0, 0.01, 0.04, 0.1].map(|z| [z, 0.03 + 0.15 * z])).expect("a cone");
        let length = 1.0_f64.hypot(0.15);
        let near = cone.nearest(0.031, 0.05);
        assert!((near.distance_m - (0.0375 - 0.031) / length).abs() < 1e-9, "{near:?}");
        assert!(near.curvature.abs() < 1e-6, "{near:?}");
        assert!((cone.radius(0.25) - (0.045_f64.powi(2) + 2.0 * 0.045 * 0.15 * 0.15).sqrt()).abs() < 1e-9);
    }

    #[test]
    fn points_that_are_no_profile_are_refused() {
        let why = |points: &[[f64; 2]]| format!("{}", Profile::new(points).expect_err("no profile"));
        assert!(why(&[[0.0, 0.03], [0.1, 0.03]]).contains("it needs 3 to 32"));
        assert!(why(&[[0.01, 0.03], [0.05, 0.03], [0.1, 0.03]]).contains("must be at 0"));
        assert!(why(&[[0.0, 0.03], [0.05, 0.03], [0.05, 0.04]]).contains("point 3"));
        assert!(why(&[[0.0, 0.03], [0.05, 0.0], [0.1, 0.04]]).contains("radius out of range"));
        assert!(why(&[[0.0, 0.03], [0.05, f64::NAN], [0.1, 0.04]]).contains("radius out of range"));
        let swinging = [[0.0, 0.1], [0.02, 0.1], [0.021, 0.004], [0.05, 0.004], [0.1, 0.004]];
        assert!(why(&swinging).contains("reaches the axis"));
    }
}
