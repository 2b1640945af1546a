//! The contact line of a clear liquid before a bright card, column by column, and the score of the whole curve.
//!
//! In light of 850 nm water absorbs: a path of `d` metres through it keeps the share `exp(-a d)`, `a = 4.3 /m` (Kou, Labrie
//! and Chylek, Appl. Opt. 32 (1993) 3531), so that the card looks a quarter darker through 70 mm. Just below the contact
//! line the meniscus bends the light of the card away, and shows as a band that is darker than the liquid:
//!
//! ```text
//! tone:  card ________
//!                     \          ______ liquid
//!                      \__band__/
//! row:   rim         line             foot
//! ```
//!
//! The line is where the tone falls steepest. The area of the step ([`super::edge`]) would count the band twice, and its
//! onset ([`super::contact`]) would take it for liquid behind.
//!
//! A column is searched from above, where there is nothing but glass. Depth is not asked: stereo sees anything behind or
//! before the liquid. Therefore the glass is where its silhouette and the stated distance put it. The curve is scored whole,
//! and one that scores low is no line:
//!
//! * the share of the glass's columns that have a step near their neighbours', [`LEAST_SHARE`];
//! * the share of those below which it stays darker by the step of a liquid, not of a rim or a scratch, [`LEAST_DARK`] and
//!   [`LEAST_TAKEN`].

use super::binarise::Threshold;
use super::config::{Config, MAX_COLUMNS};
use super::edge_points::{Edge, EdgePoint, Move, NEIGHBOURS, around};
use super::glass::Body;
use super::region::Grey;
use crate::math::median;
use heapless::Vec;

/// Dark pixels in a row that begin the liquid, from above.
const BEGINNING: usize = 2;
/// A column whose beginning is farther from its neighbours' median is looked at where they have theirs; rows, and
/// neighbours on either side.
const APART: usize = 4;
const BESIDE: usize = 6;
/// Rows on either side of the beginning in which the tone falls steepest.
const REACH: usize = 4;
/// A row farther from the neighbours' median than this is an outlier, pixels.
const ROW_TOLERANCE_PX: f32 = 1.2;
/// Least share of the columns of the glass with a line, and of those with liquid below it.
const LEAST_SHARE: f32 = 0.7;
const LEAST_DARK: f32 = 0.7;
/// Least share of the light from above the line that the liquid below it takes: `1 - exp(-a d)` is 0.26 for 70 mm of water and
/// 0.16 for 40 mm at 850 nm, of which the traced glasses show nine tenths; the walls of an empty one take less than 0.12.
const LEAST_TAKEN: f32 = 0.12;
/// Pixels above the line and below its band that tell card and liquid: first one and number.
const ABOVE: (usize, usize) = (4, 3);
const BELOW: (usize, usize) = (7, 6);
/// Rows by which the steepest place lies above the line, and their standard deviation, pixels: a blurred band leads, by more
/// the darker it is. Over the traced scenes that were looked at, with a blur of 0.6 to 0.9 pixel.
const LEAD_PX: f32 = 0.30;
const LEAD_STD_PX: f32 = 0.18;
/// Tone from which on pixels are cut off, grey levels.
const SATURATED: f32 = 252.0;

/// Traces the line; nothing if the whole curve is none. Returns the number of points beside a saturated tone.
pub(super) fn trace(
    config: &Config,
    image: Grey<'_>,
    body: Body,
    threshold: &Threshold,
    least: f32,
    edge: &mut Edge,
) -> usize {
    edge.clear();
    let mut begins: Vec<(usize, usize), MAX_COLUMNS> = Vec::new();
    for column in (body.left..=body.right).take(MAX_COLUMNS) {
        if let Some(row) = beginning(config, image, column, threshold) {
            // One a column, and no more columns than the list holds.
            let _ = begins.push((column, row));
        }
    }
    let (mut raw, mut saturated) = (Edge::new(), 0_usize);
    for (index, &(column, own)) in begins.iter().enumerate() {
        let near = around(&begins, index, BESIDE).map(|(_, row)| *row as f32);
        let usual = median(near).map_or(own, |row| row as usize);
        let row = if own.abs_diff(usual) > APART { usual } else { own };
        if let Some(row) = steepest(image, column, row, least) {
            let _ = raw.push(EdgePoint {
                column,
                row: row + LEAD_PX,
                own_px2: LEAD_STD_PX * LEAD_STD_PX,
                moved: Move::default(),
            });
        }
    }
    let mut dark = 0_usize;
    for (index, point) in raw.iter().enumerate() {
        let usual = median(around(&raw, index, NEIGHBOURS).map(|near| near.row)).unwrap_or(point.row);
        if (point.row - usual).abs() >= ROW_TOLERANCE_PX {
            continue;
        }
        let _ = edge.push(*point);
        if let Some([above, below]) = sides(image, *point) {
            dark += usize::from(above - below >= least.max(LEAST_TAKEN * above));
            saturated += usize::from(above >= SATURATED);
        }
    }
    let columns = body.right.saturating_sub(body.left).saturating_add(1) as f32;
    let found = edge.len() as f32;
    if found < LEAST_SHARE * columns || (dark as f32) < LEAST_DARK * found {
        edge.clear();
    }
    saturated
}

/// First row of the liquid, from the rim down.
fn beginning(config: &Config, image: Grey<'_>, column: usize, threshold: &Threshold) -> Option<usize> {
    let (top, bottom) = config.rows;
    let mut dark = 0;
    for row in top..bottom {
        if !threshold.is_liquid(image.at(column, row)?) {
            dark = 0;
            continue;
        }
        dark += 1;
        if dark == BEGINNING {
            return Some(row + 1 - BEGINNING);
        }
    }
    None
}

/// Row at which the tone falls steepest from above, within [`REACH`] rows of `near`; `None` if it falls by less than
/// `least` there in all.
///
/// With the falls `f_k = g_k - g_(k + 1)` between neighbours and the largest at `m`, the vertex of the parabola through
/// three of them: `m + 1/2 + (f_(m + 1) - f_(m - 1)) / (2 (2 f_m - f_(m - 1) - f_(m + 1)))`.
fn steepest(image: Grey<'_>, column: usize, near: usize, least: f32) -> Option<f32> {
    let at = |row: usize| image.at(column, row).map(f32::from);
    let fall = |row: usize| Some(at(row)? - at(row + 1)?);
    let first = near.checked_sub(REACH)?;
    let (mut row, mut most) = (first, 0.0);
    for candidate in first..near.saturating_add(REACH) {
        let fall = fall(candidate)?;
        if fall > most {
            (row, most) = (candidate, fall);
        }
    }
    let (before, behind) = (fall(row.checked_sub(1)?)?, fall(row + 1)?);
    let bend = 2.0 * most - before - behind;
    // Three falls are the whole of a blurred step.
    if before + most + behind < least || bend <= 0.0 {
        return None;
    }
    Some(row as f32 + 0.5 + 0.5 * (behind - before) / bend)
}

/// Tones above the line and below its band.
fn sides(image: Grey<'_>, point: EdgePoint) -> Option<[f32; 2]> {
    let row = (point.row + 0.5).max(0.0) as usize;
    let mean = |from: usize, count: usize| {
        let pixels = (from..from + count).filter_map(|row| image.at(point.column, row));
        pixels.map(f32::from).sum::<f32>() / count as f32
    };
    Some([mean(row.checked_sub(ABOVE.0 + ABOVE.1)?, ABOVE.1), mean(row + BELOW.0, BELOW.1)])
}
