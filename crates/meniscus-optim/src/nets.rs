//! The layers, as functions of burn tensors: linear, perceptron, GRU. Weights are stored as PyTorch
//! and the blob store them, `[outputs, inputs]`; a bias is one row.

use burn::tensor::Tensor;
use burn::tensor::activation::{relu, sigmoid};
pub use meniscus::latent::encoder::GRU_LAYERS as LAYERS;
pub use meniscus::latent::nn::HIDDEN as CELLS;

/// y = x W^T + b for every row of `x`.
#[must_use]
pub fn linear(x: Tensor<2>, weight: &Tensor<2>, bias: &Tensor<2>) -> Tensor<2> {
    x.matmul(weight.clone().transpose()) + bias.clone()
}

/// Linear layers `[W, b, W, b, ...]`; `bent(i)` says whether a ReLU follows layer `i`.
#[must_use]
pub fn perceptron(x: Tensor<2>, weights: &[Tensor<2>], bent: impl Fn(usize) -> bool) -> Tensor<2> {
    weights.chunks_exact(2).enumerate().fold(x, |x, (layer, pair)| {
        let y = linear(x, &pair[0], &pair[1]);
        if bent(layer) { relu(y) } else { y }
    })
}

/// Hidden states of one GRU layer over the steps of `inputs` (each `[batch, features]`), zero
/// initial state. `weights` are W_i `[3 c, f]`, W_h `[3 c, c]`, b_i, b_h, gates in the order r, z, n:
///
/// r = s(W_ir x + b_ir + W_hr h + b_hr), z likewise, n = tanh(W_in x + b_in + r (W_hn h + b_hn)),
/// h' = (1 - z) n + z h (the equations of PyTorch's `nn.GRU`).
#[must_use]
pub fn gru_layer(inputs: Vec<Tensor<2>>, weights: &[Tensor<2>]) -> Vec<Tensor<2>> {
    let (into, back) = (weights[0].clone().transpose(), weights[1].clone().transpose());
    let cells = weights[1].dims()[1];
    let mut hidden: Option<Tensor<2>> = None;
    let mut states = Vec::with_capacity(inputs.len());
    for x in inputs {
        let from_input = x.matmul(into.clone()) + weights[2].clone();
        let h = hidden.unwrap_or_else(|| Tensor::zeros([from_input.dims()[0], cells], &from_input.device()));
        let from_state = h.clone().matmul(back.clone()) + weights[3].clone();
        let gates =
            sigmoid(from_input.clone().narrow(1, 0, 2 * cells) + from_state.clone().narrow(1, 0, 2 * cells));
        let (r, z) = (gates.clone().narrow(1, 0, cells), gates.narrow(1, cells, cells));
        let n = (from_input.narrow(1, 2 * cells, cells) + r * from_state.narrow(1, 2 * cells, cells)).tanh();
        let next = n.clone() + z * (h - n);
        states.push(next.clone());
        hidden = Some(next);
    }
    states
}

/// Three GRU layers and a linear head on the last step. `weights` are four matrices a layer, then
/// the head and its bias; the result is `[batch, outputs]`.
#[must_use]
pub fn encoder(window: Vec<Tensor<2>>, weights: &[Tensor<2>]) -> Tensor<2> {
    let (recurrent, head) = weights.split_at(4 * LAYERS);
    let mut states = recurrent.chunks_exact(4).fold(window, gru_layer);
    let last = states.pop().expect("a window has at least one frame");
    linear(last, &head[0], &head[1])
}
