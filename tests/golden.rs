//! The paper-size networks on the camera side's layers, against PyTorch's numbers.
//!
//! The data lie beside the repository in `../shared/data/torch-golden`; where they are absent the
//! tests say so and pass.
#![allow(clippy::disallowed_methods, reason = "only storey 1 must compute the same bits on every platform")]

use meniscus::latent::nn::{Gru, HIDDEN, Matrix, packed_index, packed_len};
use nalgebra::{SMatrix, SVector};
use npyz::NpyFile;
use npyz::npz::NpzArchive;
use safetensors::SafeTensors;
use std::path::PathBuf;

/// Relative difference that single precision in another order of summation explains.
const TOLERANCE: f64 = 1e-5;

/// Samples in a batch.
const BATCH: usize = 64;

fn golden(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/torch-golden").join(name);
    if !path.exists() {
        println!("skipped: {} is absent", path.display());
        return None;
    }
    Some(path)
}

/// Weights and inputs.
struct Weights(Vec<u8>);

impl Weights {
    fn open() -> Option<Self> {
        Some(Self(std::fs::read(golden("bench.safetensors")?).expect("readable")))
    }

    fn tensor(&self, name: &str) -> (Vec<f32>, Vec<usize>) {
        let file = SafeTensors::deserialize(&self.0).expect("a safetensors file");
        let view = file.tensor(name).expect(name);
        let numbers = view.data().as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        (numbers, view.shape().to_vec())
    }

    /// A matrix packed as the blob packs it, with its rows and columns.
    fn packed(&self, name: &str) -> (Vec<f32>, usize, usize) {
        let (numbers, shape) = self.tensor(name);
        let (rows, columns) = (shape[0], shape[1]);
        let mut packed = vec![0.0; packed_len(rows, columns).expect("small")];
        for (k, w) in numbers.iter().enumerate() {
            packed[packed_index(k / columns, k % columns, columns)] = *w;
        }
        (packed, rows, columns)
    }

    /// y = W x + b for the layer `name`.
    fn layer(&self, name: &str, x: &[f32]) -> Vec<f32> {
        let (packed, rows, columns) = self.packed(&format!("{name}.w"));
        let mut y = self.tensor(&format!("{name}.b")).0;
        Matrix::new(&packed, rows, columns).expect("packed").accumulate(x, &mut y);
        y
    }

    /// The GRU and its linear head over one window of 16 x 42.
    fn gru(&self, window: &[f32]) -> Vec<f32> {
        let names = ["gru.0", "gru.1", "gru.2"];
        let mut memory = [[0.0; HIDDEN]; 3];
        let layers = names.map(|n| (self.packed(&format!("{n}.wih")), self.packed(&format!("{n}.whh"))));
        let biases = names.map(|n| (self.tensor(&format!("{n}.bih")).0, self.tensor(&format!("{n}.bhh")).0));
        for row in window.chunks(42) {
            let mut below = row;
            for (((wi, wh), (bi, bh)), h) in layers.iter().zip(&biases).zip(&mut memory) {
                let gru = Gru {
                    input: Matrix::new(&wi.0, wi.1, wi.2).expect("packed").into(),
                    hidden: Matrix::new(&wh.0, wh.1, wh.2).expect("packed").into(),
                    input_bias: bi,
                    hidden_bias: bh,
                };
                gru.step(below, h);
                below = h;
            }
        }
        self.layer("fc", &memory[2])
    }

    /// The SPNN: L, C, DE, DS of a latent, in the order of the golden data.
    fn spnn(&self, x: &[f32]) -> Vec<f32> {
        let mut y = x.to_vec();
        for k in 0..14 {
            y = self.layer(&format!("sp.{k}"), &y);
            if k < 13 {
                relu(&mut y);
            }
        }
        y
    }
}

fn relu(x: &mut [f32]) {
    x.iter_mut().for_each(|x| *x = x.max(0.0));
}

/// PyTorch's outputs.
fn reference(name: &str) -> Vec<f64> {
    let mut archive =
        NpzArchive::open(golden("bench_ref.npz").expect("checked before")).expect("an npz file");
    let file: NpyFile<_> = archive.by_name(name).expect(name).expect(name);
    match file.dtype().num_bytes() {
        Some(8) => file.into_vec::<f64>().expect(name),
        _ => file.into_vec::<f32>().expect(name).into_iter().map(f64::from).collect(),
    }
}

/// Relative L2 difference.
fn difference(ours: &[f32], theirs: &[f64]) -> f64 {
    assert_eq!(ours.len(), theirs.len());
    let square = |sum: f64, x: f64| sum + x * x;
    let error = ours.iter().zip(theirs).map(|(a, b)| f64::from(*a) - b).fold(0.0, square);
    (error / theirs.iter().copied().fold(0.0, square)).sqrt()
}

