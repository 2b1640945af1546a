//! The paper-size networks on the camera side's layers, against PyTorch's numbers.
//!
//! `fixtures/torch/make.py` made the numbers; weights and inputs are drawn from the same seeds here and there.

use meniscus::latent::nn::{Gru, HIDDEN, Matrix, packed_index, packed_len};
use nalgebra::{SMatrix, SVector};
use seeded::{BATCH, Seeded};

#[path = "torch/seeded.rs"]
mod seeded;

/// Relative difference that single precision in another order of summation explains.
const TOLERANCE: f64 = 1e-5;

/// Distance in the decoded positions of the entries that the correction's loss compares.
const SURFACE_STRIDE: usize = 152;

/// Layers over the seeded weights.
struct Networks(Seeded);

impl Networks {
    fn open() -> Self {
        Self(Seeded::open())
    }

    fn tensor(&self, name: &str) -> (Vec<f32>, Vec<usize>) {
        self.0.tensor(name)
    }

    /// Fails if `ours` is not PyTorch's array of that name.
    fn assert_equal(&self, ours: &[f32], name: &str) {
        let theirs = self.0.reference(name);
        let error = seeded::difference(ours.iter().map(|&x| f64::from(x)), &theirs);
        println!("{name}: relative difference {error:.1e}");
        assert!(error < TOLERANCE, "{name} differs from PyTorch by {error:e}");
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
    let networks = Networks::open();
    let windows = networks.tensor("x.gru").0;
    let ours: Vec<f32> = windows.chunks(16 * 42).flat_map(|window| networks.gru(window)).collect();
    networks.assert_equal(&ours, "gru.y");
}

#[test]
fn spnn_trunk_and_soft_step_agree() {
    let networks = Networks::open();
    let mut ours = [vec![], vec![], vec![]];
    for x in networks.tensor("x.sp").0.chunks(13) {
        for (all, part) in ours.iter_mut().zip(soft_step(x, &networks.spnn(x))) {
            all.extend(part);
        }
    }
    for (ours, name) in ours.iter().zip(["sp.MDE", "sp.LDS", "sp.x1"]) {
        networks.assert_equal(ours, name);
    }
}

#[test]
fn velocity_decoder_agrees() {
    let networks = Networks::open();
    let mut ours = Vec::new();
    for z in networks.0.reference("ae.z").chunks(20) {
        let mut y: Vec<f32> = z.iter().map(|&z| z as f32).collect();
        for k in 0..5 {
            y = networks.layer(&format!("ae.d{k}"), &y);
            if (1..4).contains(&k) {
                relu(&mut y);
            }
        }
        ours.extend_from_slice(&y[..16]);
    }
    networks.assert_equal(&ours, "ae.xhat_first16");
}

/// Window -> GRU -> SPNN step -> position decoder, through the loss of the paper's correction.
#[test]
fn whole_chain_agrees() {
    let networks = Networks::open();
    let (windows, targets) = (networks.tensor("x.gru").0, networks.tensor("y.cor").0);
    let (mut surface, mut mde, mut lds) = (0.0, 0.0, 0.0);
    let mut decoded = vec![];
    let mean_square = |v: &[f32]| v.iter().map(|&w| f64::from(w).powi(2)).sum::<f64>() / v.len() as f64;
    for (window, target) in windows.chunks(16 * 42).zip(targets.chunks(42)) {
        let x = networks.gru(window);
        let [m, l, x1] = soft_step(&x, &networks.spnn(&x));
        let mut latent = [0.0; 20];
        latent[..3].copy_from_slice(&x1[..3]);
        let mut hidden = networks.layer("qd.1", &networks.layer("qd.0", &latent));
        relu(&mut hidden);
        let q = networks.layer("qd.2", &hidden);
        let seen: Vec<f32> = q.iter().copied().step_by(SURFACE_STRIDE).take(target.len()).collect();
        let errors: Vec<f32> = seen.iter().zip(target).map(|(q, t)| q - t).collect();
        decoded.extend(seen);
        surface += mean_square(&errors) / BATCH as f64;
        mde += mean_square(&m) / BATCH as f64;
        lds += mean_square(&l) / BATCH as f64;
    }
    let ours = 2e3 * surface + mde + lds;
    networks.assert_equal(&decoded, "cor.surface");
    let theirs = networks.0.reference("cor.loss")[0];
    assert!((ours / theirs - 1.0).abs() < TOLERANCE, "loss {ours}, PyTorch {theirs}");
}
