//! The upper edge of the liquid, column by column, sub-pixel, outliers removed.
#![allow(
    clippy::manual_clamp,
    reason = "`clamp` keeps what is no number, `max` and `min` put a bound in its place"
)]

use super::binarise::Threshold;
use super::config::{Config, MAX_COLUMNS};
use super::contact::{Crossing, Crossings, lower, onset};
use super::edge::{REACH, SPAN, Tones, lead, spots};
use super::edge_points::{Edge, NEIGHBOURS, around};
use super::foam;
use super::glass::Body;
use super::region::Grey;
use super::settings::Liquid;
use crate::math::{median, sqrtf};
use heapless::Vec;

/// Background pixels in a row that end the liquid; fewer are speckle.
const ENDING: usize = 3;
/// A column whose background begins farther from its neighbours' median than this has a highlight or a dot there; it is
/// looked at where they have theirs. Rows, and neighbours on either side.
const APART: usize = 4;
const BESIDE: usize = 6;
/// A row farther from the neighbours' median than this is an outlier, pixels. The steepest surface
/// that fits into the glass rises by 3 pixels a column, and a slope moves no median.
const ROW_TOLERANCE_PX: f32 = 1.5;

/// Tone from which on pixels are cut off, grey levels, with the noise of a mean.
const SATURATED: f32 = 252.0;
/// Rows by which a cut-off step looks lower than it is, and their standard deviation, pixels.
const CLIPPED_PX: f32 = 0.4;
const CLIPPED_STD_PX: f32 = 0.25;
/// Lead of the steepest part of the steps that is noise, pixels; from twice that on it counts in full.
const LEAD_NOISE_PX: f32 = 0.04;

/// Variance of an edge of a liquid that shines through, square pixels: how far its tail reaches is known to a tenth of a
/// pixel.
const TAIL_PX2: f32 = 0.01;

/// Times that the step of a bright liquid is looked at again.
const ROUNDS: usize = 2;

/// Variance that spots of light on a bright liquid add to an edge, square pixels, over that of the spots, squares of the step. Dots
/// lie still, so that no mean over frames takes them off; calibrated on two path-traced glasses with eight patterns of dots each.
const SPOTS: f32 = 18.0;

/// Standard deviation of the inner pixels, as a share of the step, from which on a projector's dots are as bright as foam: it is not looked
/// for. Between rendered foam (1.6 % in most scenes, 5.4 % at most) and path-traced milk under dots of 60 grey levels (4.5 to 11 %).
const DOTTED: f32 = 0.05;

/// Step of one column.
#[derive(Clone, Copy, Debug)]
struct Step {
    column: usize,
    first_background: usize,
    tones: Tones,
    /// [`spots`] beside the edge.
    spots: f32,
}

/// Image of a liquid, and what is known of it.
#[derive(Clone, Copy)]
struct Look<'i> {
    image: Grey<'i>,
    /// Standard deviation of a pixel, grey levels.
    noise: f32,
    /// Least step of an edge, grey levels.
    least: f32,
    /// First row of the foot.
    foot: usize,
    /// A dark liquid absorbs what gets into it, a bright one does not.
    shines_through: bool,
}

/// Traces the edge of every column of the body; columns without a clear edge are left out. Returns the number of points
/// beside which a tone is saturated.
pub(super) fn trace(
    config: &Config,
    image: Grey<'_>,
    body: Body,
    threshold: &Threshold,
    least: f32,
    edge: &mut Edge,
) -> usize {
    let mut ends: Vec<(usize, usize), MAX_COLUMNS> = Vec::new();
    for column in (body.left..=body.right).take(MAX_COLUMNS) {
        if let Some(first_background) = coarse(config, image, column, threshold) {
            // One end a column, and no more columns than the list holds.
            let _ = ends.push((column, first_background));
        }
    }
    let look = Look {
        image,
        noise: body.noise(image, config.foot_rows),
        least,
        foot: config.foot_rows.1,
        shines_through: config.settings.liquid == Liquid::Bright,
    };
    let mut steps: Vec<Step, MAX_COLUMNS> = Vec::new();
    for (index, &(column, own)) in ends.iter().enumerate() {
        let near = around(&ends, index, BESIDE).map(|(_, row)| *row as f32);
        let usual = median(near).map_or(own, |row| row as usize);
        let first_background = if own.abs_diff(usual) > APART { usual } else { own };
        if let Some((profile, _)) = look.profile(column, first_background) {
            let (tones, spots) = (Tones::of(&profile), spots(&profile));
            let _ = steps.push(Step { column, first_background, tones, spots });
        }
    }
    let mut crossings = Crossings::new();
    let mut leads: Vec<f32, MAX_COLUMNS> = Vec::new();
    let mut saturated = 0_usize;
    for (index, step) in steps.iter().enumerate() {
        let tones = usual(&steps, index);
        let Some((mut crossing, lead)) = look.crossing(*step, tones) else { continue };
        if look.shines_through {
            let near = around(&steps, index, NEIGHBOURS);
            let spots = near.clone().map(|step| step.spots).sum::<f32>() / near.count() as f32;
            let fall = tones.inside - tones.outside;
            crossing.own_px2 += SPOTS * (spots - look.noise * look.noise).max(0.0) / (fall * fall);
        }
        saturated += usize::from(clipped(tones).is_some());
        let _ = crossings.push(crossing);
        if let Some(lead) = lead.filter(|_| look.shines_through) {
            let _ = leads.push(lead);
        }
    }
    let lead = median(leads.iter().copied()).unwrap_or(0.0);
    let lead = lead * ((lead.abs() - LEAD_NOISE_PX) / LEAD_NOISE_PX).max(0.0).min(1.0);
    crossings.iter_mut().for_each(|crossing| crossing.edge -= lead);
    let spots = sqrtf(steps.iter().map(|step| step.spots).sum::<f32>() / steps.len().max(1) as f32);
    let fall = median(steps.iter().map(|step| step.tones.inside - step.tones.outside)).unwrap_or(0.0);
    if look.shines_through && spots < DOTTED * fall {
        foam::lower_onsets(image, &mut crossings, look.foot, spots.max(look.noise));
    }
    let mut raw = Edge::new();
    lower(&crossings, &mut raw);
    edge.clear();
    for (index, point) in raw.iter().enumerate() {
        let usual = median(around(&raw, index, NEIGHBOURS).map(|near| near.row)).unwrap_or(point.row);
        if (point.row - usual).abs() < ROW_TOLERANCE_PX {
            let _ = edge.push(*point);
        }
    }
    saturated
}

