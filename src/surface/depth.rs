//! Distance of the edge, and whether it is the contact line: the depth image compared with the wall.
//!
//! The contact line lies on the wall that faces the camera, whose depth `w(u, v)` follows from the glass
//! position. All comparisons are made in residuals `z - w`, in which the wall is flat:
//!
//! * far below each edge point, where only the front of the liquid can be, the median residual of a small
//!   window; the median `r0` of those around the axis is the error of the camera's stated distance, and every
//!   point takes it: its depth is `w + r0`. A single window is noisier than the wall is uncertain, and the
//!   border of the depth image, which is wrong by some pixels either way, is not asked at all;
//! * the windows below the edge far from `r0`: the edge is not the contact line there; the point is dropped
//!   ([`Tally::not_the_wall`](super::Tally)). Nearer than the wall, one window is enough; farther, the next one
//!   below has to agree, because behind a border that is too low the background shows;
//! * too few valid pixels (a hole): the point stays, if at least half of the points are measured
//!   ([`Tally::holes`](super::Tally));
//! * the window above the edge nearer than the wall: something covers the glass there, and the edge is
//!   its own; the point is dropped ([`Tally::covered`](super::Tally));
//! * rows below the edge that are far behind the wall, but within the glass and nearer than the background above
//!   the edge: liquid that rises behind the contact line and shows above it in the liquid's own tone. The point
//!   moves down to where their residuals run to `r0`, by the mean over the neighbours
//!   ([`Tally::behind`](super::Tally)). Rows at the background's own distance are a border that is too low, and
//!   the edge in the outline's image holds;
//! * such rows above an edge that the outline moved down to a faint band: the move is certain.
//!
//! A glass wall is a lens ([`super::refraction`]): stereo sees the liquid behind it up to its own thickness away from
//! where it is, and points are placed where the bent ray meets the inner wall.
//!
//! Where the outline is traced in an image of another lens (colour), the depth image is looked at where its own lens
//! sees the wall, and its residuals are taken along its own rays. What lies behind the wall is then looked for
//! some pixels beside its column: a lens 15 mm to the side sees 70 mm behind a wall 365 mm away 2.5 pixels off.

mod behind;

use super::config::{Config, MAX_COLUMNS};
use super::deproject::Ray;
use super::edge_points::{Edge, EdgePoint, Move, NEIGHBOURS, Samples, around};
use super::outcome::{ExtractionError, Tally};
use super::resample::median_error;
use super::wall_sample::{Glass, Lowered, Wall, sample};
use crate::math::median;
use crate::usb::frame::DepthFrame;
use behind::THICKEST;
use heapless::Vec;

/// Columns on either side of the window, its rows, and the rows between the edge and its first one.
const HALF_WIDTH: usize = 2;
const ROWS: usize = 6;
const SKIPPED: usize = 2;
const WINDOW: usize = (2 * HALF_WIDTH + 1) * ROWS;
/// Fewest valid pixels of a window that is no hole.
const LEAST_PIXELS: usize = 6;
/// A window farther from the others' median shows something else, metres, or as many times the usual deviation.
const WINDOW_TOLERANCE_M: (f32, f32) = (0.004, 0.010);
const WINDOW_DEVIATIONS: f32 = 6.0;
/// A pixel this far behind the wall shows liquid behind the contact line, metres; a pixel scatters more
/// than a window.
const BEHIND_M: (f32, f32) = (0.005, 0.012);
const BEHIND_DEVIATIONS: f32 = 8.0;
/// Neighbours that must show liquid behind the contact line.
const LEAST_BEHIND: usize = 3;
/// Largest error of the camera's stated distance, metres; beyond it the settings are wrong.
const PLACE_TOLERANCE_M: f32 = 0.015;
/// Columns whose windows tell the same: the window's width and the reach of the matching.
const GROUP: f32 = 8.0;

/// Share of the silhouette's half width around the axis whose windows tell `r0`: there the wall faces the camera, and
/// a border at the side of the glass is far. Fewest windows that do.
const CENTRAL: f32 = 0.4;
const LEAST_CENTRAL: usize = 8;
/// Disagreement of the depth image with the straight rays to the wall, in thicknesses of the glass.
const LENS: f32 = 1.5;

/// Limits of the comparisons in one frame, metres.
#[derive(Clone, Copy, Debug)]
struct Limits {
    /// `r0` as the depth image shows it: with the lift by the glass.
    seen_m: f32,
    /// A window farther from it shows something else.
    tolerance_m: f32,
    /// A pixel farther behind it shows no front of liquid.
    behind_m: f32,
    /// Distance of the background behind the wall, if it has a depth.
    background_m: Option<f32>,
}

