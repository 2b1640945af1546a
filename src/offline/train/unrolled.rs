//! The exact GENERIC step in burn tensors, many states at once, the implicit iteration unrolled.

use super::generic::{Dynamics, LATENTS, Latent, Square};
use super::weights::Matrix;
use crate::offline::prelude::*;
use crate::units::FRAME_INTERVAL_S;
use burn::tensor::{Device, Tensor};
use nalgebra::DMatrix;

/// Corrections after the first explicit one; with the preconditioner the rest is below 1e-4.
const CORRECTIONS: usize = 2;

/// Rates are counted in this, 1/s, so that every weight is of order one and one learning rate fits all.
const RATE: f64 = 30.0;

/// The nonlinear part of H is counted in this: it has 4096 weights that pull together, and the implicit
/// step converges only while they pull gently.
const BEND: f64 = 0.005;

/// The operators as tensors; states are rows, so every matrix acts from the right.
pub(super) struct Operators {
    flow_t: Tensor<2>,
    linear_t: Tensor<2>,
    stiff: Tensor<2>,
    inner: Tensor<2>,
    bias: Tensor<2>,
    bent_bias: Tensor<2>,
    outer: Tensor<2>,
    port: Tensor<2>,
    preconditioner_t: Tensor<2>,
}

/// Square matrices, K, W1, b1, W2, B as the optimiser sees them.
pub(super) fn weights_of(dynamics: &Dynamics) -> Vec<Matrix> {
    let square = |m: &Square| Matrix::from_f64(&DMatrix::from_iterator(LATENTS, LATENTS, m.iter().copied()));
    let row = |values: &mut dyn Iterator<Item = f64>| {
        let values: Vec<f32> = values.map(|v| v as f32).collect();
        Matrix::new(1, values.len(), values)
    };
    vec![
        square(&(dynamics.skew.lower_triangle() / RATE)),
        square(&(dynamics.friction / RATE.sqrt())),
        square(&dynamics.linear),
        Matrix::from_f64(&dynamics.inner),
        row(&mut dynamics.bias.iter().copied()),
        Matrix::from_f64(&(&dynamics.outer / BEND)),
        row(&mut dynamics.port.iter().map(|b| b / RATE)),
    ]
}

/// The way back from [`weights_of`].
pub(super) fn dynamics_of(weights: &[Matrix]) -> Dynamics {
    let square = |m: &Matrix| Square::from_row_iterator(m.values.iter().map(|&v| f64::from(v)));
    let [skew, friction, linear, inner, bias, outer, port] = weights else {
        unreachable!("the dynamics have seven matrices")
    };
    let mut lower = square(skew).lower_triangle() * RATE;
    lower.fill_diagonal(0.0);
    Dynamics {
        skew: lower - lower.transpose(),
        friction: square(friction).lower_triangle() * RATE.sqrt(),
        linear: square(linear),
        inner: inner.to_f64(),
        bias: bias.to_f64().row(0).transpose(),
        outer: outer.to_f64() * BEND,
        port: Latent::from_iterator(port.values.iter().map(|&v| RATE * f64::from(v))),
    }
}

impl Operators {
    /// From the tensors of [`weights_of`]; the preconditioner is a constant, as in the blob.
    pub(super) fn new(tensors: &[Tensor<2>], preconditioner: &Square, device: &Device) -> Self {
        let mask = |keep: fn(usize, usize) -> bool| {
            let values =
                (0..LATENTS * LATENTS).map(|k| if keep(k / LATENTS, k % LATENTS) { 1.0 } else { 0.0 });
            Matrix::new(LATENTS, LATENTS, values.collect()).tensor(device)
        };
        let lower = tensors[0].clone() * mask(|i, j| i > j);
        let c = tensors[1].clone() * mask(|i, j| i >= j);
        let flow = lower.clone() - lower.transpose() - c.clone().matmul(c.transpose());
        let (linear, bias) = (tensors[2].clone(), tensors[4].clone());
        let bent = |a: Tensor<2>| a.clone() * (a.square() + 1.0).sqrt().recip();
        let p: Vec<f32> = preconditioner.iter().map(|&v| v as f32).collect();
        Self {
            flow_t: flow.transpose() * (RATE * FRAME_INTERVAL_S) as f32,
            linear_t: linear.clone().transpose(),
            stiff: linear.clone().transpose().matmul(linear),
            inner: tensors[3].clone(),
            bent_bias: bent(bias.clone()),
            bias,
            outer: tensors[5].clone() * BEND as f32,
            port: tensors[6].clone() * (0.5 * RATE * FRAME_INTERVAL_S) as f32,
            // Column-major numbers read row by row are the transpose.
            preconditioner_t: Matrix::new(LATENTS, LATENTS, p).tensor(device),
        }
    }

