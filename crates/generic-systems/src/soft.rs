//! The soft net as burn tensors, many states at once: only its loss enforces the laws.
//!
//! ```text
//! (e, s, L and C where they are not known) = net(x),   x1 = x + L e + M s,   owed = |M e|^2 + |L s|^2
//! ```
//! (Hernandez et al., J. Comput. Phys. 426 (2021) 109950, with e and s said outright as in the liquid's soft net.)

use super::form::Form;
use burn::tensor::{Device, Tensor};
use meniscus_optim::nets::perceptron;
use meniscus_optim::weights::{Matrix, constants, numbers};
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;

/// Width of the three hidden layers.
const WIDTH: usize = 96;

/// m v for a matrix a row of a batch.
fn apply(m: &Tensor<3>, v: Tensor<2>) -> Tensor<2> {
    let [rows, n] = v.dims();
    m.clone().matmul(v.reshape([rows, n, 1])).reshape([rows, n])
}

fn constant(m: &DMatrix<f64>, device: &Device) -> Tensor<2> {
    Matrix::from_f64(m).tensor(device)
}

/// A matrix a row from the triangle `flat` [rows, entries].
fn spread(flat: Tensor<2>, over: &Matrix, n: usize, device: &Device) -> Tensor<3> {
    let rows = flat.dims()[0];
    flat.matmul(over.tensor(device)).reshape([rows, n, n])
}

/// Layers of `sizes`, each weight and bias drawn as PyTorch draws them.
fn layers(sizes: &[usize], rng: &mut ChaCha8Rng) -> Vec<Matrix> {
    let pair = |pair: &[usize]| {
        let bound = 1.0 / (pair[0] as f64).sqrt();
        [Matrix::uniform(pair[1], pair[0], bound, rng), Matrix::uniform(1, pair[1], bound, rng)]
    };
    sizes.windows(2).flat_map(pair).collect()
}

/// The soft net.
pub(super) struct Soft {
    form: Form,
    spreads: [Matrix; 2],
}

impl Soft {
    pub(super) fn new(form: &Form) -> Self {
        Self { form: form.clone(), spreads: [form.spread_skew(), form.spread_factor()] }
    }

    /// `count` states from `x` on, that one first.
    pub(super) fn roll_out(&self, weights: &[Matrix], x: &DVector<f64>, count: usize) -> Vec<DVector<f64>> {
        let device = Device::flex();
        let tensors = constants(weights, &device);
        let row =
            |x: &DVector<f64>| Matrix::new(1, x.len(), x.iter().map(|&v| v as f32).collect()).tensor(&device);
        let next = |x: &DVector<f64>| {
            let end = numbers(self.turn(&tensors, row(x)).0);
            DVector::from_iterator(x.len(), end.into_iter().map(f64::from))
        };
        std::iter::successors(Some(x.clone()), |x| Some(next(x))).take(count).collect()
    }

    /// e, s, L and M of every row.
    pub(super) fn say(&self, w: &[Tensor<2>], x: Tensor<2>) -> ([Tensor<2>; 2], [Tensor<3>; 2]) {
        let (n, rows, device) = (self.form.n, x.dims()[0], x.device());
        let said = perceptron(x, w, |layer| layer < 3);
        let (lower, triangle) = self.form.triangles();
        let part = |from: usize, count: usize| said.clone().narrow(1, from, count);
        let same = |m: &DMatrix<f64>| constant(m, &device).reshape([1, n, n]).repeat_dim(0, rows);
        let skew = if self.form.knows_skew {
            same(&self.form.skew)
        } else {
            spread(part(2 * n, lower), &self.spreads[0], n, &device)
        };
        let friction = match &self.form.friction {
            Some(m) => same(m),
            None => {
                let c = spread(part(2 * n + lower, triangle), &self.spreads[1], n, &device);
                c.clone().matmul(c.swap_dims(1, 2))
            }
        };
        ([part(0, n), part(n, n)], [skew, friction])
    }
}

impl Soft {
    /// Weights to start from.
    pub(super) fn fresh(&self, rng: &mut ChaCha8Rng) -> Vec<Matrix> {
        let (n, wide) = (self.form.n, WIDTH);
        let (lower, triangle) = self.form.triangles();
        layers(&[n, wide, wide, wide, 2 * n + lower + triangle], rng)
    }

    /// Error of the step from `x` against `y`, and the violation of the laws, a number a row.
    pub(super) fn miss(&self, w: &[Tensor<2>], x: Tensor<2>, y: Tensor<2>) -> (Tensor<2>, Tensor<2>) {
        let (end, owed) = self.turn(w, x);
        (y - end, owed)
    }

    /// The end of the step from `x`, and what it owes to the laws.
    pub(super) fn turn(&self, w: &[Tensor<2>], x: Tensor<2>) -> (Tensor<2>, Tensor<2>) {
        let ([e, s], [l, m]) = self.say(w, x.clone());
        let owed = apply(&m, e.clone()).square().sum_dim(1) + apply(&l, s.clone()).square().sum_dim(1);
        (x + apply(&l, e) + apply(&m, s), owed)
    }
}
