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
    ///
    /// ```
    /// use meniscus::latent::nn::{Dense, Matrix, PANEL};
    ///
    /// // W = (2), b = (1); rows are padded to a panel.
    /// let mut packed = [0.0; PANEL];
    /// packed[0] = 2.0;
    /// let weights = Matrix::new(&packed, 1, 1).unwrap().into();
    /// let mut y = [0.0];
    /// Dense { weights, bias: &[1.0] }.apply(&[3.0], &mut y);
    /// assert_eq!(y, [7.0]);
    /// ```
    pub fn apply(&self, x: &[f32], y: &mut [f32]) {
        for (y, b) in y.iter_mut().zip(self.bias) {
            *y = *b;
        }
        self.weights.accumulate(x, y);
    }
}

/// max(0, x), element by element.
///
/// ```
/// let mut x = [-1.0, 0.5];
/// meniscus::latent::nn::relu(&mut x);
/// assert_eq!(x, [0.0, 0.5]);
/// ```
pub fn relu(x: &mut [f32]) {
    for x in x {
        *x = x.max(0.0);
    }
}