/// Row of the first background above the foot.
fn coarse(config: &Config, image: Grey<'_>, column: usize, threshold: &Threshold) -> Option<usize> {
    let (top, _) = config.rows;
    let mut ending = 0;
    for row in (top..config.foot_rows.1).rev() {
        if threshold.is_liquid(image.at(column, row)?) {
            ending = 0;
            continue;
        }
        ending += 1;
        if ending == ENDING {
            return Some(row + ENDING - 1);
        }
    }
    None
}

/// Median tones of a column and as many neighbours on either side: a dot of light is narrower.
fn usual(steps: &[Step], index: usize) -> Tones {
    let reach = NEIGHBOURS.min(index).min(steps.len().saturating_sub(index + 1));
    let near = steps.iter().skip(index.saturating_sub(reach)).take(2 * reach + 1);
    Tones {
        inside: median(near.clone().map(|step| step.tones.inside)).unwrap_or(0.0),
        outside: median(near.map(|step| step.tones.outside)).unwrap_or(0.0),
    }
}

/// Step of one column, and how far inside reaches from the outer side of its profile's first pixel.
struct Placed {
    first_background: usize,
    profile: [f32; SPAN],
    own_px2: f32,
    inside: f32,
}

impl Look<'_> {
    /// Pixels from inside to outside: upwards from REACH rows below the first background, foam flattened; and the variance
    /// that this adds.
    fn profile(self, column: usize, first_background: usize) -> Option<([f32; SPAN], f32)> {
        let start = first_background + REACH;
        let mut profile = [0.0; SPAN];
        for (to, up) in profile.iter_mut().zip(0..) {
            *to = f32::from(self.image.at(column, start.checked_sub(up)?)?);
        }
        let own_px2 = foam::flatten(&mut profile, self.noise, self.shines_through);
        Some((profile, own_px2))
    }

    /// Looks at a step; at that of a bright liquid up to [`ROUNDS`] times again where it was found. A dot of light above its edge is
    /// taken for liquid, and the profile then begins too high to hold the edge.
    fn placed(self, column: usize, first_background: usize, tones: Tones) -> Option<Placed> {
        let look = |first_background: usize| {
            let (profile, own_px2) = self.profile(column, first_background)?;
            let inside = tones.inside_pixels(&profile, self.least)?;
            Some(Placed { first_background, profile, own_px2, inside })
        };
        let mut placed = look(first_background)?;
        for _ in 0..if self.shines_through { ROUNDS } else { 0 } {
            let there = ((placed.first_background + REACH) as f32 - placed.inside + 0.5) as usize;
            if there == placed.first_background {
                break;
            }
            placed = look(there)?;
        }
        Some(placed)
    }

    /// Places the edge between the pixels, and says how far the steepest part of the step leads it outwards.
    fn crossing(self, step: Step, tones: Tones) -> Option<(Crossing, Option<f32>)> {
        let Step { column, first_background, tones: own, .. } = step;
        // Within a highlight there is no step at all.
        if (own.inside - own.outside).abs() < self.least {
            return None;
        }
        let Placed { first_background, profile, own_px2, inside } =
            self.placed(column, first_background, tones)?;
        let (moved, clipped_px2) = clipped(tones).unwrap_or((0.0, 0.0));
        let edge = (first_background + REACH) as f32 + 0.5 - inside - moved;
        // The foot of foam's own blur begins below that of a clean edge, and says nothing of a band.
        let is_foam = own_px2 > 0.0 && !self.shines_through;
        let found =
            if is_foam { None } else { onset(self.image, column, first_background, self.foot, self.noise) };
        let (onset, band) = found.map_or((None, 0.0), |found| (Some(found.row), found.band));
        // The light that comes in through the surface of such a liquid brightens it there as a band would: none is certain.
        let (band, tail_px2) = if self.shines_through { (0.0, TAIL_PX2) } else { (band, 0.0) };
        let own_px2 = own_px2 + clipped_px2 + tail_px2;
        Some((Crossing { column, edge, onset, band, own_px2 }, lead(&profile, inside)))
    }
}

/// Rows by which an edge beside a saturated tone lies higher than it looks, and the variance of that.
///
/// A blurred step that is cut off at the top looks narrower, and nearer to its dark side. How far the light beyond the
/// cut goes is not seen: [`CLIPPED_PX`] is right for twice the light that the pixels hold.
fn clipped(tones: Tones) -> Option<(f32, f32)> {
    let outwards = match tones {
        Tones { outside, .. } if outside >= SATURATED => 1.0,
        Tones { inside, .. } if inside >= SATURATED => -1.0,
        _ => return None,
    };
    Some((outwards * CLIPPED_PX, CLIPPED_STD_PX * CLIPPED_STD_PX))
}
