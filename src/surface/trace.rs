//! The upper edge of the liquid, column by column, sub-pixel, outliers removed.

use super::binarise::Threshold;
use super::config::{Config, MAX_COLUMNS};
use super::contact::{Crossing, Crossings, lower, onset};
use super::edge::{REACH, SPAN, Tone, inside_pixels};
use super::edge_points::{Edge, NEIGHBOURS};
use super::glass::Body;
use super::region::Grey;
use crate::math::median;

/// Background pixels in a row that end the liquid; fewer are speckle.
const ENDING: usize = 3;
/// A row farther from the neighbours' median than this is an outlier, pixels. The steepest surface
/// that fits into the glass rises by 3 pixels a column, and a slope moves no median.
const ROW_TOLERANCE_PX: f32 = 1.5;

/// A band over the edge brighter than the background by this share of the step is foam.
const OVERSHOOT: f32 = 0.2;
/// Variance that foam adds to an edge, square pixels.
const FOAM_PX2: f32 = 0.09;

/// Traces the edge of every column of the body; columns without a clear edge are left out.
pub(super) fn trace(
    config: &Config,
    image: Grey<'_>,
    body: Body,
    threshold: &Threshold,
    least: f32,
    edge: &mut Edge,
) {
    let mut crossings = Crossings::new();
    let noise = noise(image, body, config.foot_rows);
    for column in (body.left..=body.right).take(MAX_COLUMNS) {
        if let Some(crossing) = column_edge(config, image, column, threshold, least, noise) {
            // One point a column, and no more columns than the list holds.
            let _ = crossings.push(crossing);
        }
    }
    let mut raw = Edge::new();
    lower(&crossings, &mut raw);
    edge.clear();
    for (index, point) in raw.iter().enumerate() {
        let start = index.saturating_sub(NEIGHBOURS);
        let near = raw.iter().skip(start).take(index - start + NEIGHBOURS + 1);
        let usual = median(near.map(|p| p.row)).unwrap_or(point.row);
        if (point.row - usual).abs() < ROW_TOLERANCE_PX {
            let _ = edge.push(*point);
        }
    }
}

/// Goes up from the foot to the first background, then places the edge between the pixels.
fn column_edge(
    config: &Config,
    image: Grey<'_>,
    column: usize,
    threshold: &Threshold,
    least: f32,
    noise: f32,
) -> Option<Crossing> {
    let (top, _) = config.rows;
    let mut ending = 0;
    let mut first_background = None;
    for row in (top..config.foot_rows.1).rev() {
        if threshold.is_liquid(image.at(column, row)?) {
            ending = 0;
        } else {
            ending += 1;
            if ending == ENDING {
                first_background = Some(row + ENDING - 1);
                break;
            }
        }
    }
    // From inside to outside: upwards from REACH rows below the first background.
    let first_background = first_background?;
    let start = first_background + REACH;
    let mut profile = [0.0; SPAN];
    for (to, up) in profile.iter_mut().zip(0..) {
        *to = f32::from(image.at(column, start.checked_sub(up)?)?);
    }
    let own_px2 = flatten_foam(&mut profile);
    let edge = start as f32 + 0.5 - inside_pixels(&profile, Tone::Level, least)?;
    let onset = onset(image, column, first_background, config.foot_rows.1, noise);
    Some(Crossing { column, edge, onset, own_px2 })
}

/// Foam that outshines the background is a band of its own between liquid and background: the profile is
/// flattened from its brightest place on, so that the edge is the one of the liquid. Gives the variance
/// that this adds.
fn flatten_foam(profile: &mut [f32; SPAN]) -> f32 {
    let (inside, outside) = (profile.first().copied(), profile.last().copied());
    let (Some(inside), Some(outside)) = (inside, outside) else { return 0.0 };
    let step = outside - inside;
    let mut peak = outside;
    let mut place = SPAN;
    for (index, &grey) in profile.iter().enumerate() {
        if (grey - peak) * step > 0.0 {
            (peak, place) = (grey, index);
        }
    }
    if (peak - outside) * step <= OVERSHOOT * step * step {
        return 0.0;
    }
    profile.iter_mut().skip(place).for_each(|grey| *grey = peak);
    FOAM_PX2
}

/// Standard deviation of the pixels in the foot, from the differences of neighbours in a column:
/// the median of `|d|` is 0.954 of it.
fn noise(image: Grey<'_>, body: Body, rows: (usize, usize)) -> f32 {
    let (top, bottom) = rows;
    let row = top + bottom.saturating_sub(top) / 2;
    let differences = (body.left..=body.right).filter_map(|column| {
        let [one, other] = [image.at(column, row)?, image.at(column, row + 1)?].map(f32::from);
        Some((one - other).abs())
    });
    median(differences).unwrap_or(0.0) / 0.954
}
