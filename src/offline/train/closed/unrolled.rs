//! The steps of both nets as burn tensors, many states at once: what training differentiates.
//!
//! `miss` holds a step against a true one whose both ends are known, so that nothing is solved; `turn` goes on from a
//! state of its own. An implicit turn is solved without a graph and differentiated through its last corrections, as
//! in [`crate::offline::train::unrolled`].

use super::exact::{ENERGY, NODES};
use super::form::Form;
use crate::offline::prelude::*;
use crate::offline::train::nets::{linear, perceptron};
use crate::offline::train::weights::{Matrix, constants, numbers, scalar};
use burn::tensor::activation::sigmoid;
use burn::tensor::{Device, Tensor};
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;

/// Corrections at the solution through which the gradient flows.
const CORRECTIONS: usize = 2;

/// Corrections after which the solution is taken as it is, and the largest change at which it stands.
const SOLVE: (usize, f32) = (16, 2e-6);

/// Widths of H and of the perceptron of L and C.
const WIDTH: (usize, usize) = (64, 32);

/// How much finer than PyTorch's start the first layer of H sees: energies bend within a part of the states' spread.
const SHARP: f32 = 4.0;

/// Width of the soft net's three hidden layers.
const SOFT_WIDTH: usize = 96;

/// A net that can be trained.
pub(super) trait Net: Sync {
    /// Weights to start from.
    fn fresh(&self, rng: &mut ChaCha8Rng) -> Vec<Matrix>;
    /// What the step from `x` misses of `y`, and what it owes to the laws, a number a row.
    fn miss(&self, w: &[Tensor<2>], x: Tensor<2>, y: Tensor<2>) -> (Tensor<2>, Tensor<2>);
    /// The end of the step from `x`, and what it owes to the laws.
    fn turn(&self, w: &[Tensor<2>], x: Tensor<2>) -> (Tensor<2>, Tensor<2>);
}

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

/// The exact net.
pub(super) struct Exact {
    form: Form,
    spreads: [Matrix; 2],
}

impl Exact {
    pub(super) fn new(form: &Form) -> Self {
        Self { form: form.clone(), spreads: [form.spread_skew(), form.spread_factor()] }
    }

    /// grad H of every row, as [`super::exact::Exact`] has it.
    fn gradient(w: &[Tensor<2>], x: Tensor<2>) -> Tensor<2> {
        let inner = linear(x.clone(), &w[2], &w[3]).tanh();
        let slope = sigmoid(linear(inner.clone(), &w[4], &w[5])) * w[6].clone();
        let back = slope.matmul(w[4].clone()) * (inner.square() * -1.0 + 1.0);
        let stiff = w[0].clone().transpose().matmul(w[0].clone());
        x.matmul(stiff) + w[1].clone() + back.matmul(w[2].clone())
    }

    /// (L - D) dH of every row, without the rest that only rounding sees.
    fn flow(&self, w: &[Tensor<2>], x: &Tensor<2>, y: &Tensor<2>) -> Tensor<2> {
        let (n, device) = (self.form.n, x.device());
        let way = y.clone() - x.clone();
        let [a, b] = NODES.map(|t| Self::gradient(w, x.clone() + way.clone() * t as f32));
        let g = (a + b) * 0.5;
        let m = (x.clone() + y.clone()) * 0.5;
        let first = linear(m, &w[ENERGY + 2], &w[ENERGY + 3]).tanh();
        let second = linear(first, &w[ENERGY + 4], &w[ENERGY + 5]).tanh();
        let changes = second.matmul(w[ENERGY + 6].clone().transpose());
        let (lower, triangle) = self.form.triangles();
        let factor = w[ENERGY + 1].clone() + changes.clone().narrow(1, lower, triangle);
        let c = spread(factor, &self.spreads[1], n, &device);
        let friction = apply(&c, apply(&c.clone().swap_dims(1, 2), g.clone()));
        // Rows from the right: (L g)^T = g^T L^T.
        let known = g.clone().matmul(constant(&self.form.skew.transpose(), &device));
        if self.form.knows_skew {
            return known - friction;
        }
        let skew = spread(w[ENERGY].clone() + changes.narrow(1, 0, lower), &self.spreads[0], n, &device);
        apply(&skew, g) - friction
    }
}

impl Net for Exact {
    fn fresh(&self, rng: &mut ChaCha8Rng) -> Vec<Matrix> {
        let (n, (wide, narrow)) = (self.form.n, WIDTH);
        let (lower, triangle) = self.form.triangles();
        let eye = Matrix::from_f64(&(DMatrix::identity(n, n) * 0.1));
        let mut weights = vec![eye, Matrix::zeros(1, n)];
        let mut bends = layers(&[n, wide, wide], rng);
        bends[..2].iter_mut().flat_map(|m| &mut m.values).for_each(|v| *v *= SHARP);
        weights.extend(bends);
        weights.push(Matrix::uniform(1, wide, 0.1 / (wide as f64).sqrt(), rng));
        weights.push(Matrix::uniform(1, lower, 0.01, rng));
        let diagonal = (0..n).flat_map(|i| (0..=i).map(move |j| if i == j { 0.1 } else { 0.0 }));
        weights.push(Matrix::new(1, triangle, diagonal.collect()));
        weights.extend(layers(&[n, narrow, narrow], rng));
        weights.push(Matrix::uniform(lower + triangle, narrow, 0.01 / (narrow as f64).sqrt(), rng));
        weights
    }

    fn miss(&self, w: &[Tensor<2>], x: Tensor<2>, y: Tensor<2>) -> (Tensor<2>, Tensor<2>) {
        let owed = Tensor::zeros([x.dims()[0], 1], &x.device());
        (y.clone() - x.clone() - self.flow(w, &x, &y), owed)
    }

    fn turn(&self, w: &[Tensor<2>], x: Tensor<2>) -> (Tensor<2>, Tensor<2>) {
        let bare: Vec<_> = w.iter().map(|w| w.clone().inner()).collect();
        let from = x.clone().inner();
        let mut y = from.clone();
        for _ in 0..SOLVE.0 {
            let next = from.clone() + self.flow(&bare, &from, &y);
            let change = scalar((next.clone() - y).abs().max());
            y = next;
            if change < SOLVE.1 {
                break;
            }
        }
        let mut end = Tensor::from_inner(y);
        for _ in 0..CORRECTIONS {
            end = x.clone() + self.flow(w, &x, &end);
        }
        let owed = Tensor::zeros([x.dims()[0], 1], &x.device());
        (end, owed)
    }
}

/// The soft net: net(x) = (e, s, and L and C where they are not known), x1 = x + L e + M s.
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

impl Net for Soft {
    fn fresh(&self, rng: &mut ChaCha8Rng) -> Vec<Matrix> {
        let (n, wide) = (self.form.n, SOFT_WIDTH);
        let (lower, triangle) = self.form.triangles();
        layers(&[n, wide, wide, wide, 2 * n + lower + triangle], rng)
    }

    fn miss(&self, w: &[Tensor<2>], x: Tensor<2>, y: Tensor<2>) -> (Tensor<2>, Tensor<2>) {
        let (end, owed) = self.turn(w, x);
        (y - end, owed)
    }

    fn turn(&self, w: &[Tensor<2>], x: Tensor<2>) -> (Tensor<2>, Tensor<2>) {
        let ([e, s], [l, m]) = self.say(w, x.clone());
        let owed = apply(&m, e.clone()).square().sum_dim(1) + apply(&l, s.clone()).square().sum_dim(1);
        (x + apply(&l, e) + apply(&m, s), owed)
    }
}
