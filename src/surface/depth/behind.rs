//! Liquid behind the contact line in the depth image: rows that are farther than the wall, within the glass, and nearer than
//! the background.
//!
//! It shows above the contact line in the liquid's own tone or in another one. Where the outline took it for the liquid at the wall, the
//! edge moves down below it ([`Look::rows_behind`]). Where the outline has found its lower border already, by a faint
//! difference of tone, the rows above the edge confirm it ([`Look::confirms`]).

use super::{Limits, Look, ROWS, SKIPPED, z16_row};
use crate::math::{median, sqrtf};
use crate::surface::config::MAX_COLUMNS;
use crate::surface::edge_points::{Edge, EdgePoint, NEIGHBOURS};
use heapless::Vec;

/// Most rows of such liquid.
pub(super) const THICKEST: usize = 20;
/// The border lies this many rows below the last row behind, by the fall of the last two residuals.
const BORDER: (f32, f32) = (0.5, 2.5);
/// Liquid behind the contact line lies within the glass, and nearer than this share of the way to the background.
const NEARER: f32 = 0.8;
/// Fewest rows that confirm a border: a pixel on the border to the background may have any depth between.
const LEAST_ROWS: usize = 2;

impl Look<'_> {
    /// Median distance of what is above the edge behind the wall; `None` without a depth, or if it is the wall's.
    pub(super) fn background(&self, edge: &Edge, seen_m: f32) -> Option<f32> {
        let mut above: Vec<f32, MAX_COLUMNS> = Vec::new();
        for point in edge.iter().step_by(NEIGHBOURS) {
            let row = (point.row.max(0.0) as usize).checked_sub(SKIPPED + 2 * ROWS);
            if let Some(residual) = row.and_then(|row| self.window(point.column, row)) {
                let _ = above.push(residual - seen_m);
            }
        }
        median(above.iter().copied()).filter(|behind| *behind > 0.0)
    }

    /// Distance behind the wall beyond which no liquid is: the chord `2 sqrt(R^2 - x^2)`, or the background.
    fn farthest_m(&self, column: usize, limits: Limits) -> f32 {
        let settings = &self.config.settings;
        let x_m = self.config.camera.across(column as f32) * settings.camera_distance_m - self.axis_m;
        let chord_m = 2.0 * sqrtf((settings.radius_m * settings.radius_m - x_m * x_m).max(0.0));
        chord_m.min(NEARER * limits.background_m.unwrap_or(chord_m / NEARER))
    }

    /// Distance of a pixel behind the wall; `None` in a hole.
    fn behind_m(&self, column: usize, row: usize, limits: Limits) -> Option<f32> {
        let (column, row) = self.in_depth(column, row)?;
        let raw = z16_row(self.depth, row, column, column.saturating_add(1)).next()?;
        Some(self.residual(column, row, raw)? - limits.seen_m)
    }

    /// Rows from an edge point down to the contact line below liquid that the depth image shows behind the wall.
    ///
    /// A surface that is seen comes nearer row by row; its last two residuals `r1`, `r2` give the rows after
    /// which it meets the wall: `(r2 - r0) / (r1 - r2)`.
    pub(super) fn rows_behind(&self, point: EdgePoint, limits: Limits) -> f32 {
        let edge = point.row.max(0.0) as usize;
        let farthest_m = self.farthest_m(point.column, limits);
        let mut last: Option<(usize, f32)> = None;
        let mut border = 0.0;
        for row in edge.saturating_add(1)..edge.saturating_add(1 + THICKEST) {
            match self.behind_m(point.column, row, limits) {
                Some(residual) if residual > limits.behind_m && residual < farthest_m => {
                    let fall = last.map_or(0.0, |(above, r)| (r - residual) / (row - above) as f32);
                    let rows = if fall > 0.0 { residual / fall } else { BORDER.0 };
                    border = row as f32 + rows.clamp(BORDER.0, BORDER.1) - point.row;
                    last = Some((row, residual));
                }
                Some(residual) if residual <= limits.behind_m => break,
                _ => {}
            }
        }
        border
    }

    /// Whether most of the rows over which the outline moved an edge point down show liquid behind the wall.
    pub(super) fn confirms(&self, point: EdgePoint, limits: Limits) -> bool {
        let edge = point.row.max(0.0) as usize;
        let moved = point.moved.rows.max(0.0) as usize;
        let farthest_m = self.farthest_m(point.column, limits);
        let is_behind = |row: &usize| {
            let residual = self.behind_m(point.column, *row, limits);
            residual.is_some_and(|residual| residual > limits.behind_m && residual < farthest_m)
        };
        let rows = (edge.saturating_sub(moved)..edge).filter(is_behind).count();
        rows >= LEAST_ROWS && 2 * rows > moved
    }
}
