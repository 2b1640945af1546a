//! The tracer lattice: 194 vertical columns in rings, 11 tracers each, 2134 in all.

use super::Glass;

/// Columns in each ring, from the axis outwards; the numbers grow with the radius so that every
/// column stands for about the same area (2134 = 194 x 11).
pub(crate) const RING: [usize; 8] = [1, 7, 14, 21, 27, 34, 41, 49];

/// Vertical columns of tracers.
pub const COLUMNS: usize = 194;

/// Tracers in a column.
pub const LAYERS: usize = 11;

/// Tracers in all.
pub const TRACERS: usize = COLUMNS * LAYERS;

/// Points along the contact line.
pub const WALL_POINTS: usize = 72;

/// Azimuth of wall point `index` in radians: 0 at +x, counter-clockwise seen from above. The camera
/// looks along +y, so the wall that faces it is at negative `y`.
#[must_use]
pub fn wall_azimuth(index: usize) -> f64 {
    std::f64::consts::TAU * index as f64 / WALL_POINTS as f64
}

/// Positions of the columns, and the stretch of a column to its free surface.
#[derive(Clone, Debug)]
pub struct Lattice {
    /// `(x, y)` of each column where it meets the surface at rest, in the frame of the glass, metres. In a
    /// cone its tracers stand on a line to the apex.
    pub columns: Vec<[f64; 2]>,
    glass: Glass,
}

impl Lattice {
    /// The lattice of `glass`; the outermost ring stands at 13/14 of the radius of the surface at rest,
    /// the middle of the outermost of seven equal shells.
    #[must_use]
    pub fn new(glass: &Glass) -> Self {
        let mut columns = Vec::with_capacity(COLUMNS);
        for (ring, &count) in RING.iter().enumerate() {
            let radius = glass.radius_at(glass.fill_m) * (13.0 / 14.0) * ring as f64 / 7.0;
            for k in 0..count {
                // Odd rings are turned by half a step so that neighbours do not line up.
                let turn = 0.5 * (ring % 2) as f64;
                let azimuth = std::f64::consts::TAU * (k as f64 + turn) / count as f64;
                columns.push([radius * azimuth.cos(), radius * azimuth.sin()]);
            }
        }
        Self { columns, glass: *glass }
    }

    /// Position of tracer `column * LAYERS + layer` (layer 0 at the bottom) under a surface of
    /// height `surface_m` in its column.
    #[must_use]
    pub fn tracer(&self, column: usize, layer: usize, surface_m: f64) -> [f64; 3] {
        let [x, y] = self.columns[column];
        let z = surface_m * (layer as f64 + 0.5) / LAYERS as f64;
        let part = self.glass.radius_at(z) / self.glass.radius_at(self.glass.fill_m);
        [part * x, part * y, z]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::glass::WallShape;

    #[test]
    fn rings_add_up_to_the_columns_inside_the_glass() {
        let glass = Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11, wall: WallShape::UPRIGHT };
        let lattice = Lattice::new(&glass);
        assert_eq!(RING.iter().sum::<usize>(), COLUMNS);
        assert_eq!(lattice.columns.len() * LAYERS, 2134);
        assert!(lattice.columns.iter().all(|[x, y]| x.hypot(*y) < glass.radius_m));
    }
}
