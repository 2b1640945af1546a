//! How far the edge is: measured depth just below it, compared with the wall it must lie on.
//!
//! The contact line lies on the wall that faces the camera, whose depth `w(u)` follows from the
//! glass position. Per edge point the median residual `r` of `z - w` over the valid pixels of a small
//! window in the liquid is taken: the wall curves within the window, the residual does not. The
//! median `r0` of the residuals of the frame is how far the camera stands from where it is told to be.
//!
//! * enough valid pixels: depth = w + r;
//! * too few (a hole): depth = w + r0, but only if at least half of the traced points are measured,
//!   that is, if the depth image has confirmed the wall; the point stays valid, and is counted in
//!   [`Tally::holes`](super::Tally);
//! * `r` far from `r0`: the edge is not the contact line there (liquid that rises behind it hides
//!   it); the point is dropped and counted in [`Tally::not_the_wall`](super::Tally).

use super::config::{Config, MAX_COLUMNS};
use super::extract::{NotSeen, Tally};
use super::trace::{Edge, EdgePoint};
use crate::frame::DepthFrame;
use crate::math::median;
use heapless::Vec;

/// Columns on either side of the window, its rows, and the rows between the edge and its first one.
const HALF_WIDTH: usize = 2;
const ROWS: usize = 6;
const SKIPPED: usize = 2;
const WINDOW: usize = (2 * HALF_WIDTH + 1) * ROWS;
/// Fewest valid pixels of a window that is no hole.
const LEAST_PIXELS: usize = 6;
/// A window farther from the others' median shows other liquid, metres: six times the noise of a pixel.
const WINDOW_TOLERANCE_M: f32 = 0.004;
/// The camera is this near to where it is told to be, or the settings are wrong, metres.
const PLACE_TOLERANCE_M: f32 = 0.015;

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

/// Gives each edge point its place in space; returns `r0`, metres.
pub(super) fn place(
    config: &Config,
    depth: DepthFrame<'_>,
    axis_m: f32,
    edge: &Edge,
    samples: &mut Samples,
    tally: &mut Tally,
) -> Result<f32, NotSeen> {
    samples.clear();
    // One residual for each point of `edge`, in its order; both lists are as long at most.
    let mut residuals: Vec<Option<f32>, MAX_COLUMNS> = Vec::new();
    for &point in edge {
        let _ = residuals.push(residual(config, depth, axis_m, point));
    }
    let measured = residuals.iter().copied().flatten();
    let offset_m = median(measured.clone()).ok_or(NotSeen::NoDepth)?;
    if offset_m.abs() > PLACE_TOLERANCE_M {
        return Err(NotSeen::WallElsewhere);
    }
    let confirmed = 2 * measured.count() >= edge.len();
    for (point, &residual) in edge.iter().zip(&residuals) {
        let residual = match residual {
            Some(residual) if (residual - offset_m).abs() < WINDOW_TOLERANCE_M => residual,
            Some(_) => {
                tally.not_the_wall = tally.not_the_wall.saturating_add(1);
                continue;
            }
            None => {
                tally.holes = tally.holes.saturating_add(1);
                if !confirmed {
                    continue;
                }
                offset_m
            }
        };
        let ray = config.camera.ray(point.column as f32, point.row);
        // The ray of an outermost column, half covered, may pass beside the glass.
        if let Some(wall_m) = config.camera.wall_depth(ray, axis_m) {
            let (x_m, z_m) = config.camera.point(ray, wall_m + residual);
            let _ = samples.push(Sample { x_m: x_m - axis_m, z_m });
        }
    }
    Ok(offset_m)
}

/// Median of measured depth less wall depth in the window below an edge point; `None` in a hole.
fn residual(config: &Config, depth: DepthFrame<'_>, axis_m: f32, point: EdgePoint) -> Option<f32> {
    let first_row = (point.row.max(0.0) as usize).saturating_add(SKIPPED);
    let left = point.column.saturating_sub(HALF_WIDTH);
    let right = point.column.saturating_add(HALF_WIDTH + 1);
    let mut residuals: Vec<f32, WINDOW> = Vec::new();
    for row in first_row..first_row.saturating_add(ROWS) {
        for (column, raw) in (left..right).zip(z16_row(depth, row, left, right)) {
            let wall_m = config.camera.wall_depth(config.camera.ray(column as f32, row as f32), axis_m);
            if let Some(wall_m) = wall_m.filter(|_| raw != 0) {
                let _ = residuals.push(f32::from(raw) * config.settings.depth_unit_m - wall_m);
            }
        }
    }
    median(residuals.iter().copied()).filter(|_| residuals.len() >= LEAST_PIXELS)
}

/// Depth pixels `left..right` of a row; none where there is no such row.
fn z16_row(depth: DepthFrame<'_>, row: usize, left: usize, right: usize) -> impl Iterator<Item = u16> {
    let start = row.saturating_mul(depth.width);
    let bytes = |column: usize| start.saturating_add(column).saturating_mul(2);
    let pixels = depth.bytes.get(bytes(left)..bytes(right.min(depth.width))).unwrap_or(&[]);
    pixels.as_chunks().0.iter().map(|pixel| u16::from_le_bytes(*pixel))
}
