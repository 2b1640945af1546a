//! One gated recurrent unit layer, with PyTorch's equations and gate order.
//!
//! ```text
//! r  = sigmoid(W_ir x + b_ir + W_hr h + b_hr)
//! z  = sigmoid(W_iz x + b_iz + W_hz h + b_hz)
//! n  = tanh(W_in x + b_in + r * (W_hn h + b_hn))
//! h' = (1 - z) * n + z * h
//! ```
//! Cho et al. 2014, in the variant of PyTorch's `torch.nn.GRU` (the reset gate acts after the product).

use super::{Vector, Weights};
use crate::latent::nn::cpu_width::{Kernel, widest};
use crate::math::{sigmoidf, tanhf};

/// Units of a layer (paper: 26).
pub const HIDDEN: usize = 26;

/// Weights of a layer, read in place.
#[derive(Clone, Copy, Debug)]
pub struct Gru<'m> {
    /// W_i, `[3 HIDDEN, inputs]`, gates stacked in the order r, z, n.
    pub input: Weights<'m>,
    /// W_h, `[3 HIDDEN, HIDDEN]`.
    pub hidden: Weights<'m>,
    /// b_i, `3 HIDDEN`.
    pub input_bias: Vector<'m>,
    /// b_h, `3 HIDDEN`.
    pub hidden_bias: Vector<'m>,
}

/// The three gates' sums, one row a gate.
type Gates = [[f32; HIDDEN]; 3];

impl Gru<'_> {
    /// Advances the memory `h` by one input `x`.
    pub fn step(&self, x: &[f32], h: &mut [f32; HIDDEN]) {
        let input = affine(&self.input, self.input_bias, x);
        let hidden = affine(&self.hidden, self.hidden_bias, h);
        widest(Recur { input: &input, hidden: &hidden, h });
    }
}

/// The gates and the new memory, from both sums.
struct Recur<'a> {
    input: &'a Gates,
    hidden: &'a Gates,
    h: &'a mut [f32; HIDDEN],
}

impl Kernel for Recur<'_> {
    #[inline(always)]
    fn run<const WIDE: bool>(self) {
        let ([ir, iz, i_n], [hr, hz, hn]) = (self.input, self.hidden);
        let input = ir.iter().zip(iz).zip(i_n);
        let hidden = hr.iter().zip(hz).zip(hn);
        for (h, (((ir, iz), i_n), ((hr, hz), hn))) in self.h.iter_mut().zip(input.zip(hidden)) {
            let r = sigmoidf(ir + hr);
            let z = sigmoidf(iz + hz);
            let n = tanhf(i_n + r * hn);
            *h = (1.0 - z) * n + z * *h;
        }
    }
}

/// b + W x for the three gates.
fn affine(w: &Weights<'_>, b: Vector<'_>, x: &[f32]) -> Gates {
    let mut gates: Gates = [[0.0; HIDDEN]; 3];
    let sums = gates.as_flattened_mut();
    for (sum, b) in sums.iter_mut().zip(b) {
        *sum = *b;
    }
    w.accumulate(x, sums);
    gates
}
