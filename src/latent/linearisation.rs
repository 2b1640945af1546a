//! First-order expansion of the decoder's surface about one state.
//!
//! ```text
//! z_i(x + dx, u + du) = z_i + sum_j dz_i/dx_j dx_j + dz_i/du du
//! ```
//! The trunk is piecewise linear, so the slopes are exact on the piece that x lies on: a hidden unit passes a change on
//! where it is above zero, and stops it elsewhere. The filter corrects the state with it; the surface that leaves the turn
//! is decoded again at the corrected state.

use super::decoder::{Decoder, Hidden, MAX_COEFFICIENTS, MAX_TRUNK};
use super::generic::LATENTS;
use crate::surface::POINTS;

/// Surface of the decoder at one state, and its slopes there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linearisation {
    /// The 21 heights, m.
    pub heights_m: [f32; POINTS],
    /// dz / dx of the heights, one row a latent, m.
    pub latent_slopes_m: [[f32; POINTS]; LATENTS],
    /// dz / du of the heights: the inertial part follows the input at once, m.
    pub input_slopes_m: [f32; POINTS],
}

impl Decoder<'_> {
    /// Returns the surface and its slopes at a latent `x` and an input `u`.
    #[must_use]
    pub fn linearise(&self, x: &[f32; LATENTS], u: f32) -> Linearisation {
        let hidden = self.hidden(x);
        Linearisation {
            heights_m: self.surface(&self.coefficients_behind(&hidden, x, u)),
            latent_slopes_m: self.latent_slopes_m(&hidden),
            input_slopes_m: self.input_slopes_m(),
        }
    }

    /// dz / dx of the heights where the hidden layers are `hidden`, one row a latent, m.
    fn latent_slopes_m(&self, hidden: &Hidden) -> [[f32; POINTS]; LATENTS] {
        let [one, two, three] = &self.trunk;
        // Of the last layer the surface's rows alone.
        let (last, before) = three.weights.from_row(self.surface.first);
        let mut slopes = [[0.0; POINTS]; LATENTS];
        let (mut inner, mut outer, mut c) = ([0.0; MAX_TRUNK], [0.0; MAX_TRUNK], [0.0; MAX_COEFFICIENTS]);
        for (latent, slope) in slopes.iter_mut().enumerate() {
            let mut along = [0.0; LATENTS];
            if let Some(slot) = along.get_mut(latent) {
                *slot = 1.0;
            }
            for (place, rows) in [
                (&mut inner[..], one.weights.rows()),
                (&mut outer[..], two.weights.rows()),
                (&mut c[..], last.rows()),
            ] {
                place.iter_mut().take(rows).for_each(|number| *number = 0.0);
            }
            one.weights.accumulate_sparse(&along, &mut inner);
            stop_at_silent(&mut inner, &hidden.first);
            two.weights.accumulate_sparse(&inner, &mut outer);
            stop_at_silent(&mut outer, &hidden.second);
            last.accumulate_sparse(&outer, &mut c);
            let c = c.get_mut(before..).unwrap_or_default();
            for (row, c) in (self.surface.first..self.linear.rows()).zip(c.iter_mut()) {
                *c += self.linear.at(row, latent);
            }
            self.surface.basis.accumulate(c, slope);
        }
        slopes
    }

    /// dz / du of the heights, the same at every state, m.
    fn input_slopes_m(&self) -> [f32; POINTS] {
        let mut heights = [0.0; POINTS];
        self.surface.basis.accumulate(self.port.get(self.surface.first..).unwrap_or_default(), &mut heights);
        heights
    }
}

/// Stops a change where a hidden unit is silent.
fn stop_at_silent(change: &mut [f32], unit: &[f32]) {
    for (change, unit) in change.iter_mut().zip(unit) {
        if *unit <= 0.0 {
            *change = 0.0;
        }
    }
}
