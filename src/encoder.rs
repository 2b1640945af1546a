//! Window to latent: three GRU layers of 26 and a linear head.

use crate::generic::LATENTS;
use crate::nn::{Gru, HIDDEN, Matrix, Vector};
use crate::window::Row;

/// GRU layers, one above the other (paper: 3).
pub const GRU_LAYERS: usize = 3;

/// Weights of the encoder, read in place.
#[derive(Clone, Copy, Debug)]
pub struct Encoder<'m> {
    /// The layers, input first.
    pub layers: [Gru<'m>; GRU_LAYERS],
    /// Linear head, `[LATENTS, HIDDEN]`.
    pub head: Matrix<'m>,
    /// Bias of the head.
    pub bias: Vector<'m>,
}

impl Encoder<'_> {
    /// The latent that the encoder reads off a window, from zero memory, oldest row first.
    #[must_use]
    pub fn encode<'r>(&self, rows: impl Iterator<Item = &'r Row>) -> [f32; LATENTS] {
        let mut memory = [[0.0; HIDDEN]; GRU_LAYERS];
        for row in rows {
            let mut below: &[f32] = row;
            for (layer, h) in self.layers.iter().zip(&mut memory) {
                layer.step(below, h);
                below = h;
            }
        }
        let mut latent = [0.0; LATENTS];
        for (out, b) in latent.iter_mut().zip(self.bias) {
            *out = *b;
        }
        let [.., top] = &memory;
        self.head.accumulate(top, &mut latent);
        latent
    }
}