/// M DE, L DS and x1 of the paper's soft step.
fn soft_step(x: &[f32], out: &[f32]) -> [Vec<f32>; 3] {
    const N: usize = 13;
    let mut numbers = out.iter().map(|&w| f64::from(w));
    let mut triangle = |below: usize| {
        let mut square = SMatrix::<f64, N, N>::zeros();
        for (i, mut row) in square.row_iter_mut().enumerate() {
            row.iter_mut().take(i + 1 - below.min(i + 1)).zip(&mut numbers).for_each(|(w, n)| *w = n);
        }
        square
    };
    let strict = triangle(1);
    let l = strict - strict.transpose();
    let mut c = triangle(0);
    c.set_diagonal(&c.diagonal().abs());
    let m = c * c.transpose();
    let de = SVector::<f64, N>::from_iterator(numbers.by_ref().take(N));
    let ds = SVector::<f64, N>::from_iterator(numbers);
    let x = SVector::<f64, N>::from_iterator(x.iter().map(|&w| f64::from(w)));
    let single = |v: SVector<f64, N>| v.iter().map(|&w| w as f32).collect::<Vec<f32>>();
    [single(m * de), single(l * ds), single(x + (l * de + m * ds) * 0.005)]
}

#[test]
fn gru_agrees() {
    let Some(weights) = Weights::open() else { return };
    let windows = weights.tensor("x.gru").0;
    let ours: Vec<f32> = windows.chunks(16 * 42).flat_map(|window| weights.gru(window)).collect();
    let error = difference(&ours, &reference("gru.y"));
    assert!(error < TOLERANCE, "GRU differs from PyTorch by {error:e}");
}

#[test]
fn spnn_trunk_and_soft_step_agree() {
    let Some(weights) = Weights::open() else { return };
    let mut ours = [vec![], vec![], vec![]];
    for x in weights.tensor("x.sp").0.chunks(13) {
        for (all, part) in ours.iter_mut().zip(soft_step(x, &weights.spnn(x))) {
            all.extend(part);
        }
    }
    for (ours, name) in ours.iter().zip(["sp.MDE", "sp.LDS", "sp.x1"]) {
        let error = difference(ours, &reference(name));
        assert!(error < TOLERANCE, "{name} differs from PyTorch by {error:e}");
    }
}

#[test]
fn velocity_decoder_agrees() {
    let Some(weights) = Weights::open() else { return };
    let mut ours = Vec::new();
    for z in reference("ae.z").chunks(20) {
        let mut y: Vec<f32> = z.iter().map(|&z| z as f32).collect();
        for k in 0..5 {
            y = weights.layer(&format!("ae.d{k}"), &y);
            if (1..4).contains(&k) {
                relu(&mut y);
            }
        }
        ours.extend_from_slice(&y[..16]);
    }
    let error = difference(&ours, &reference("ae.xhat_first16"));
    assert!(error < TOLERANCE, "the decoder differs from PyTorch by {error:e}");
}

/// Window -> GRU -> SPNN step -> position decoder, through the loss of the paper's correction.
#[test]
fn whole_chain_agrees() {
    let Some(weights) = Weights::open() else { return };
    let (windows, targets, index) =
        (weights.tensor("x.gru").0, weights.tensor("y.cor").0, weights.tensor("idx").0);
    let (mut surface, mut mde, mut lds) = (0.0, 0.0, 0.0);
    let mean_square = |v: &[f32]| v.iter().map(|&w| f64::from(w).powi(2)).sum::<f64>() / v.len() as f64;
    for (window, target) in windows.chunks(16 * 42).zip(targets.chunks(42)) {
        let x = weights.gru(window);
        let [m, l, x1] = soft_step(&x, &weights.spnn(&x));
        let mut latent = [0.0; 20];
        latent[..3].copy_from_slice(&x1[..3]);
        let mut hidden = weights.layer("qd.1", &weights.layer("qd.0", &latent));
        relu(&mut hidden);
        let q = weights.layer("qd.2", &hidden);
        let errors: Vec<f32> = index.iter().zip(target).map(|(&i, t)| q[i as usize] - t).collect();
        surface += mean_square(&errors) / BATCH as f64;
        mde += mean_square(&m) / BATCH as f64;
        lds += mean_square(&l) / BATCH as f64;
    }
    let ours = 2e3 * surface + mde + lds;
    let theirs = reference("cor.loss")[0];
    assert!((ours / theirs - 1.0).abs() < TOLERANCE, "loss {ours}, PyTorch {theirs}");
}
