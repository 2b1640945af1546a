//! Liquid that shows above its own contact line, and how the contact line is found below it.
//!
//! Where the surface rises behind the contact line faster than the line of sight, a band of it shows
//! between contact line and background. It mirrors the room, so its tone lies a little off that of the
//! liquid at the wall, and the edge to the background, `e`, is not the contact line any more:
//!
//! ```text
//! tone:  front ___________            onset: first 10 % of the step from front to background
//!                         \__ band    e: edge to the background
//!                            \_______ background
//! row:   foot     onset     e    rim
//! ```
//!
//! At a clean edge `D = onset - e` is the width of the blur's foot, the same in all columns; a band
//! adds to it. That width is read from the frame itself: the lower quartile of `D`, because a band
//! shows on the raised side of the liquid only. Columns with an excess of `D` take the onset instead
//! of the edge; bands below a pixel and a half stay, in part, unnoticed. Bands that are faint are taken back
//! if they do not fit the shape of the surface ([`super::hidden::take_back`]).

use super::config::MAX_COLUMNS;
use super::edge_points::{Edge, EdgePoint, Move, NEIGHBOURS, around};
use super::region::Grey;
use crate::math::{median, sqrtf};
use heapless::Vec;

/// The front tone is the mean of this many pixels, this far below the edge: the thickest band.
pub(super) const FRONT_PIXELS: usize = 6;
pub(super) const THICKEST: usize = 14;
/// The background's tone is the mean of this many pixels, this far above the edge.
pub(super) const BACK_PIXELS: usize = 3;
pub(super) const BACK_GAP: usize = 3;
/// Share of the step from front to background at which a band sets in, and standard deviations of the
/// pixels: the larger.
const ONSET: f32 = 0.1;
const ONSET_DEVIATIONS: f32 = 3.0;
/// The front's pixels differ by less than this share of the step.
const UNEVEN: f32 = 0.25;
/// Variance of a point that was moved: a part of the excess, squared, and this many square pixels.
const MOVED_SHARE: f32 = 0.2;
const MOVED_PX2: f32 = 0.04;
/// Excess of `D` that is noise, and that from which on the onset is taken, pixels.
const NOISE_PX: f32 = 0.12;
const CERTAIN_PX: f32 = 0.35;
/// Rows of the first background's blur.
const BLUR: usize = 2;
/// A band nearer to the front's tone than this share of the step is faint: foam is brighter.
const FAINT: f32 = 0.45;
/// From the onset of a band back to its middle: the blurred step of a band rises through `ONSET` near its half.
const ONSET_LEAD_PX: f32 = 0.1;

/// The edge to the background in one column, with the onset below it if that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossing {
    pub(super) column: usize,
    pub(super) edge: f32,
    pub(super) onset: Option<f32>,
    /// Tone of the band, as [`Onset`] has it; 0, faint, where the liquid shines through.
    pub(super) band: f32,
    /// Variance beside the usual scatter, square pixels.
    pub(super) own_px2: f32,
}

/// Crossings of all columns, columns rising.
pub(super) type Crossings = Vec<Crossing, MAX_COLUMNS>;

/// Onset of a band in one column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Onset {
    pub(super) row: f32,
    /// Share of the step from front to background just below the first background's blur.
    pub(super) band: f32,
}

/// Row at which a column leaves the tone of the front on the way up to the first background;
/// `None` if the column is too short, or never leaves it.
pub(super) fn onset(
    image: Grey<'_>,
    column: usize,
    first_background: usize,
    foot: usize,
    noise: f32,
) -> Option<Onset> {
    let start = first_background.saturating_add(THICKEST);
    if start.saturating_add(FRONT_PIXELS) > foot {
        return None;
    }
    let mean = |from: usize, count: usize| {
        let pixels = (from..from.saturating_add(count)).filter_map(|row| image.at(column, row));
        pixels.map(f32::from).sum::<f32>() / count as f32
    };
    let front = mean(start, FRONT_PIXELS);
    let tones =
        (start..start.saturating_add(FRONT_PIXELS)).filter_map(|row| image.at(column, row)).map(f32::from);
    let (low, high) = tones.fold((255.0_f32, 0.0_f32), |(low, high), tone| (low.min(tone), high.max(tone)));
    let step = mean(first_background.checked_sub(BACK_GAP + BACK_PIXELS)?, BACK_PIXELS) - front;
    // Where something else begins within the front, its tone says nothing.
    if high - low > UNEVEN * step.abs() {
        return None;
    }
    let limit = ONSET.max(ONSET_DEVIATIONS * noise / step.abs().max(1.0));
    let mut below = 0.0;
    let mut rising: Option<f32> = None;
    // A band may be darker or brighter than the front.
    let share_at = |row: usize| Some(((f32::from(image.at(column, row)?) - front) / step).abs());
    for row in (first_background.saturating_sub(BACK_GAP)..start).rev() {
        let share = share_at(row)?;
        match rising {
            // Two pixels in a row are no speckle.
            Some(at) if share >= limit => {
                let band = share_at(first_background.saturating_add(BLUR))?;
                return Some(Onset { row: at, band });
            }
            _ => rising = (share >= limit).then(|| row as f32 + (share - limit) / (share - below).max(1e-3)),
        }
        below = share.min(limit);
    }
    None
}

/// Moves the crossings that lie above a band down to its onset.
pub(super) fn lower(crossings: &Crossings, edge: &mut Edge) {
    let mut gaps: Vec<Option<f32>, MAX_COLUMNS> = Vec::new();
    for (index, crossing) in crossings.iter().enumerate() {
        let _ = gaps.push(crossing.onset.map(|onset| (onset - crossing.edge) / slant(crossings, index)));
    }
    let found = || gaps.iter().copied().flatten();
    let half = median(found()).unwrap_or(0.0);
    let clean = median(found().filter(|gap| *gap <= half)).unwrap_or(0.0);
    edge.clear();
    for (index, crossing) in crossings.iter().enumerate() {
        let near = around(&gaps, index, NEIGHBOURS).copied();
        let excess = median(near.flatten()).unwrap_or(clean) - clean;
        let share = ((excess - NOISE_PX) / (CERTAIN_PX - NOISE_PX)).clamp(0.0, 1.0);
        let contact = crossing.onset.map_or(crossing.edge, |onset| onset - ONSET_LEAD_PX);
        let row = crossing.edge + share * (contact - crossing.edge);
        // In between it is not known which of the two is the contact line.
        let doubt = MOVED_SHARE * excess.max(0.0) + (share * (1.0 - share)) * excess.abs();
        let moved = if share > 0.0 { MOVED_PX2 + doubt * doubt } else { 0.0 };
        let bands = around(crossings, index, NEIGHBOURS);
        let band = median(bands.filter(|near| near.onset.is_some()).map(|near| near.band)).unwrap_or(0.0);
        let _ = edge.push(EdgePoint {
            column: crossing.column,
            row,
            own_px2: crossing.own_px2 + moved,
            moved: Move { rows: row - crossing.edge, variance_px2: moved, faint: band < FAINT },
        });
    }
}

/// Returns the length of a blurred edge along its column over that across itself, `sqrt(1 + slope^2)`: the
/// blur is round.
fn slant(crossings: &Crossings, index: usize) -> f32 {
    let around = || crossings.iter().skip(index.saturating_sub(1)).take(3);
    let slope = match (around().next(), around().next_back()) {
        (Some(first), Some(last)) if last.column > first.column => {
            (last.edge - first.edge) / (last.column - first.column) as f32
        }
        _ => 0.0,
    };
    sqrtf(1.0 + slope * slope)
}
