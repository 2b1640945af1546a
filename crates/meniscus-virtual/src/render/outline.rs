//! The outline of the liquid in the image, and how much of a pixel lies inside.
//!
//! Left and right: the two vertical planes through the camera that are tangent to the wall. Bottom:
//! the near edge of the inner bottom. Top: the contact line on the wall that faces the camera. Where
//! liquid behind it rises faster than the line of sight, it shows above the contact line: that part
//! is found by walking along the chord of the glass behind each pixel column.

use super::shape::Shape;
use super::view::View;
use super::{SceneSettings, Window};

/// Points of the contact line that are projected.
const CONTACT_POINTS: usize = 241;
/// Parts of a pixel column in each of which the edge is taken as level.
const PARTS: usize = 4;
/// Points along the chord behind a pixel column.
const CHORD: usize = 14;

/// Scene behind one pixel column.
#[derive(Clone, Debug, Default)]
struct Column {
    /// Row of the contact line in the middle of each part of the column.
    contact_v: [f64; PARTS],
    /// Row of the near edge of the bottom.
    bottom_v: f64,
    /// Rows by which the liquid behind shows above the contact line.
    behind_rows: f64,
    /// Row of the highest liquid seen so far, and depth, at each point of the chord.
    chord: [(f64, f64); CHORD],
}

/// Shares of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Coverage {
    /// Liquid at the wall that faces the camera.
    pub(super) front: f64,
    /// Liquid surface behind the contact line.
    pub(super) behind: f64,
    /// Empty glass above the liquid.
    pub(super) empty: f64,
}

/// The liquid in the image.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    window: Window,
    columns: Vec<Column>,
    /// Tangents of the bearings of the silhouette.
    bearings: [f64; 2],
    rim_v: f64,
    axis_m: f64,
    radius_m: f64,
}

