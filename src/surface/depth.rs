//! How far the edge is: measured depth just below it, compared with the wall it must lie on.
//!
//! The contact line lies on the wall that faces the camera, whose depth `w(u)` follows from the
//! glass position. Per edge point the residuals `r = z - w` of the valid pixels in a small window in
//! the liquid are taken, because the wall curves within the window and a residual does not:
//!
//! * enough valid pixels: depth = w + median r;
//! * too few (a hole): depth = w + the median over all measured points of the frame, and only if at
//!   least half of the traced points are measured, that is, if the depth image has confirmed the wall;
//!   the point stays valid, and is counted in [`Tally::holes`](super::Tally);
//! * a median far from the wall: the edge is not the contact line there (liquid that rises behind it
//!   hides it); the point is dropped and counted.

use super::config::{Config, MAX_COLUMNS};
use super::extract::Tally;
use super::trace::{Edge, EdgePoint};
use crate::frame::DepthFrame;
use crate::math::median;
use heapless::Vec;

/// Columns on either side, and rows below the edge, of the window; its first row is 2 below the edge.
const HALF_WIDTH: usize = 2;
const ROWS: usize = 6;
const SKIPPED: usize = 2;
const WINDOW: usize = (2 * HALF_WIDTH + 1) * ROWS;
/// Fewest valid pixels of a window that is no hole.
const LEAST_PIXELS: usize = 6;
/// A pixel farther from the wall shows something else (background through a hole), metres.
const PIXEL_TOLERANCE_M: f32 = 0.012;
/// A window farther from the wall shows other liquid, metres: six times the noise of one pixel.
const WINDOW_TOLERANCE_M: f32 = 0.004;

/// A point of the edge in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    /// `x` from the glass axis, metres.
    pub(super) x_m: f32,
    /// Height above the inner bottom, metres.
    pub(super) z_m: f32,
}

/// The edge in space, `x` rising.
pub(super) type Samples = Vec<Sample, MAX_COLUMNS>;

/// What the depth image says of one edge point.
enum Measured {
    Residual(f32),
    Hole,
    NotTheWall,
}

/// Gives each edge point its place in space.
pub(super) fn place(
    config: &Config,
    depth: DepthFrame<'_>,
    axis_m: f32,
    edge: &Edge,
    samples: &mut Samples,
    tally: &mut Tally,
) {
    let mut measured: Vec<(EdgePoint, f32, Option<f32>), MAX_COLUMNS> = Vec::new();
    let mut residuals: Vec<f32, MAX_COLUMNS> = Vec::new();
    for &point in edge {
        let Some(wall_m) =
            config.camera.wall_depth(config.camera.ray(point.column as f32, point.row), axis_m)
        else {
            // The ray passes beside the glass: the outermost column, half covered.
            continue;
        };
        let residual = match measure(config, depth, axis_m, point) {
            Measured::Residual(residual) => Some(residual),
            Measured::Hole => None,
            Measured::NotTheWall => {
                tally.not_the_wall = tally.not_the_wall.saturating_add(1);
                continue;
            }
        };
        // Both lists hold as many as `edge`.
        let _ = measured.push((point, wall_m, residual));
        let _ = residual.map(|residual| residuals.push(residual));
    }
    let confirmed = 2 * residuals.len() >= edge.len();
    let of_frame = median(residuals.iter().copied()).filter(|_| confirmed);
    samples.clear();
    for &(point, wall_m, residual) in &measured {
        if residual.is_none() {
            tally.holes = tally.holes.saturating_add(1);
        }
        if let Some(residual) = residual.or(of_frame) {
            let ray = config.camera.ray(point.column as f32, point.row);
            let (x_m, z_m) = config.camera.point(ray, wall_m + residual);
            let _ = samples.push(Sample { x_m: x_m - axis_m, z_m });
        }
    }
}

/// The window of one point.
fn measure(config: &Config, depth: DepthFrame<'_>, axis_m: f32, point: EdgePoint) -> Measured {
    let first_row = point.row.max(0.0) as usize + SKIPPED;
    let left = point.column.saturating_sub(HALF_WIDTH);
    let right = point.column + HALF_WIDTH + 1;
    let mut residuals: Vec<f32, WINDOW> = Vec::new();
    let mut elsewhere = 0_usize;
    for row in first_row..first_row + ROWS {
        for (column, raw) in (left..right).zip(z16_row(depth, row, left, right)) {
            let z_m = f32::from(raw) * config.settings.depth_unit_m;
            let wall_m = config.camera.wall_depth(config.camera.ray(column as f32, row as f32), axis_m);
            match wall_m {
                Some(wall_m) if raw != 0 && (z_m - wall_m).abs() < PIXEL_TOLERANCE_M => {
                    let _ = residuals.push(z_m - wall_m);
                }
                Some(_) if raw != 0 => elsewhere += 1,
                _ => {}
            }
        }
    }
    if elsewhere > residuals.len() && elsewhere >= LEAST_PIXELS {
        return Measured::NotTheWall;
    }
    if residuals.len() < LEAST_PIXELS {
        return Measured::Hole;
    }
    match median(residuals.iter().copied()) {
        Some(residual) if residual.abs() < WINDOW_TOLERANCE_M => Measured::Residual(residual),
        _ => Measured::NotTheWall,
    }
}

/// Depth pixels `left..right` of a row; none where there is no such row.
fn z16_row(depth: DepthFrame<'_>, row: usize, left: usize, right: usize) -> impl Iterator<Item = u16> {
    let start = row.saturating_mul(depth.width);
    let bytes = |column: usize| start.saturating_add(column).saturating_mul(2);
    let pixels = depth.bytes.get(bytes(left)..bytes(right.min(depth.width))).unwrap_or(&[]);
    pixels.as_chunks().0.iter().map(|pixel| u16::from_le_bytes(*pixel))
}
