//! Training of the exact GENERIC step through unrolled roll-outs, the implicit iteration included.
//!
//! One-step training is erratic for every variant; ten and more steps are not. What is unrolled is the
//! step that runs, so its weights need no allowance for another integrator.

use super::generic::{Dynamics, HIDDEN, LATENTS, Latent, Square};
use super::progress::{Session, annealed};
use super::warm::Path;
use super::weights::{Adam, Matrix, leaves, scalar};
use crate::offline::prelude::*;
use crate::units::FRAME_INTERVAL_S;
use burn::tensor::{Device, Tensor, TensorData};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Roll-outs of one training step: at these sizes the cost is calls, not numbers.
const BATCH: usize = 128;

/// Corrections after the first explicit one; with the preconditioner the rest is below 1e-4.
const CORRECTIONS: usize = 2;

/// Weight of the energy against the states in the loss, both relative to their mean square: what makes
/// H the energy of the slosh and not just any function that falls.
const ENERGY_WEIGHT: f32 = 0.05;

/// Weight of the heat of a whole roll-out in the loss, likewise.
const HEAT_WEIGHT: f32 = 0.02;

/// Turns of a validation roll-out: two seconds.
pub(super) const HORIZON: usize = 120;

/// Steps between two looks at the validation recordings.
const LOOK: usize = 25;