/// Gives each edge point its place in space.
pub(super) fn place(
    config: &Config,
    depth: DepthFrame<'_>,
    glass: Glass,
    edge: &Edge,
    samples: &mut Samples,
    tally: &mut Tally,
) -> Result<Wall, ExtractionError> {
    samples.clear();
    let Glass { axis_m, wall } = glass;
    let apart = config.settings.depth_lens_m;
    let look = Look { config, depth, axis_m, depth_axis_m: axis_m - apart[0], apart };
    // One residual for each point of `edge`, in its order; both lists are as long at most.
    let mut residuals: Vec<Option<f32>, MAX_COLUMNS> = Vec::new();
    let foot = config.foot_rows.1.saturating_sub(ROWS);
    for &point in edge {
        let deep = point.row.max(0.0) as usize + THICKEST;
        let _ = residuals.push(look.window(point.column, deep.min(foot)));
    }
    let measured = residuals.iter().copied().flatten();
    let axis_column = config.camera.column_of(axis_m);
    let central = || {
        let near = |column: usize| (column as f32 - axis_column).abs() < 0.5 * CENTRAL * config.silhouette_px;
        edge.iter().zip(&residuals).filter(move |(point, _)| near(point.column)).filter_map(|(_, r)| *r)
    };
    let seen_m = if central().count() < LEAST_CENTRAL { median(measured.clone()) } else { median(central()) };
    let seen_m = seen_m.ok_or(ExtractionError::NoDepth)?;
    let offset_m = seen_m + wall.lift_m();
    if offset_m.abs() > PLACE_TOLERANCE_M {
        return Err(ExtractionError::WallElsewhere);
    }
    let deviation_m = median(measured.clone().map(|r| (r - seen_m).abs())).unwrap_or(0.0);
    let count = measured.count();
    let limits = Limits {
        seen_m,
        tolerance_m: (WINDOW_DEVIATIONS * deviation_m).clamp(WINDOW_TOLERANCE_M.0, WINDOW_TOLERANCE_M.1)
            + LENS * wall.thickness_m,
        behind_m: (BEHIND_DEVIATIONS * deviation_m).clamp(BEHIND_M.0, BEHIND_M.1) + LENS * wall.thickness_m,
        background_m: look.background(edge, seen_m),
    };
    let mut bands: Vec<f32, MAX_COLUMNS> = Vec::new();
    let mut confirmed: Vec<bool, MAX_COLUMNS> = Vec::new();
    for &point in edge {
        let _ = bands.push(look.rows_behind(point, limits));
        let _ = confirmed.push(point.moved.faint && look.confirms(point, limits));
    }
    for (index, point) in edge.iter().enumerate() {
        let near = around(&bands, index, NEIGHBOURS);
        let shown = near.clone().filter(|rows| **rows > 0.0).count() >= LEAST_BEHIND;
        let lowered = if shown { near.clone().sum::<f32>() / near.count() as f32 } else { 0.0 };
        let is_certain = around(&confirmed, index, NEIGHBOURS).filter(|is| **is).count() >= LEAST_BEHIND;
        let moved = Move { faint: point.moved.faint && !is_certain, ..point.moved };
        let point = EdgePoint { row: point.row + lowered, moved, ..*point };
        let measured = 2 * count >= edge.len();
        match look.judge(point, limits, measured) {
            Verdict::NotTheWall => tally.not_the_wall = tally.not_the_wall.saturating_add(1),
            Verdict::Covered => tally.covered = tally.covered.saturating_add(1),
            Verdict::Hole { kept: false } => tally.holes = tally.holes.saturating_add(1),
            seen @ (Verdict::Wall | Verdict::Hole { .. }) => {
                if lowered > 0.0 {
                    tally.behind = tally.behind.saturating_add(1);
                }
                if seen != Verdict::Wall {
                    tally.holes = tally.holes.saturating_add(1);
                }
                if let Some(sample) = sample(config, glass, offset_m, Lowered { point, rows: lowered }) {
                    let _ = samples.push(sample);
                }
            }
        }
    }
    Ok(Wall { offset_m, scatter_m: median_error(deviation_m, count, GROUP) })
}

/// Verdict of the depth image about an edge point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    /// The liquid at the wall ends here.
    Wall,
    /// No depth; kept if most of the others are measured.
    Hole { kept: bool },
    /// Something else than the wall is below the edge.
    NotTheWall,
    /// Something before the glass is above the edge.
    Covered,
}

