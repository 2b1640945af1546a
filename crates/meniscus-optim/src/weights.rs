//! Weights as plain matrices on the host, and Adam on them.
//!
//! A network is a function of a slice of burn tensors; its weights live here between two steps. A
//! checkpoint is a clone, freezing is not listing, and export needs no conversion.

use burn::tensor::{Device, Gradients, Tensor, TensorData};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// A row-major matrix of `f32`; a bias is one row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Matrix {
    /// Rows.
    pub rows: usize,
    /// Columns.
    pub columns: usize,
    /// `rows * columns` numbers, row after row.
    pub values: Vec<f32>,
}

impl Matrix {
    /// A matrix of `rows` x `columns` from its row-major numbers.
    ///
    /// # Panics
    /// When the count of numbers is not `rows * columns`.
    #[must_use]
    pub fn new(rows: usize, columns: usize, values: Vec<f32>) -> Self {
        assert_eq!(values.len(), rows * columns, "a {rows} x {columns} matrix");
        Self { rows, columns, values }
    }

    /// All zeros.
    #[must_use]
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self::new(rows, columns, vec![0.0; rows * columns])
    }

    /// Uniform in `[-bound, bound]`; PyTorch starts its layers with the bound 1 / sqrt(inputs).
    #[must_use]
    pub fn uniform(rows: usize, columns: usize, bound: f64, rng: &mut ChaCha8Rng) -> Self {
        let draw = |_| ((2.0 * rng.random::<f64>() - 1.0) * bound) as f32;
        Self::new(rows, columns, (0..rows * columns).map(draw).collect())
    }

    /// From a nalgebra matrix in double precision.
    #[must_use]
    pub fn from_f64(m: &nalgebra::DMatrix<f64>) -> Self {
        // nalgebra is column-major, so the transpose iterates row by row.
        Self::new(m.nrows(), m.ncols(), m.transpose().iter().map(|&v| v as f32).collect())
    }

    /// To a nalgebra matrix in double precision.
    #[must_use]
    pub fn to_f64(&self) -> nalgebra::DMatrix<f64> {
        nalgebra::DMatrix::from_row_iterator(
            self.rows,
            self.columns,
            self.values.iter().map(|&v| f64::from(v)),
        )
    }

    /// As a constant tensor.
    #[must_use]
    pub fn tensor(&self, device: &Device) -> Tensor<2> {
        Tensor::from_data(TensorData::new(self.values.clone(), [self.rows, self.columns]), device)
    }
}

/// The numbers of a tensor, row-major.
#[must_use]
pub fn numbers<const D: usize>(tensor: Tensor<D>) -> Vec<f32> {
    tensor.try_into_vec_as().expect("the flex backend lives in host memory")
}

/// The one number of a loss.
#[must_use]
pub fn scalar(tensor: Tensor<1>) -> f32 {
    numbers(tensor).first().copied().unwrap_or(f32::NAN)
}

/// Tensors of `weights` that ask for gradients; `device` must be an autodiff device.
#[must_use]
pub fn leaves(weights: &[Matrix], device: &Device) -> Vec<Tensor<2>> {
    weights.iter().map(|w| w.tensor(device).require_grad()).collect()
}

/// Tensors of `weights` that do not.
#[must_use]
pub fn constants(weights: &[Matrix], device: &Device) -> Vec<Tensor<2>> {
    weights.iter().map(|w| w.tensor(device)).collect()
}

/// Adam (Kingma and Ba 2015) with the global gradient norm clipped.
#[derive(Debug, Serialize, Deserialize)]
pub struct Adam {
    first: Vec<Vec<f32>>,
    second: Vec<Vec<f32>>,
    turn: i32,
    /// Largest global gradient norm that is let through.
    pub clip: f32,
}

impl Adam {
    /// Zero moments for `weights`.
    #[must_use]
    pub fn new(weights: &[Matrix], clip: f32) -> Self {
        let zeros: Vec<Vec<f32>> = weights.iter().map(|w| vec![0.0; w.values.len()]).collect();
        Self { first: zeros.clone(), second: zeros, turn: 0, clip }
    }

    /// One step on `weights` from the gradients of `leaves`; returns the gradient norm. A step whose
    /// gradient is not finite is skipped.
    ///
    /// m <- b1 m + (1 - b1) g, v <- b2 v + (1 - b2) g^2,
    /// w <- w - lr (m / (1 - b1^t)) / (sqrt(v / (1 - b2^t)) + eps).
    pub fn step(
        &mut self,
        weights: &mut [Matrix],
        leaves: &[Tensor<2>],
        mut grads: Gradients,
        lr: f64,
    ) -> f32 {
        const BETA: [f32; 2] = [0.9, 0.99];
        let gradients: Vec<Option<Vec<f32>>> =
            leaves.iter().map(|leaf| leaf.grad_remove(&mut grads).map(numbers)).collect();
        let norm = gradients.iter().flatten().flatten().map(|g| g * g).sum::<f32>().sqrt();
        if !norm.is_finite() {
            return norm;
        }
        let scale = if norm > self.clip { self.clip / norm } else { 1.0 };
        self.turn += 1;
        let correct = BETA.map(|b| 1.0 - b.powi(self.turn));
        let moments = self.first.iter_mut().zip(&mut self.second);
        for ((weight, gradient), (first, second)) in weights.iter_mut().zip(gradients).zip(moments) {
            let Some(gradient) = gradient else { continue };
            for (((w, g), m), v) in weight.values.iter_mut().zip(gradient).zip(first).zip(second) {
                let g = g * scale;
                *m = BETA[0] * *m + (1.0 - BETA[0]) * g;
                *v = BETA[1] * *v + (1.0 - BETA[1]) * g * g;
                *w -= lr as f32 * (*m / correct[0]) / ((*v / correct[1]).sqrt() + 1e-8);
            }
        }
        norm
    }
}