impl Outline {
    pub(super) fn new(
        view: &View,
        settings: &SceneSettings,
        shape: &Shape,
        axis_m: f64,
        window: Window,
    ) -> Self {
        let radius_m = f64::from(settings.camera.radius_m);
        let away = view.distance_m.hypot(axis_m);
        // Seen from the axis, the camera stands at azimuth `towards`; the visible wall spans `half` to either side.
        let towards = (-view.distance_m).atan2(-axis_m);
        let half = (radius_m / away).acos();
        let bearing = (axis_m / view.distance_m).atan();
        let bearings = [-1.0, 1.0].map(|side| (bearing + side * (radius_m / away).asin()).tan());
        let line = |height: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
            let point = |index: usize| {
                let azimuth = towards + half * (2.0 * index as f64 / (CONTACT_POINTS - 1) as f64 - 1.0);
                let (sin, cos) = azimuth.sin_cos();
                let seen = view.project([axis_m + radius_m * cos, radius_m * sin, height(azimuth)]);
                (seen.u, seen.v)
            };
            (0..CONTACT_POINTS).map(point).collect()
        };
        let contact = line(&|azimuth| shape.contact(azimuth));
        let bottom = line(&|_| 0.0);
        let columns = (window.left..window.right)
            .map(|u| {
                let mut column = Column { bottom_v: interpolate(&bottom, u as f64), ..Column::default() };
                for (part, v) in column.contact_v.iter_mut().enumerate() {
                    *v = interpolate(&contact, u as f64 + (part as f64 + 0.5) / PARTS as f64 - 0.5);
                }
                column.look_behind(view, shape, axis_m, radius_m, u as f64, interpolate(&contact, u as f64));
                column
            })
            .collect();
        let rim_v = view.project([axis_m, -radius_m, settings.camera.rim_m.into()]).v;
        Self { window, columns, bearings, rim_v, axis_m, radius_m }
    }

    /// Left and right end of the silhouette in row `v`.
    pub(super) fn sides(&self, view: &View, v: f64) -> [f64; 2] {
        self.bearings.map(|tangent| view.column_of_bearing(tangent, v))
    }

    /// Shares of pixel `(u, v)` in a row whose silhouette ends at `sides`.
    pub(super) fn coverage(&self, u: usize, v: usize, sides: [f64; 2]) -> Coverage {
        let mut coverage = Coverage::default();
        let column = &self.columns[u - self.window.left];
        for (part, &contact_v) in column.contact_v.iter().enumerate() {
            let start = u as f64 - 0.5 + part as f64 / PARTS as f64;
            let width = overlap([start, start + 1.0 / PARTS as f64], sides);
            if width > 0.0 {
                let row = [v as f64 - 0.5, v as f64 + 0.5];
                let top_v = contact_v - column.behind_rows;
                coverage.front += width * overlap(row, [contact_v, column.bottom_v]);
                coverage.behind += width * overlap(row, [top_v, contact_v]);
                coverage.empty += width * overlap(row, [self.rim_v, top_v]);
            }
        }
        coverage
    }

    /// Share of a pixel within `rows` above the contact line.
    pub(super) fn above(&self, u: usize, v: usize, sides: [f64; 2], rows: f64) -> f64 {
        let contact = self.columns[u - self.window.left].contact_v.iter().enumerate();
        let parts = contact.map(|(part, &contact_v)| {
            let start = u as f64 - 0.5 + part as f64 / PARTS as f64;
            let width = overlap([start, start + 1.0 / PARTS as f64], sides);
            width * overlap([v as f64 - 0.5, v as f64 + 0.5], [contact_v - rows, contact_v])
        });
        parts.sum()
    }

    /// Rows from the rim to the bottom of the glass in a column.
    pub(super) fn glass_rows(&self, u: usize) -> [f64; 2] {
        [self.rim_v, self.columns[u - self.window.left].bottom_v]
    }

    /// Depth of the wall that faces the camera.
    pub(super) fn front_depth(&self, view: &View, u: usize, v: usize) -> Option<f64> {
        view.cylinder(view.ray(u as f64, v as f64), self.axis_m, self.radius_m).map(|(near, _)| near)
    }

    /// Depth of the liquid behind the contact line: the first point of the chord seen at this row or above.
    pub(super) fn behind_depth(&self, u: usize, v: usize) -> Option<f64> {
        let chord = &self.columns[u - self.window.left].chord;
        chord.iter().find(|(seen_v, _)| *seen_v <= v as f64).map(|(_, depth)| *depth)
    }

    /// Place across the silhouette: -1 at the left end, 1 at the right end, beyond outside.
    pub(super) fn across(u: f64, [left, right]: [f64; 2]) -> f64 {
        (2.0 * u - left - right) / (right - left)
    }

    /// Whether the pixel lies within a pixel of the outline, where stereo matching often fails.
    pub(super) fn near_edge(&self, u: usize, v: usize, sides: [f64; 2]) -> bool {
        let column = &self.columns[u - self.window.left];
        let top_v = column.contact_v[PARTS / 2] - column.behind_rows;
        let beside = sides.iter().any(|side| (u as f64 - side).abs() < 1.0);
        (beside && v as f64 > top_v)
            || ((v as f64 - top_v).abs() < 1.0 && Self::across(u as f64, sides).abs() < 1.0)
    }
}

impl Column {
    /// Walks along the chord and keeps the highest liquid seen so far.
    fn look_behind(
        &mut self,
        view: &View,
        shape: &Shape,
        axis_m: f64,
        radius_m: f64,
        u: f64,
        contact_v: f64,
    ) {
        let ray = view.ray(u, contact_v);
        let Some((near, far)) = view.cylinder(ray, axis_m, radius_m) else {
            return;
        };
        let mut highest_v = contact_v;
        for (index, point) in self.chord.iter_mut().enumerate() {
            let depth = near + (far - near) * (index + 1) as f64 / CHORD as f64;
            let (x, y) = (ray[0] * depth - axis_m, ray[1] * depth - view.distance_m);
            let seen = view.project([x + axis_m, y, shape.height(x, y)]);
            highest_v = highest_v.min(seen.v);
            *point = (highest_v, depth);
        }
        self.behind_rows = contact_v - highest_v;
    }
}

/// Length of the overlap of two intervals.
fn overlap(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[1].min(b[1]) - a[0].max(b[0])).max(0.0)
}

/// Linear interpolation in points of rising first coordinate, constant beyond the ends.
fn interpolate(points: &[(f64, f64)], at: f64) -> f64 {
    let after = points.partition_point(|(u, _)| *u < at).clamp(1, points.len() - 1);
    let ((u0, v0), (u1, v1)) = (points[after - 1], points[after]);
    v0 + ((at - u0) / (u1 - u0)).clamp(0.0, 1.0) * (v1 - v0)
}