/// The depth image beside the wall of a glass at `axis_m`. Pixels are those of the outline unless a name says depth.
#[derive(Clone, Copy)]
struct Look<'d> {
    config: &'d Config,
    depth: DepthFrame<'d>,
    axis_m: f32,
    /// The same for the lens of the depth image.
    depth_axis_m: f32,
    apart: [f32; 3],
}

impl Look<'_> {
    /// The pixel of the depth image that shows the wall where the outline's image has it; the same pixel if one
    /// lens takes both, `None` beside the glass.
    fn in_depth(&self, column: usize, row: usize) -> Option<(usize, usize)> {
        if self.apart == [0.0; 3] {
            return Some((column, row));
        }
        let camera = &self.config.camera;
        let (u, v) = (column as f32, row as f32);
        let wall_m = camera.wall_depth(camera.ray(u, v), self.axis_m)?;
        let (u, v) = camera.seen_from(self.apart, u, v, wall_m);
        (u >= 0.0 && v >= 0.0).then_some(((u + 0.5) as usize, (v + 0.5) as usize))
    }

    /// `z - w` of a depth pixel `raw`; `None` in a hole and beside the glass.
    fn residual(&self, column: usize, row: usize, raw: u16) -> Option<f32> {
        self.along(self.config.depth_camera.ray(column as f32, row as f32), raw)
    }

    /// The same along a ray that is known.
    fn along(&self, ray: Ray, raw: u16) -> Option<f32> {
        if raw == 0 {
            return None;
        }
        let wall_m = self.config.depth_camera.wall_depth(ray, self.depth_axis_m)?;
        Some(f32::from(raw) * self.config.settings.depth_unit_m - wall_m)
    }

    /// Compares the windows beside an edge point with the wall; `measured`: most points of the frame have a depth.
    fn judge(&self, point: EdgePoint, limits: Limits, measured: bool) -> Verdict {
        let edge = point.row.max(0.0) as usize;
        let off = |first_row: usize| Some(self.window(point.column, first_row)? - limits.seen_m);
        let below = off(edge.saturating_add(SKIPPED));
        let farther = below.is_some_and(|off| off >= limits.tolerance_m);
        let below = if farther { off(edge.saturating_add(SKIPPED + ROWS)) } else { below };
        match below {
            Some(off) if off.abs() >= limits.tolerance_m => return Verdict::NotTheWall,
            None if !measured => return Verdict::Hole { kept: false },
            _ => {}
        }
        let above = edge.checked_sub(SKIPPED + ROWS).and_then(off);
        match above {
            Some(off) if off < -limits.tolerance_m => Verdict::Covered,
            _ if below.is_none() => Verdict::Hole { kept: true },
            _ => Verdict::Wall,
        }
    }

    /// Median residual in the window around a column from a row on; `None` in a hole.
    fn window(&self, column: usize, first_row: usize) -> Option<f32> {
        let (column, first_row) = self.in_depth(column, first_row)?;
        let left = column.saturating_sub(HALF_WIDTH);
        let right = column.saturating_add(HALF_WIDTH + 1);
        let mut residuals: Vec<f32, WINDOW> = Vec::new();
        // A window holds as many columns as rays across; the divisions are made once for each.
        let mut across = [0.0; 2 * HALF_WIDTH + 1];
        across.iter_mut().zip(left..).for_each(|(to, u)| *to = self.config.depth_camera.across(u as f32));
        for row in first_row..first_row.saturating_add(ROWS) {
            let level = self.config.depth_camera.level(row as f32);
            for (&across, raw) in across.iter().zip(z16_row(self.depth, row, left, right)) {
                if let Some(residual) = self.along(level.to_the_right(across), raw) {
                    let _ = residuals.push(residual);
                }
            }
        }
        median(residuals.iter().copied()).filter(|_| residuals.len() >= LEAST_PIXELS)
    }
}

/// Depth pixels `left..right` of a row; none where there is no such row.
fn z16_row(depth: DepthFrame<'_>, row: usize, left: usize, right: usize) -> impl Iterator<Item = u16> {
    let start = row.saturating_mul(depth.width);
    let bytes = |column: usize| start.saturating_add(column).saturating_mul(2);
    let pixels = depth.bytes.get(bytes(left)..bytes(right.min(depth.width))).unwrap_or(&[]);
    pixels.as_chunks().0.iter().map(|pixel| u16::from_le_bytes(*pixel))
}

#[cfg(test)]
mod tests;
