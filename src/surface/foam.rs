//! Foam between liquid and background.
//!
//! On a dark liquid foam outshines the bright background. The profile of a column is flattened from its brightest place on
//! ([`flatten`]), so that the edge is that of the liquid.
//!
//! On a bright liquid foam is brighter than both, and is taken for liquid:
//!
//! ```text
//! share:  0 front ________      ____                  peak: largest share of the band
//!                         \____|    |                 onset: from below the first half of it
//!                          foam     \____ -1: background
//! row:    edge + 19    onset       edge     edge - 6
//! ```
//!
//! The peak may be a twentieth of the step, and the band a pixel high: one column shows little more than its
//! noise. The mean of seven columns, each along its own edge, shows the band ([`lower_onsets`]). Light that
//! comes in through the surface of a liquid that shines through brightens it as foam does. Therefore a move down to this onset is one to a
//! faint band ([`super::hidden::take_back`]).

use super::config::MAX_COLUMNS;
use super::contact::{BACK_GAP, BACK_PIXELS, Crossings, FRONT_PIXELS, THICKEST};
use super::edge::SPAN;
use super::edge_points::{NEIGHBOURS, around};
use super::region::Grey;
use crate::math::sqrtf;
use heapless::Vec;

/// A place that lies beyond the background by this share of the step outshines it, and by this many standard deviations of a pixel:
/// the larger. A bright liquid has no foam there, but a shadow. Chosen on rendered scenes of the seeds 7 to 12.
const OVERSHOOT: f32 = 0.08;
const OVERSHOOT_DEVIATIONS: f32 = 4.0;
const SHADOW: f32 = 0.2;
/// Variance that a flattened profile adds to an edge, square pixels.
const FLATTENED_PX2: f32 = 0.09;

/// Rows from the front to the background, the edge among them.
const ROWS: usize = LOW + 1 + BACK_GAP + BACK_PIXELS;
/// Rows from the edge down to the lowest of the front.
const LOW: usize = THICKEST + FRONT_PIXELS - 1;
/// Rows of the edge's own blur, which are no band.
const BLUR: usize = 1;
/// Share of the step that the peak of a band has at least, and standard deviations of the mean: the larger. Chosen on rendered
/// scenes of the seeds 7 and 8 and on the two path-traced glasses of milk that are looked at.
const LEAST: f32 = 0.04;
const DEVIATIONS: f32 = 5.0;

/// Flattens a profile, from inside to outside, from the brightest place beyond the background on. Returns the variance
/// that this adds.
pub(super) fn flatten(profile: &mut [f32; SPAN], noise: f32, shines_through: bool) -> f32 {
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
    let least = if shines_through {
        SHADOW * step.abs()
    } else {
        (OVERSHOOT * step.abs()).max(OVERSHOOT_DEVIATIONS * noise)
    };
    if (peak - outside).abs() <= least {
        return 0.0;
    }
    profile.iter_mut().skip(place).for_each(|grey| *grey = peak);
    FLATTENED_PX2
}

/// Moves the onsets of bands down to those of foam where this sets in below them; `noise` is the standard deviation of a pixel, with the
/// dots of a projector.
pub(super) fn lower_onsets(image: Grey<'_>, crossings: &mut Crossings, foot: usize, noise: f32) {
    let mut found: Vec<Option<f32>, MAX_COLUMNS> = Vec::new();
    for index in 0..crossings.len() {
        // As many as the crossings, of which there are no more.
        let _ = found.push(onset(image, crossings, index, foot, noise));
    }
    for (crossing, foam) in crossings.iter_mut().zip(&found) {
        crossing.onset = match (crossing.onset, *foam) {
            (Some(own), Some(foam)) => Some(own.max(foam)),
            (own, foam) => own.or(foam),
        };
    }
}

