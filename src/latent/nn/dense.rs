//! A dense layer: y = W x + b.

use super::{Vector, Weights};

/// Weights of a layer, read in place.
#[derive(Clone, Copy, Debug)]
pub struct Dense<'m> {
    /// W, `[outputs, inputs]`.
    pub weights: Weights<'m>,
    /// b, `[outputs]`.
    pub bias: Vector<'m>,
}

impl Dense<'_> {
    /// y = W x + b, as far as W has rows.
    pub fn apply(&self, x: &[f32], y: &mut [f32]) {
        for (y, b) in y.iter_mut().zip(self.bias) {
            *y = *b;
        }
        self.weights.accumulate(x, y);
    }
}

/// max(0, x), element by element.
pub fn relu(x: &mut [f32]) {
    for x in x {
        *x = x.max(0.0);
    }
}