    /// f(x) and r'(W1 x + b1).
    fn feature(&self, x: Tensor<2>) -> (Tensor<2>, Tensor<2>) {
        let inside = x.matmul(self.inner.clone().transpose()) + self.bias.clone();
        let inverse = (inside.clone().square() + 1.0).sqrt().recip();
        let bent = inside * inverse.clone() - self.bent_bias.clone();
        (bent.matmul(self.outer.clone().transpose()), inverse.clone().square() * inverse)
    }

    /// Gradient of |f|^2 / 2 from what [`Self::feature`] gave.
    fn soft_gradient(&self, (f, slope): (Tensor<2>, Tensor<2>)) -> Tensor<2> {
        (f.matmul(self.outer.clone()) * slope).matmul(self.inner.clone())
    }

    /// H of every row.
    pub(super) fn energy(&self, x: Tensor<2>) -> Tensor<2> {
        let (f, _) = self.feature(x.clone());
        self.energy_with(x, f)
    }

    /// H of every row whose f is known.
    fn energy_with(&self, x: Tensor<2>, f: Tensor<2>) -> Tensor<2> {
        (x.matmul(self.linear_t.clone()).square().sum_dim(1) + f.square().sum_dim(1)) * 0.5
    }

    /// One turn of every row under the ports `u` `[batch, 1]`, and the heat of each; [`Dynamics::turn`]
    /// in tensors. The quadratic part of H has the midpoint gradient as its discrete gradient, so only |f|^2 / 2
    /// needs Gonzalez's correction.
    pub(super) fn turn(&self, x: Tensor<2>, u: Tensor<2>) -> (Tensor<2>, Tensor<2>) {
        let kick = u.matmul(self.port.clone());
        let a = x + kick.clone();
        let at_a = self.feature(a.clone());
        let energy_a = at_a.0.clone().square().sum_dim(1) * 0.5;
        let before = self.energy_with(a.clone(), at_a.0.clone());
        let slope = a.clone().matmul(self.stiff.clone()) + self.soft_gradient(at_a);
        let mut b = a.clone() + slope.matmul(self.flow_t.clone()).matmul(self.preconditioner_t.clone());
        for _ in 0..CORRECTIONS {
            let (middle, d) = ((a.clone() + b.clone()) * 0.5, b.clone() - a.clone());
            let g = self.soft_gradient(self.feature(middle.clone()));
            let rise = self.feature(b.clone()).0.square().sum_dim(1) * 0.5 - energy_a.clone();
            let excess = rise - (g.clone() * d.clone()).sum_dim(1);
            // Third order in d: its value counts for the books, its slope is rounding noise over |d|^2.
            let correction = (excess / (d.clone().square().sum_dim(1) + 1e-6)).detach();
            let gradient = middle.matmul(self.stiff.clone()) + g + d.clone() * correction;
            let miss = d - gradient.matmul(self.flow_t.clone());
            b = b - miss.matmul(self.preconditioner_t.clone());
        }
        let heat = before - self.energy(b.clone());
        (b + kick, heat)
    }
}

/// The dynamics as single precision keeps them, and so the blob.
#[must_use]
pub(super) fn rounded(dynamics: &Dynamics) -> Dynamics {
    dynamics_of(&weights_of(dynamics))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::offline::train::generic::tests::random;
    use crate::offline::train::noise::normal;
    use crate::offline::train::weights::{constants, numbers};

    /// The unrolled step in single precision is the exact step, and keeps the books of energy.
    #[test]
    fn unrolled_turn_agrees_with_the_exact_one() {
        let (dynamics, mut rng) = random(11);
        let device = Device::flex();
        let p = dynamics.preconditioner();
        let operators = Operators::new(&constants(&weights_of(&dynamics), &device), &p, &device);
        for _ in 0..10 {
            let x = Latent::from_fn(|_, _| 0.7 * normal(&mut rng));
            let u = normal(&mut rng);
            let row = |v: Vec<f32>| Matrix::new(1, v.len(), v).tensor(&device);
            let x32 = row(x.iter().map(|&v| v as f32).collect());
            let (said, heat) = operators.turn(x32.clone(), row(vec![u as f32]));
            let (said, heat) = (numbers(said), f64::from(numbers(heat)[0]));
            let turn = dynamics.turn(&x, u, &p);
            let said = Latent::from_iterator(said.into_iter().map(f64::from));
            assert!((said - turn.x).norm() < 2e-3 * turn.x.norm(), "{} off", (said - turn.x).norm());
            let energy = f64::from(numbers(operators.energy(x32))[0]);
            assert!((energy - dynamics.energy(&x)).abs() < 1e-5 * energy);
            assert!((heat - turn.heat).abs() < 5e-3 * dynamics.energy(&x), "{heat} against {}", turn.heat);
            let gain = dynamics.energy(&said) - dynamics.energy(&x);
            assert!((gain - (turn.work - turn.heat)).abs() < 5e-3 * dynamics.energy(&x));
        }
    }
}
