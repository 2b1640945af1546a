//! Where the surface goes next, how far that may be off, and when it stands highest.
//!
//! The GENERIC step is repeated from the present estimate without a measurement. What the hand or the
//! robot will do is not known, so the glass is taken to move on evenly (u = 0): the slosh then rings
//! out freely, and energy cannot rise. The interval counts what a glass that does move would add.

use super::estimator::Memory;
use crate::generic::{LATENTS, State};
use crate::model::Model;
use crate::surface::POINTS;

/// The surface some turns from now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forecast {
    /// The 21 heights, metres above the inner bottom.
    pub surface_m: [f32; POINTS],
    /// Half-widths that hold nine times out of ten, m.
    pub half_m: [f32; POINTS],
}

/// The highest that the surface will stand next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crest {
    /// Turns from now.
    pub frames: usize,
    /// Height of the highest point, metres above the inner bottom.
    pub height_m: f32,
    /// Half-width that holds nine times out of ten, m.
    pub half_m: f32,
    /// Whether the liquid may pass the rim: the crest with its half-width reaches it.
    pub spills: bool,
}

/// The decoder's surface of `state`, m.
fn surface(model: &Model<'_>, state: &State) -> [f32; POINTS] {
    let latent: [f64; LATENTS] = state.latent.into();
    let coefficients = model.decoder.coefficients(&latent.map(|x| x as f32), 0.0);
    model.decoder.surface(&coefficients)
}

impl Forecast {
    /// The surface `frames` turns after what `memory` holds.
    #[must_use]
    pub fn new(model: &Model<'_>, memory: &Memory, frames: usize) -> Self {
        let mut state = memory.state;
        let slosh = model.generic.potential.value(&state.latent);
        for _ in 0..frames {
            model.generic.step(&mut state, 0.0);
        }
        let half_m = model.spread.ahead(memory.covariance, &model.generic, slosh, frames);
        Self { surface_m: surface(model, &state), half_m }
    }
}

impl Crest {
    /// The first maximum over time of the highest point within `frames` turns after what `memory` holds,
    /// `None` if the surface only sinks. It costs a GENERIC step for each turn looked ahead.
    #[must_use]
    pub fn next(model: &Model<'_>, memory: &Memory, frames: usize) -> Option<Self> {
        let highest = |heights: &[f32; POINTS]| {
            let points = heights.iter().copied().enumerate();
            points.fold((0, f32::NEG_INFINITY), |best, point| if point.1 > best.1 { point } else { best })
        };
        let mut state = memory.state;
        let mut last = highest(&surface(model, &state));
        let mut rose = false;
        for ahead in 0..frames {
            model.generic.step(&mut state, 0.0);
            let now = highest(&surface(model, &state));
            if rose && now.1 < last.1 {
                let slosh = model.generic.potential.value(&memory.state.latent);
                let half = model.spread.ahead(memory.covariance, &model.generic, slosh, ahead);
                let half_m = half.get(last.0).copied().unwrap_or(0.0);
                let spills = f64::from(last.1 + half_m) >= model.header.rim_m;
                return Some(Self { frames: ahead, height_m: last.1, half_m, spills });
            }
            rose = now.1 > last.1;
            last = now;
        }
        None
    }
}
