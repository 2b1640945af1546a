//! Where the glass is: the left and right silhouette of the liquid below its surface, sub-pixel.
//!
//! Every row gives its own position of the axis; the mean of those near the median is taken, because
//! the position will be differentiated twice to give the acceleration.

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

/// First and last column whose foot is liquid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Body {
    pub(super) left: usize,
    pub(super) right: usize,
}

/// The longest run of columns that hold mostly liquid in the rows of the foot, if it is as wide as
/// the glass (within a fifth).
pub(super) fn find(config: &Config, image: Grey<'_>, region: Region, threshold: &Threshold) -> Option<Body> {
    let (top, bottom) = config.foot_rows;
    let mut liquid = [0_usize; MAX_COLUMNS];
    for row in top..bottom {
        for (count, &grey) in liquid.iter_mut().zip(image.row(row, region.left, region.right)) {
            *count += usize::from(threshold.is_liquid(grey));
        }
    }
    let most = bottom.saturating_sub(top) / 2;
    let mut best: Option<Body> = None;
    let mut run: Option<Body> = None;
    for (column, &count) in (region.left..region.right).zip(liquid.iter()) {
        if count <= most {
            run = None;
            continue;
        }
        let body = Body { right: column, ..run.unwrap_or(Body { left: column, right: column }) };
        run = Some(body);
        if best.is_none_or(|best| body.right - body.left > best.right.saturating_sub(best.left)) {
            best = Some(body);
        }
    }
    best.filter(|body| {
        let width_px = (body.right.saturating_sub(body.left) + 1) as f32;
        (width_px - config.silhouette_px).abs() < 0.2 * config.silhouette_px
    })
}

/// Position of the glass axis in metres, from the rows `top..bottom`, all of which hold liquid.
pub(super) fn axis(
    config: &Config,
    image: Grey<'_>,
    body: Body,
    (top, bottom): (usize, usize),
    least: f32,
) -> Option<f32> {
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
    // From inside to outside: to the left from REACH - 1 columns right of the first liquid column.
    let left_start = body.left + REACH - 1;
    let left = profile(image.row(row, (left_start + 1).checked_sub(SPAN)?, left_start + 1).iter().rev())?;
    let right_start = (body.right + 1).checked_sub(REACH)?;
    let right = profile(image.row(row, right_start, right_start + SPAN).iter())?;
    let left_px = left_start as f32 + 0.5 - inside_pixels(&left, Tone::Line, least)?;
    let right_px = right_start as f32 - 0.5 + inside_pixels(&right, Tone::Line, least)?;
    let camera = &config.camera;
    let bearing = |u| camera.bearing(camera.ray(u, row as f32));
    Some(camera.axis_of(bearing(left_px), bearing(right_px)))
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
