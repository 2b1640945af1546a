//! The layers that training uses against PyTorch's losses and gradients, from the same weights.
//!
//! `fixtures/torch/make.py` made the numbers; weights and inputs are drawn from the same seeds here and there.

use burn::tensor::{Device, Tensor, TensorData};
use meniscus_optim::nets::{encoder, perceptron};
use meniscus_optim::weights::{Matrix, leaves, numbers, scalar};
use seeded::{BATCH, Seeded, difference};

mod seeded;

/// Relative difference that single precision in another order of summation explains.
const TOLERANCE: f64 = 1e-4;

struct Golden(Seeded);

impl Golden {
    /// A tensor as a matrix: all but its first dimension are columns, a vector is one row.
    fn matrix(&self, name: &str) -> Matrix {
        let (numbers, shape) = self.0.tensor(name);
        let rows = if shape.len() == 1 { 1 } else { shape[0] };
        let columns = numbers.len() / rows;
        Matrix::new(rows, columns, numbers)
    }
}

/// Compares the loss and the gradients of the named weights.
fn compare(
    golden: &Golden,
    net: &str,
    names: &[String],
    tensors: &[Tensor<2>],
    loss: Tensor<1>,
    wanted: &[&str],
) {
    let mut grads = loss.backward();
    let (ours, torchs) = (f64::from(scalar(loss)), golden.0.reference(&format!("{net}.loss"))[0]);
    assert!((ours / torchs - 1.0).abs() < TOLERANCE, "{net}: loss {ours} here, {torchs} in PyTorch");
    for name in wanted {
        let index = names.iter().position(|n| n == name).expect(name);
        let ours = numbers(tensors[index].grad_remove(&mut grads).expect("a gradient"));
        let torchs = golden.0.reference(&format!("{net}.grad.{name}"));
        let error = difference(ours.into_iter().map(f64::from), &torchs);
        println!("gradient of {name}: relative difference {error:.1e}");
        assert!(error < TOLERANCE, "the gradient of {name} differs from PyTorch's by {error:e}");
    }
}

#[test]
fn encoder_loss_and_gradients_are_pytorchs() {
    let golden = Golden(Seeded::open());
    let device = Device::flex().autodiff();
    let parts = ["wih", "whh", "bih", "bhh"];
    let mut names: Vec<String> =
        (0..3).flat_map(|layer| parts.map(|part| format!("gru.{layer}.{part}"))).collect();
    names.extend([String::from("fc.w"), String::from("fc.b")]);
    let weights: Vec<Matrix> = names.iter().map(|n| golden.matrix(n)).collect();
    let tensors = leaves(&weights, &device);
    let input = golden.matrix("x.gru");
    let step = |k: usize| {
        let rows = input.values.chunks_exact(16 * 42).flat_map(|w| w[k * 42..(k + 1) * 42].iter().copied());
        Tensor::from_data(TensorData::new(rows.collect::<Vec<f32>>(), [BATCH, 42]), &device)
    };
    let miss = encoder((0..16).map(step).collect(), &tensors) - golden.matrix("y.gru").tensor(&device);
    let wanted = ["gru.0.wih", "gru.1.whh", "gru.2.bhh", "fc.w"];
    compare(&golden, "gru", &names, &tensors, miss.square().mean(), &wanted);
}

#[test]
fn autoencoder_loss_and_gradients_are_pytorchs() {
    let golden = Golden(Seeded::open());
    let device = Device::flex().autodiff();
    let names: Vec<String> = ["e", "d"]
        .iter()
        .flat_map(|half| (0..5).flat_map(move |k| ["w", "b"].map(|part| format!("ae.{half}{k}.{part}"))))
        .collect();
    let weights: Vec<Matrix> = names.iter().map(|n| golden.matrix(n)).collect();
    let tensors = leaves(&weights, &device);
    let x = golden.matrix("x.ae").tensor(&device);
    // First and last layer of each half are linear.
    let bent = |layer: usize| (1..4).contains(&layer);
    let z = perceptron(x.clone(), &tensors[..10], bent);
    let again = perceptron(z.clone(), &tensors[10..], bent);
    let loss = (again - x).square().mean() + z.abs().mean() * 1e-3;
    compare(&golden, "ae", &names, &tensors, loss, &["ae.e4.w", "ae.d0.w", "ae.e1.b"]);
}
