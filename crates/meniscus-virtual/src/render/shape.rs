//! The height of the liquid anywhere in the glass, from the contact line and the lattice columns.

use meniscus_data::recording::{COLUMNS, Glass, Lattice, WALL_POINTS};
use std::f64::consts::TAU;

/// One ring of lattice columns.
#[derive(Clone, Debug)]
struct Ring {
    radius_m: f64,
    /// Azimuth of the ring's first column.
    first_rad: f64,
    heights_m: Vec<f64>,
}

/// Heights over rings of the lattice, closed by the contact line.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    radius_m: f64,
    rings: Vec<Ring>,
    wall_m: Vec<f64>,
}

impl Shape {
    pub(super) fn new(glass: &Glass) -> Self {
        let mut rings: Vec<Ring> = Vec::new();
        for [x, y] in Lattice::new(glass).columns {
            let radius_m = x.hypot(y);
            match rings.last_mut().filter(|ring| (ring.radius_m - radius_m).abs() < 1e-9) {
                Some(ring) => ring.heights_m.push(0.0),
                None => rings.push(Ring { radius_m, first_rad: y.atan2(x), heights_m: vec![0.0] }),
            }
        }
        Self { radius_m: glass.radius_m, rings, wall_m: vec![0.0; WALL_POINTS] }
    }

    /// Takes new heights.
    pub(super) fn set(&mut self, wall_m: &[f32], column_m: &[f32]) {
        assert_eq!(
            (wall_m.len(), column_m.len()),
            (WALL_POINTS, COLUMNS),
            "heights of the wall and of the columns"
        );
        self.wall_m.iter_mut().zip(wall_m).for_each(|(to, &from)| *to = from.into());
        let all = self.rings.iter_mut().flat_map(|ring| &mut ring.heights_m);
        all.zip(column_m).for_each(|(to, &from)| *to = from.into());
    }

    /// Height of the contact line at an azimuth, by the cubic through its four neighbours (Catmull-Rom).
    pub(super) fn contact(&self, azimuth: f64) -> f64 {
        let at = (azimuth / TAU).rem_euclid(1.0) * WALL_POINTS as f64;
        let (index, t) = (at as usize, at.fract());
        let p = [WALL_POINTS - 1, 0, 1, 2].map(|offset| self.wall_m[(index + offset) % WALL_POINTS]);
        let [a, b, c] =
            [p[2] - p[0], 2.0 * p[0] - 5.0 * p[1] + 4.0 * p[2] - p[3], 3.0 * (p[1] - p[2]) + p[3] - p[0]];
        p[1] + 0.5 * t * (a + t * (b + t * c))
    }

    /// Height at `(x, y)` in the frame of the glass: linear along and between rings.
    pub(super) fn height(&self, x: f64, y: f64) -> f64 {
        let (radius_m, azimuth) = (x.hypot(y), y.atan2(x));
        let outer = self.rings.partition_point(|ring| ring.radius_m <= radius_m);
        let inner = &self.rings[outer.max(1) - 1];
        let (outer_radius_m, outer_m) = match self.rings.get(outer) {
            Some(ring) => (ring.radius_m, ring.height(azimuth)),
            None => (self.radius_m, self.contact(azimuth)),
        };
        let share = ((radius_m - inner.radius_m) / (outer_radius_m - inner.radius_m)).clamp(0.0, 1.0);
        let inner_m = inner.height(azimuth);
        inner_m + share * (outer_m - inner_m)
    }
}

impl Ring {
    fn height(&self, azimuth: f64) -> f64 {
        let count = self.heights_m.len();
        let at = ((azimuth - self.first_rad) / TAU).rem_euclid(1.0) * count as f64;
        let (index, t) = (at as usize % count, at.fract());
        self.heights_m[index] * (1.0 - t) + self.heights_m[(index + 1) % count] * t
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_data::glass::WallShape;
    use meniscus_data::recording::wall_azimuth;

    #[test]
    fn a_tilted_plane_is_met_everywhere() {
        let glass = Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11, wall: WallShape::UPRIGHT };
        let mut shape = Shape::new(&glass);
        let plane = |x: f64, y: f64| 0.07 + 0.3 * x - 0.2 * y;
        let wall: Vec<f32> = (0..WALL_POINTS)
            .map(|i| wall_azimuth(i).sin_cos())
            .map(|(s, c)| plane(0.035 * c, 0.035 * s) as f32)
            .collect();
        let columns: Vec<f32> =
            Lattice::new(&glass).columns.iter().map(|[x, y]| plane(*x, *y) as f32).collect();
        shape.set(&wall, &columns);
        for step in 0..500 {
            let (radius, azimuth) = (0.035 * (f64::from(step) / 500.0), 0.7 * f64::from(step));
            let (x, y) = (radius * azimuth.cos(), radius * azimuth.sin());
            // Chords of the rings cut 2 % of the radius off at most: the inner ring has seven points.
            assert!((shape.height(x, y) - plane(x, y)).abs() < 3e-4, "{x} {y}");
            let (s, c) = azimuth.sin_cos();
            assert!((shape.contact(azimuth) - plane(0.035 * c, 0.035 * s)).abs() < 2e-6);
        }
    }
}
