//! Where the surface goes next.
//!
//! The GENERIC step is repeated from the present estimate without a measurement. What the hand or the
//! robot will do is not known, so the glass is taken to move on evenly (u = 0): the slosh then rings
//! out freely, and energy cannot rise.

use crate::generic::{Latent, State};
use crate::model::Model;
use crate::surface::POINTS;

/// The 21 heights of the surface in metres, `frames` turns after the state `latent`.
#[must_use]
pub fn surface_ahead(model: &Model<'_>, latent: &Latent, frames: usize) -> [f32; POINTS] {
    let mut state = State { latent: *latent, ..State::default() };
    for _ in 0..frames {
        model.generic.step(&mut state, 0.0);
    }
    let latent: [f64; crate::generic::LATENTS] = state.latent.into();
    let coefficients = model.decoder.coefficients(&latent.map(|x| x as f32), 0.0);
    model.decoder.surface(&coefficients)
}
