//! Window to latent: three GRU layers of 26 and a linear head.
//!
//! Beside the latents the head reads off the port value of this instant: the second difference of
//! the glass position is one frame old, and the inertial pressure follows the acceleration at once.

use crate::latent::generic::LATENTS;
use crate::latent::nn::{Gru, HIDDEN, Matrix, Vector};
use crate::latent::window::Row;

/// GRU layers, one above the other (paper: 3).
pub const GRU_LAYERS: usize = 3;

/// Numbers that the head reads off a window: the latents, then the port value.
pub const READINGS: usize = LATENTS + 1;

/// Weights of the encoder, read in place.
#[derive(Clone, Copy, Debug)]
pub struct Encoder<'m> {
    /// The layers, input first.
    pub layers: [Gru<'m>; GRU_LAYERS],
    /// Linear head, `[READINGS, HIDDEN]`.
    pub head: Matrix<'m>,
    /// Bias of the head.
    pub bias: Vector<'m>,
}

impl Encoder<'_> {
    /// Reads the latents and the port value off a window, from zero memory, oldest row first.
    ///
    /// ```
    /// # #[repr(align(64))]
    /// # struct Aligned<T: ?Sized>(T);
    /// # static BLOB: &Aligned<[u8]> =
    /// #     &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/models/glycerine.blob")));
    /// let model = meniscus::blob::Model::load(&BLOB.0)?;
    /// use meniscus::latent::window::{FEATURES, WINDOW};
    ///
    /// // Sixteen frames of a surface at rest, every point seen.
    /// let mut row = [0.0; FEATURES];
    /// row.iter_mut().skip(1).step_by(2).for_each(|seen| *seen = 1.0);
    /// let readings = model.encoder.encode([row; WINDOW].iter());
    /// assert!(readings.iter().all(|reading| reading.abs() < 0.5), "{readings:?}");
    /// # Ok::<(), meniscus::blob::LoadError>(())
    /// ```
    #[must_use]
    pub fn encode<'r>(&self, rows: impl Iterator<Item = &'r Row>) -> [f32; READINGS] {
        let mut memory = [[0.0; HIDDEN]; GRU_LAYERS];
        for row in rows {
            let mut below: &[f32] = row;
            for (layer, h) in self.layers.iter().zip(&mut memory) {
                layer.step(below, h);
                below = h;
            }
        }
        let mut readings = [0.0; READINGS];
        for (out, b) in readings.iter_mut().zip(self.bias) {
            *out = *b;
        }
        let [.., top] = &memory;
        self.head.accumulate(top, &mut readings);
        readings
    }
}