/// Row at which foam sets in below the edge of a crossing; `None` where there is none.
fn onset(image: Grey<'_>, crossings: &Crossings, index: usize, foot: usize, noise: f32) -> Option<f32> {
    let own = crossings.get(index)?.edge;
    if own as usize + THICKEST + FRONT_PIXELS > foot {
        return None;
    }
    let mut tones = [0.0; ROWS];
    let mut count = 0.0;
    for near in around(crossings, index, NEIGHBOURS) {
        add(&mut tones, image, near.column, near.edge)?;
        count += 1.0;
    }
    let front = tones.iter().take(FRONT_PIXELS).sum::<f32>() / FRONT_PIXELS as f32;
    let step = front - tones.iter().rev().take(BACK_PIXELS).sum::<f32>() / BACK_PIXELS as f32;
    // All tones are sums over the columns still: this is a step of a grey level.
    if step <= count {
        return None;
    }
    let share = |tone: f32| (tone - front) / step;
    let band = || tones.iter().skip(FRONT_PIXELS).take(THICKEST - BLUR).map(|tone| share(*tone));
    let peak = band().fold(0.0, f32::max);
    if peak < LEAST.max(DEVIATIONS * noise * sqrtf(count) / step) {
        return None;
    }
    let half = 0.5 * peak;
    let mut below = tones.get(FRONT_PIXELS - 1).map_or(0.0, |tone| share(*tone));
    for (share, up) in band().zip(0_u8..) {
        if share >= half {
            let part = (share - half) / (share - below).max(1e-3);
            return Some(own + (LOW - FRONT_PIXELS) as f32 - f32::from(up) + part);
        }
        below = share;
    }
    None
}

/// Adds the tones of a column along its edge, from the lowest row of the front upwards, between its pixels.
fn add(tones: &mut [f32; ROWS], image: Grey<'_>, column: usize, edge: f32) -> Option<()> {
    let lowest = edge + LOW as f32;
    let (row, share) = (lowest as usize, lowest - (lowest as usize) as f32);
    let mut lower = f32::from(image.at(column, row.checked_add(1)?)?);
    for (tone, up) in tones.iter_mut().zip(0..) {
        let upper = f32::from(image.at(column, row.checked_sub(up)?)?);
        *tone += upper + share * (lower - upper);
        lower = upper;
    }
    Some(())
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::super::contact::Crossing;
    use super::*;
    use std::vec::Vec;

    const WIDTH: usize = 40;
    const HEIGHT: usize = 80;
    /// Edge of the liquid to what is above it, and tones of liquid and background.
    const EDGE: f32 = 31.5;
    const TONES: [f32; 2] = [170.0, 40.0];

    /// A liquid with foam of this tone and height, rows, on its columns from 10 to 30; a pixel is as bright as what covers it.
    fn onsets(foam: f32, rows: f32) -> Vec<Option<f32>> {
        let covered = |from: f32, to: f32, row: usize| {
            (to.min(row as f32 + 0.5) - from.max(row as f32 - 0.5)).clamp(0.0, 1.0)
        };
        let top = |column: usize| if (10..30).contains(&column) { EDGE - rows } else { EDGE };
        let pixel = |at: usize| {
            let (column, row) = (at % WIDTH, at / WIDTH);
            let (in_foam, in_liquid) = (covered(top(column), EDGE, row), covered(EDGE, 1e3, row));
            let [liquid, background] = TONES;
            let grain = [0.0, 3.0, -3.0][(7 * column + 5 * row) % 3];
            (foam * in_foam + liquid * in_liquid + background * (1.0 - in_foam - in_liquid) + grain) as u8
        };
        let bytes: Vec<u8> = (0..WIDTH * HEIGHT).map(pixel).collect();
        let crossing =
            |column: usize| Crossing { column, edge: top(column), onset: None, band: 0.0, own_px2: 0.0 };
        let crossings: Crossings = (0..WIDTH).map(crossing).collect();
        let image = Grey { bytes: &bytes, width: WIDTH };
        (0..WIDTH).map(|index| onset(image, &crossings, index, 70, 2.4)).collect()
    }

    #[test]
    fn foam_sets_in_where_the_liquid_ends() {
        for (foam, rows) in [(210.0, 4.0), (200.0, 3.0), (182.0, 3.0), (200.0, 2.0)] {
            let all = onsets(foam, rows);
            for (column, found) in all.iter().enumerate().filter(|(column, _)| (14..26).contains(column)) {
                let off = found.map(|row| row - EDGE);
                assert!(off.is_some_and(|off| off.abs() < 0.6), "foam {foam}, column {column}: {off:?}");
            }
        }
    }

    #[test]
    fn where_no_foam_is_none_is_found() {
        assert!(onsets(TONES[0], 3.0).iter().all(Option::is_none));
        let beside = onsets(210.0, 3.0);
        let far = |column: usize| !(6..34).contains(&column);
        assert!(
            beside.iter().enumerate().all(|(column, found)| found.is_none() || !far(column)),
            "{beside:?}"
        );
    }
}
