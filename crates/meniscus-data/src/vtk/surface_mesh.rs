//! The free surface of one frame: triangles between the tracer columns and the contact line.
//!
//! The columns stand in rings around the axis, and the wall points make one ring more. Two neighbouring rings with different numbers of
//! points are joined by a band of triangles: at each step the ring goes on whose next point has the smaller azimuth.

use super::poly_data::{Cells, PointArray, PolyData};
use super::room::Pose;
use crate::recording::{COLUMNS, Lattice, RING, Recording, WALL_POINTS, wall_azimuth};
use meniscus::units::FRAME_INTERVAL_S;
use std::f64::consts::TAU;

/// A ring of points: its first number, and the azimuths in turns, rising from below one step.
struct Ring {
    first: u32,
    count: u32,
    /// Azimuth of the first point, in steps.
    offset: f64,
}

impl Ring {
    /// Azimuth of point `index`, which may go round, rad.
    fn azimuth(&self, index: u32) -> f64 {
        TAU * (f64::from(index) + self.offset) / f64::from(self.count)
    }

    /// Number of point `index`, which may go round.
    fn point(&self, index: u32) -> u32 {
        self.first + index % self.count
    }
}

/// Returns the triangles between the rings of columns, numbered as they are, and the wall points behind them. Seen from above they go round
/// counter-clockwise.
pub(super) fn triangles() -> Vec<[u32; 3]> {
    let mut rings = Vec::new();
    let mut first = 0;
    for (ring, &count) in RING.iter().enumerate() {
        // Odd rings are turned by half a step, as in the lattice.
        rings.push(Ring { first, count: count as u32, offset: 0.5 * (ring % 2) as f64 });
        first += count as u32;
    }
    rings.push(Ring { first, count: WALL_POINTS as u32, offset: 0.0 });
    let mut all = Vec::new();
    for pair in rings.windows(2) {
        let [inner, outer] = pair else { continue };
        band(inner, outer, &mut all);
    }
    all
}

/// Joins two rings.
fn band(inner: &Ring, outer: &Ring, all: &mut Vec<[u32; 3]>) {
    if inner.count == 1 {
        all.extend((0..outer.count).map(|k| [inner.first, outer.point(k), outer.point(k + 1)]));
        return;
    }
    let (mut i, mut o) = (0, 0);
    while i < inner.count || o < outer.count {
        let inner_next = inner.azimuth(i + 1);
        let outer_next = outer.azimuth(o + 1);
        if i == inner.count || (o < outer.count && outer_next <= inner_next) {
            all.push([inner.point(i), outer.point(o), outer.point(o + 1)]);
            o += 1;
        } else {
            all.push([inner.point(i), outer.point(o), inner.point(i + 1)]);
            i += 1;
        }
    }
}

/// Returns the surface of `frame`, with its height above the inner bottom.
pub(super) fn surface<'a>(
    recording: &Recording,
    lattice: &Lattice,
    frame: usize,
    pose: &Pose,
    triangles: &'a [[u32; 3]],
) -> PolyData<'a> {
    let columns = &recording.column_m[frame * COLUMNS..(frame + 1) * COLUMNS];
    let wall = &recording.wall_m[frame * WALL_POINTS..(frame + 1) * WALL_POINTS];
    let rest_radius_m = recording.glass.radius_at(recording.glass.fill_m);
    let inside = lattice.columns.iter().zip(columns).map(|([x, y], &z)| {
        let part = recording.glass.radius_at(f64::from(z)) / rest_radius_m;
        [part * x, part * y, f64::from(z)]
    });
    let line = wall.iter().enumerate().map(|(k, &z)| {
        let (sin, cos) = wall_azimuth(k).sin_cos();
        let radius_m = recording.glass.radius_at(f64::from(z));
        [radius_m * cos, radius_m * sin, f64::from(z)]
    });
    PolyData {
        points: inside.chain(line).map(|x| pose.place(x)).collect(),
        cells: Cells::Triangles(triangles),
        arrays: vec![PointArray { name: "height_m", components: 1, values: [columns, wall].concat() }],
        time_s: frame as f64 * FRAME_INTERVAL_S,
    }
}
