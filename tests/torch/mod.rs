//! The layers that training uses against PyTorch's losses and gradients, from the same weights.
//!
//! The data lie beside the repository in `../shared/data/torch-golden`; where they are absent the
//! tests say so and pass.

use burn::tensor::{Device, Tensor, TensorData};
use meniscus_optim::nets::{encoder, perceptron};
use meniscus_optim::weights::{Matrix, leaves, numbers, scalar};
use npyz::NpyFile;
use npyz::npz::NpzArchive;
use safetensors::SafeTensors;
use std::path::PathBuf;

/// Relative difference that single precision in another order of summation explains.
const TOLERANCE: f64 = 1e-4;

const BATCH: usize = 64;

fn golden(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/torch-golden").join(name);
    if !path.exists() {
        println!("skipped: {} is absent", path.display());
        return None;
    }
    Some(path)
}

struct Golden {
    weights: Vec<u8>,
    reference: PathBuf,
}

impl Golden {
    fn open() -> Option<Self> {
        let weights = std::fs::read(golden("bench.safetensors")?).expect("readable");
        Some(Self { weights, reference: golden("bench_ref.npz")? })
    }

    /// A tensor as a matrix: all but its first dimension are columns, a vector is one row.
    fn matrix(&self, name: &str) -> Matrix {
        let file = SafeTensors::deserialize(&self.weights).expect("a safetensors file");
        let view = file.tensor(name).expect(name);
        let numbers: Vec<f32> =
            view.data().as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        let rows = if view.shape().len() == 1 { 1 } else { view.shape()[0] };
        let columns = numbers.len() / rows;
        Matrix::new(rows, columns, numbers)
    }

    /// The numbers of one array of the reference.
    fn array(&self, name: &str) -> Vec<f64> {
        let mut archive = NpzArchive::open(&self.reference).expect("an npz file");
        let file: NpyFile<_> = archive.by_name(name).expect(name).expect(name);
        match file.dtype().num_bytes() {
            Some(8) => file.into_vec::<f64>().expect(name),
            _ => file.into_vec::<f32>().expect(name).into_iter().map(f64::from).collect(),
        }
    }
}

fn norm(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().map(|v| v * v).sum::<f64>().sqrt()
}

fn assert_near(ours: f64, torch: f64, what: &str) {
    assert!((ours - torch).abs() <= TOLERANCE * torch.abs(), "{what}: {ours} here, {torch} in PyTorch");
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
    assert_near(f64::from(scalar(loss)), golden.array(&format!("{net}.loss"))[0], net);
    for name in wanted {
        let index = names.iter().position(|n| n == name).expect(name);
        let ours = norm(
            numbers(tensors[index].grad_remove(&mut grads).expect("a gradient")).into_iter().map(f64::from),
        );
        assert_near(ours, norm(golden.array(&format!("{net}.grad.{name}"))), name);
    }
}

#[test]
fn encoder_loss_and_gradients_are_pytorchs() {
    let Some(golden) = Golden::open() else { return };
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
    let Some(golden) = Golden::open() else { return };
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
