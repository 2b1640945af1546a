//! Where the glass is: the left and right silhouette of the liquid below its surface, sub-pixel.
//!
//! Every row gives its own position of the axis; the mean of those near the median is taken, because
//! the position will be differentiated twice to give the acceleration.
//!
//! At the start both sides must be seen, as far apart as the glass is wide. Once the glass is tracked,
//! one side will do if the other is covered: the one that lies where the last position puts it. A
//! highlight that splits the body of liquid is bridged.

use super::binarise::Threshold;
use super::config::{Config, MAX_COLUMNS};
use super::edge::{REACH, SPAN, Tone, inside_pixels};
use super::region::{Grey, Region};
use crate::math;
use heapless::Vec;

/// Most rows that are averaged.
const MAX_ROWS: usize = 128;
/// Fewest rows that make a position.
const LEAST_ROWS: usize = 8;
/// A row whose axis is farther from the median than this is an outlier (about 0.3 pixel).
const ROW_TOLERANCE_M: f32 = 3e-4;

/// The two positions that the sides of one row give may differ by this much.
const SIDES_TOLERANCE_M: f32 = 4.5e-3;
/// Widest highlight that is bridged, as a share of the glass's width.
const BRIDGE: f32 = 0.25;
/// A side of a partly covered glass lies this near to where the last position puts it, pixels.
const TRACKED_PX: f32 = 8.0;

/// First and last column whose foot is liquid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Body {
    pub(super) left: usize,
    pub(super) right: usize,
    /// Whether the left and the right end are sides of the glass.
    sides: [bool; 2],
    /// Row to which the columns belong.
    row: f32,
    /// Approximate position of the axis, metres.
    near_m: f32,
}

/// The longest run of columns that hold mostly liquid in the rows of the foot, if it is as wide as
/// the glass (within a fifth), or if one of its ends is where the glass at `tracked_m` has it.
pub(super) fn find(
    config: &Config,
    image: Grey<'_>,
    region: Region,
    threshold: &Threshold,
    tracked_m: Option<f32>,
) -> Option<Body> {
    let (top, bottom) = config.foot_rows;
    let mut liquid = [0_usize; MAX_COLUMNS];
    for row in top..bottom {
        for (count, &grey) in liquid.iter_mut().zip(image.row(row, region.left, region.right)) {
            *count += usize::from(threshold.is_liquid(grey));
        }
    }
    let most = bottom.saturating_sub(top) / 2;
    let bridge = (BRIDGE * config.silhouette_px) as usize;
    let mut best: Option<(usize, usize)> = None;
    let mut run: Option<(usize, usize)> = None;
    for (column, &count) in (region.left..region.right).zip(liquid.iter()) {
        if count <= most {
            continue;
        }
        let begun = run.filter(|(_, last)| column - last <= bridge + 1).map_or(column, |(first, _)| first);
        run = Some((begun, column));
        if best.is_none_or(|(first, last)| column - begun > last.saturating_sub(first)) {
            best = run;
        }
    }
    let (left, right) = best?;
    let row = 0.5 * (top + bottom) as f32;
    let camera = &config.camera;
    let bearing = |u: f32| camera.bearing(camera.ray(u, row));
    let [l, r] = [bearing(left as f32 - 0.5), bearing(right as f32 + 0.5)];
    let width_px = (right.saturating_sub(left) + 1) as f32;
    if (width_px - config.silhouette_px).abs() < 0.2 * config.silhouette_px {
        return Some(Body { left, right, sides: [true; 2], row, near_m: camera.axis_of(l, r) });
    }
    let near_m = tracked_m.filter(|_| width_px < config.silhouette_px)?;
    let pixel_m = config.settings.camera_distance_m / config.settings.intrinsics.fx;
    let beside = |edge, side| (camera.axis_beside(edge, side, near_m) - near_m).abs() < TRACKED_PX * pixel_m;
    let sides = [beside(l, -1.0), beside(r, 1.0)];
    (sides[0] || sides[1]).then_some(Body { left, right, sides, row, near_m })
}

/// Position of the glass axis in metres, from rows (first, behind the last) that all hold liquid.
pub(super) fn axis(
    config: &Config,
    image: Grey<'_>,
    body: Body,
    rows: (usize, usize),
    least: f32,
) -> Option<f32> {
    let (top, bottom) = rows;
    let mut axes: Vec<f32, MAX_ROWS> = Vec::new();
    for row in top..bottom {
        if let Some(axis) = row_axis(config, image, body, row, least) {
            // A full list is long enough.
            if axes.push(axis).is_err() {
                break;
            }
        }
    }
    let median = math::median(axes.iter().copied())?;
    let near = || axes.iter().filter(|axis| (*axis - median).abs() < ROW_TOLERANCE_M);
    let count = near().count();
    (count >= LEAST_ROWS).then(|| near().sum::<f32>() / count as f32)
}

/// Position of the axis as one row sees it.
fn row_axis(config: &Config, image: Grey<'_>, body: Body, row: usize, least: f32) -> Option<f32> {
    let camera = &config.camera;
    // A pitched camera sees the sides of an upright glass aslant.
    let place = |column: usize| camera.follow(column as f32, body.row, row as f32).max(0.0) as usize;
    let bearing = |u| camera.bearing(camera.ray(u, row as f32));
    // From inside to outside: to the left from REACH - 1 columns right of the first liquid column.
    let left = || {
        let start = place(body.left).saturating_add(REACH - 1);
        let across = profile(image.row(row, (start + 1).checked_sub(SPAN)?, start + 1).iter().rev())?;
        Some(bearing(start as f32 + 0.5 - inside_pixels(&across, Tone::Line, least)?))
    };
    let right = || {
        let start = (place(body.right) + 1).checked_sub(REACH)?;
        let across = profile(image.row(row, start, start + SPAN).iter())?;
        Some(bearing(start as f32 - 0.5 + inside_pixels(&across, Tone::Line, least)?))
    };
    match body.sides {
        [true, true] => {
            let (left, right) = (left()?, right()?);
            let axis_m = camera.axis_of(left, right);
            let apart_m = camera.axis_beside(left, -1.0, axis_m) - camera.axis_beside(right, 1.0, axis_m);
            (apart_m.abs() < SIDES_TOLERANCE_M).then_some(axis_m)
        }
        [true, false] => Some(camera.axis_beside(left()?, -1.0, body.near_m)),
        _ => Some(camera.axis_beside(right()?, 1.0, body.near_m)),
    }
}

/// A profile of grey levels, if the image has all its pixels.
fn profile<'a>(pixels: impl ExactSizeIterator<Item = &'a u8>) -> Option<[f32; SPAN]> {
    let mut profile = [0.0; SPAN];
    if pixels.len() != SPAN {
        return None;
    }
    profile.iter_mut().zip(pixels).for_each(|(to, &grey)| *to = f32::from(grey));
    Some(profile)
}