/// The operators as tensors; states are rows, so every matrix acts from the right.
struct Operators {
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
fn weights_of(dynamics: &Dynamics) -> Vec<Matrix> {
    let square = |m: &Square| Matrix::from_f64(&DMatrix::from_iterator(LATENTS, LATENTS, m.iter().copied()));
    let row = |values: &mut dyn Iterator<Item = f64>| {
        let values: Vec<f32> = values.map(|v| v as f32).collect();
        Matrix::new(1, values.len(), values)
    };
    vec![
        square(&dynamics.skew.lower_triangle()),
        square(&dynamics.friction),
        square(&dynamics.linear),
        Matrix::from_f64(&dynamics.inner),
        row(&mut dynamics.bias.iter().copied()),
        Matrix::from_f64(&dynamics.outer),
        row(&mut dynamics.port.iter().copied()),
    ]
}

fn dynamics_of(weights: &[Matrix]) -> Dynamics {
    let square = |m: &Matrix| Square::from_row_iterator(m.values.iter().map(|&v| f64::from(v)));
    let [skew, friction, linear, inner, bias, outer, port] = weights else {
        unreachable!("the dynamics have seven matrices")
    };
    let mut lower = square(skew).lower_triangle();
    lower.fill_diagonal(0.0);
    Dynamics {
        skew: lower - lower.transpose(),
        friction: square(friction).lower_triangle(),
        linear: square(linear),
        inner: inner.to_f64(),
        bias: bias.to_f64().row(0).transpose(),
        outer: outer.to_f64(),
        port: Latent::from_iterator(port.values.iter().map(|&v| f64::from(v))),
    }
}

impl Operators {
    /// From the tensors of [`weights_of`]; the preconditioner is a constant, as in the blob.
    fn new(tensors: &[Tensor<2>], preconditioner: &Square, device: &Device) -> Self {
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
            flow_t: flow.transpose() * FRAME_INTERVAL_S as f32,
            linear_t: linear.clone().transpose(),
            stiff: linear.clone().transpose().matmul(linear),
            inner: tensors[3].clone(),
            bent_bias: bent(bias.clone()),
            bias,
            outer: tensors[5].clone(),
            port: tensors[6].clone() * (0.5 * FRAME_INTERVAL_S) as f32,
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
    fn energy(&self, x: Tensor<2>) -> Tensor<2> {
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
    fn turn(&self, x: Tensor<2>, u: Tensor<2>) -> (Tensor<2>, Tensor<2>) {
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
            let correction = excess / (d.clone().square().sum_dim(1) + 1e-8);
            let gradient = middle.matmul(self.stiff.clone()) + g + d.clone() * correction;
            let miss = d - gradient.matmul(self.flow_t.clone());
            b = b - miss.matmul(self.preconditioner_t.clone());
        }
        let heat = before - self.energy(b.clone());
        (b + kick, heat)
    }
}

/// Sum of sqrt(1 + m^2) - 1: a square for small misses, a modulus for large ones, so that books which
/// are far off at first do not drown the states.
fn soft(miss: Tensor<2>) -> Tensor<1> {
    ((miss.square() + 1.0).sqrt() - 1.0).sum()
}

/// Relative error of roll-outs of up to [`HORIZON`] turns from true states, in `metric`.
#[must_use]
pub(super) fn validate(
    roll_out: impl Fn(Latent, &[f64]) -> Vec<Latent>,
    paths: &[Path],
    metric: &Square,
) -> f64 {
    let (mut miss, mut size) = (0.0, 0.0);
    for path in paths {
        for from in (0..path.x.len().saturating_sub(HORIZON / 2)).step_by(HORIZON / 2) {
            let to = (from + 1 + HORIZON).min(path.x.len());
            let truth = &path.x[from + 1..to];
            for (said, x) in roll_out(path.x[from], &path.u[from + 1..to]).iter().zip(truth) {
                miss += (metric * (said - x)).norm_squared();
                size += (metric * x).norm_squared();
            }
        }
    }
    (miss / size.max(f64::MIN_POSITIVE)).sqrt()
}

/// Trains `start` on `training` for `steps` steps and keeps what rolls out best on `validation`.
#[must_use]
pub(super) fn train(
    start: &Dynamics,
    (training, validation): (&[Path], &[Path]),
    metric: &Square,
    (steps, seed): (usize, u64),
    session: &Session<'_>,
) -> (Dynamics, f64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let device = Device::flex().autodiff();
    let metric_t =
        Matrix::from_f64(&DMatrix::from_fn(LATENTS, LATENTS, |i, j| metric[(j, i)])).tensor(&device);
    let mut weights = weights_of(start);
    let mut adam = Adam::new(&weights, 1.0);
    let check = |d: &Dynamics| validate(|x, u| d.roll_out(x, u), validation, metric);
    let (mut best, mut least) = (start.clone(), check(start));
    let mean_square = |f: &dyn Fn(&Path, usize) -> f64| {
        let all = training.iter().flat_map(|p| (0..p.x.len()).map(move |n| (p, n)));
        all.clone().map(|(p, n)| f(p, n)).sum::<f64>() / all.count().max(1) as f64
    };
    let state_size = mean_square(&|p, n| (metric * p.x[n]).norm_squared()) as f32;
    let energy_size = mean_square(&|p, n| p.energy[n].powi(2)) as f32;
    let heat_size = |horizon: usize| {
        let gain = |p: &Path, n: usize| p.heat[(n + horizon).min(p.heat.len() - 1)] - p.heat[n];
        mean_square(&|p, n| gain(p, n).powi(2)) as f32
    };
    let bar = session.bar(&format!("dynamics {:04x}", seed & 0xffff), steps);
    for step in 0..steps {
        let horizon = [8, 16, 30][3 * step / steps];
        let starts = draw(training, horizon, &mut rng);
        let column = |f: &dyn Fn(&Path, usize) -> Vec<f32>, k: usize| {
            let rows: Vec<f32> = starts.iter().flat_map(|&(p, n)| f(&training[p], n + k)).collect();
            let width = rows.len() / BATCH;
            Tensor::<2>::from_data(TensorData::new(rows, [BATCH, width]), &device)
        };
        let state = |k| column(&|p, n| p.x[n].iter().map(|&v| v as f32).collect(), k);
        let tensors = leaves(&weights, &device);
        let operators = Operators::new(&tensors, &dynamics_of(&weights).preconditioner(), &device);
        let energy = column(&|p, n| vec![p.energy[n] as f32], 0);
        let mut loss = soft((operators.energy(state(0)) - energy) * energy_size.sqrt().recip()) * ENERGY_WEIGHT;
        let (mut x, mut due) = (state(0), column(&|p, n| vec![(p.heat[n + horizon] - p.heat[n]) as f32], 0));
        for k in 1..=horizon {
            let (next, heat) = operators.turn(x, column(&|p, n| vec![p.u[n] as f32], k));
            (x, due) = (next, due - heat);
            let miss = (x.clone() - state(k)).matmul(metric_t.clone()).square().sum();
            loss = loss + miss * (1.0 / (horizon as f32 * state_size));
        }
        let loss = (loss + soft(due * heat_size(horizon).sqrt().recip()) * HEAT_WEIGHT) / BATCH as f32;
        adam.step(&mut weights, &tensors, loss.backward(), annealed(2e-3, step, steps));
        if step % LOOK == LOOK - 1 || step + 1 == steps {
            let now = dynamics_of(&weights);
            let error = check(&now);
            if error < least {
                (best, least) = (now, error);
            }
            bar.show(step + 1, f64::from(scalar(loss)).sqrt(), error);
            if session.stopped() {
                break;
            }
        }
    }
    bar.finish();
    (best, least)
}

/// Where [`BATCH`] roll-outs start, as (path, frame): anywhere, but of two draws the livelier.
fn draw(training: &[Path], horizon: usize, rng: &mut ChaCha8Rng) -> Vec<(usize, usize)> {
    let total: usize = training.iter().map(|p| p.x.len().saturating_sub(horizon + 1)).sum();
    let one = |rng: &mut ChaCha8Rng| {
        let mut n = rng.random_range(0..total.max(1));
        for (i, path) in training.iter().enumerate() {
            let room = path.x.len().saturating_sub(horizon + 1);
            if n < room {
                return (i, n);
            }
            n -= room;
        }
        (0, 0)
    };
    let life = |&(p, n): &(usize, usize)| training[p].energy[n..n + horizon].iter().sum::<f64>();
    let livelier = |_| {
        let (a, b) = (one(rng), one(rng));
        if life(&a) > life(&b) { a } else { b }
    };
    (0..BATCH).map(livelier).collect()
}

/// The weights in the blob's order of shapes, for a hidden layer of [`HIDDEN`].
#[must_use]
pub(super) fn rounded(dynamics: &Dynamics) -> Dynamics {
    debug_assert_eq!(dynamics.bias.len(), HIDDEN);
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
