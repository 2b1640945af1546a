//! The exact GENERIC step in burn tensors, many states at once: solved as the run solves it, and differentiated
//! through its last corrections.
//!
//! A fixed number of corrections from a first guess is another step than the one that runs wherever they do not
//! suffice. At the solution b* of b = b - P miss(b; w), one more correction has the derivative -P dmiss/dw, and k of
//! them have sum_(j<k) (1 - P J)^j of it, which goes to the implicit derivative J^-1 dmiss/dw as k grows.
//!
//! Under a friction law P depends on phi, which every state has of its own: it is interpolated between those of
//! [`crate::operators::precondition::LEVELS`], on a logarithmic scale.

use crate::operators::friction_law;
use crate::operators::law_tensors::{LawTensors, nearness};
use crate::operators::reference_step::{Dynamics, Square};
use burn::tensor::{Device, Tensor};
use meniscus::latent::generic::{LATENTS, Latent};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_optim::weights::{Matrix, scalar};
use nalgebra::DMatrix;

/// Corrections at the solution through which the gradient flows.
const CORRECTIONS: usize = 2;

/// Corrections after which the solution is taken as it is.
const SOLVER_CORRECTIONS: usize = 12;

/// Largest change, in latents, at which the solution stands.
const SOLVED: f32 = 1e-4;

/// Rates are counted in this, 1/s, so that every weight is of order one and one learning rate fits all.
pub(crate) const RATE: f64 = 30.0;

/// The operators as tensors; states are rows, so every matrix acts from the right.
#[derive(Clone)]
pub(crate) struct Operators {
    flow_t: Tensor<2>,
    /// Friction under a law; `flow_t` is without friction then.
    law: Option<LawTensors>,
    linear_t: Tensor<2>,
    stiff: Tensor<2>,
    inner: Tensor<2>,
    bias: Tensor<2>,
    /// w^2.
    weight: Tensor<2>,
    /// p(b).
    bent_bias: Tensor<2>,
    port: Tensor<2>,
    /// P, one for each level of phi under a law.
    preconditioners_t: Vec<Tensor<2>>,
}

/// L, C, K, W, b, w, B as the optimiser sees them, and the numbers of the friction law where there is one.
pub(crate) fn weights_of(dynamics: &Dynamics) -> Vec<Matrix> {
    let square = |m: &Square| Matrix::from_f64(&DMatrix::from_iterator(LATENTS, LATENTS, m.iter().copied()));
    let row = |values: &mut dyn Iterator<Item = f64>| {
        let values: Vec<f32> = values.map(|v| v as f32).collect();
        Matrix::new(1, values.len(), values)
    };
    let mut weights = vec![
        square(&(dynamics.skew.lower_triangle() / RATE)),
        square(&(dynamics.friction / RATE.sqrt())),
        square(&dynamics.linear),
        Matrix::from_f64(&dynamics.inner),
        row(&mut dynamics.bias.iter().copied()),
        row(&mut dynamics.weight.iter().copied()),
        row(&mut dynamics.port.iter().map(|b| b / RATE)),
    ];
    weights.extend(dynamics.law.map(|law| row(&mut friction_law::free(&law).into_iter())));
    weights
}

/// The way back from [`weights_of`].
pub(crate) fn dynamics_of(weights: &[Matrix]) -> Dynamics {
    let square = |m: &Matrix| Square::from_row_iterator(m.values.iter().map(|&v| f64::from(v)));
    let [skew, friction, linear, inner, bias, weight, port, law @ ..] = weights else {
        unreachable!("the dynamics have seven matrices or eight")
    };
    let mut lower = square(skew).lower_triangle() * RATE;
    lower.fill_diagonal(0.0);
    Dynamics {
        skew: lower - lower.transpose(),
        friction: square(friction).lower_triangle() * RATE.sqrt(),
        linear: square(linear),
        inner: inner.to_f64(),
        bias: bias.to_f64().row(0).transpose(),
        weight: weight.to_f64().row(0).transpose(),
        port: Latent::from_iterator(port.values.iter().map(|&v| RATE * f64::from(v))),
        law: law.first().and_then(|law| friction_law::of_free(&law.values)),
    }
}

impl Operators {
    /// From the tensors of [`weights_of`]; the preconditioners are constants ([`Dynamics::preconditioners`]).
    pub(crate) fn new(tensors: &[Tensor<2>], preconditioners: &[Square], device: &Device) -> Self {
        let c = factor_of(&tensors[1], device);
        Self::with_friction(tensors, c.clone().matmul(c.transpose()), preconditioners, device)
    }

    /// The same with `friction` as D, in units of [`RATE`].
    pub(crate) fn with_friction(
        tensors: &[Tensor<2>],
        friction: Tensor<2>,
        preconditioners: &[Square],
        device: &Device,
    ) -> Self {
        let lower = tensors[0].clone() * mask(|i, j| i > j, device);
        let skew = lower.clone() - lower.transpose();
        let step = (RATE * FRAME_INTERVAL_S) as f32;
        let law = tensors.get(7).map(|numbers| LawTensors::new(numbers, friction.clone() * step));
        let flow = if law.is_some() { skew } else { skew - friction };
        let (linear, bias) = (tensors[2].clone(), tensors[4].clone());
        let preconditioner = |p: &Square| {
            // Column-major numbers read row by row are the transpose.
            Matrix::new(LATENTS, LATENTS, p.iter().map(|&v| v as f32).collect()).tensor(device)
        };
        Self {
            flow_t: flow.transpose() * step,
            law,
            linear_t: linear.clone().transpose(),
            stiff: linear.clone().transpose().matmul(linear),
            inner: tensors[3].clone(),
            bent_bias: bent(bias.clone()),
            bias,
            weight: tensors[5].clone().square(),
            port: tensors[6].clone() * (0.5 * RATE * FRAME_INTERVAL_S) as f32,
            preconditioners_t: preconditioners.iter().map(preconditioner).collect(),
        }
    }

    /// W x + b and p(W x + b).
    fn see(&self, x: Tensor<2>) -> [Tensor<2>; 2] {
        let inside = x.matmul(self.inner.clone().transpose()) + self.bias.clone();
        [inside.clone(), bent(inside)]
    }

    /// H of every row, [`Dynamics::energy`] in tensors.
    pub(crate) fn energy(&self, x: Tensor<2>) -> Tensor<2> {
        let [a, a_bent] = self.see(x.clone());
        let along = a.clone() - self.bias.clone();
        let below = a_bent * self.bent_bias.clone() + a * self.bias.clone() + 1.0;
        let bowed = along.square() * self.weight.clone() / (below * self.bent_bias.clone());
        x.matmul(self.linear_t.clone()).square().sum_dim(1) * 0.5 + bowed.sum_dim(1)
    }

    /// dH of every row, [`Dynamics::discrete_gradient`] in tensors.
    fn discrete_gradient(&self, x: &Tensor<2>, from: &[Tensor<2>; 2], y: &Tensor<2>) -> Tensor<2> {
        let to = self.see(y.clone());
        let [a, bent] = [0, 1].map(|k| from[k].clone() + to[k].clone());
        let slope = (a / bent - self.bias.clone() / self.bent_bias.clone()) * self.weight.clone();
        ((x.clone() + y.clone()) * 0.5).matmul(self.stiff.clone()) + slope.matmul(self.inner.clone())
    }

    /// The same numbers with no graph behind them.
    #[must_use]
    pub(crate) fn frozen(&self) -> Self {
        let bare = |tensor: &Tensor<2>| tensor.clone().inner();
        Self {
            flow_t: bare(&self.flow_t),
            law: self.law.as_ref().map(LawTensors::frozen),
            linear_t: bare(&self.linear_t),
            stiff: bare(&self.stiff),
            inner: bare(&self.inner),
            bias: bare(&self.bias),
            bent_bias: bare(&self.bent_bias),
            weight: bare(&self.weight),
            port: bare(&self.port),
            preconditioners_t: self.preconditioners_t.iter().map(bare).collect(),
        }
    }

    /// Correction that the closed step subtracts from `b`, P (b - a - dt (L - phi D) dH(a, b)).
    fn correction(&self, a: &Tensor<2>, from: &[Tensor<2>; 2], b: &Tensor<2>) -> Tensor<2> {
        let gradient = self.discrete_gradient(a, from, b);
        let miss = b.clone() - a.clone() - gradient.clone().matmul(self.flow_t.clone());
        let Some(law) = &self.law else { return miss.matmul(self.preconditioners_t[0].clone()) };
        let rubs = gradient.clone().matmul(law.friction.clone());
        let factor = law.factor(rubs.clone(), gradient);
        let miss = miss + rubs * factor.clone();
        // P has no part in the solution, and so none in its derivative.
        let nearness = nearness(factor.detach());
        let parts = self.preconditioners_t.iter().zip(nearness);
        let parts = parts.map(|(p, near)| miss.clone().matmul(p.clone()) * near);
        parts.reduce(|sum, part| sum + part).unwrap_or(miss)
    }

    /// The end of the closed step of every row of `a`, for operators without a graph.
    fn solve(&self, a: &Tensor<2>) -> Tensor<2> {
        let (mut b, from) = (a.clone(), self.see(a.clone()));
        for _ in 0..SOLVER_CORRECTIONS {
            let change = self.correction(a, &from, &b);
            b = b - change.clone();
            if scalar(change.abs().max()) < SOLVED {
                break;
            }
        }
        b
    }

    /// One turn of every row under the ports `u` `[batch, 1]`, and the heat of each; [`Dynamics::turn`] in
    /// tensors. `frozen` is [`Self::frozen`] of the same operators.
    pub(crate) fn turn(&self, x: Tensor<2>, u: Tensor<2>, frozen: &Self) -> (Tensor<2>, Tensor<2>) {
        let kick = u.matmul(self.port.clone());
        let a = x + kick.clone();
        let from = self.see(a.clone());
        let mut b = Tensor::from_inner(frozen.solve(&a.clone().inner()));
        for _ in 0..CORRECTIONS {
            b = b.clone() - self.correction(&a, &from, &b);
        }
        let heat = self.energy(a) - self.energy(b.clone());
        (b + kick, heat)
    }
}

/// Ones where `keep` says of row and column, zeros elsewhere.
fn mask(keep: fn(usize, usize) -> bool, device: &Device) -> Tensor<2> {
    let values = (0..LATENTS * LATENTS).map(|k| if keep(k / LATENTS, k % LATENTS) { 1.0 } else { 0.0 });
    Matrix::new(LATENTS, LATENTS, values.collect()).tensor(device)
}

/// C of the second tensor of [`weights_of`], whose numbers above the diagonal mean nothing.
pub(crate) fn factor_of(friction: &Tensor<2>, device: &Device) -> Tensor<2> {
    friction.clone() * mask(|i, j| i >= j, device)
}

/// p(a) = sqrt(1 + a^2).
fn bent(a: Tensor<2>) -> Tensor<2> {
    (a.square() + 1.0).sqrt()
}

/// The dynamics as single precision keeps them, and so the blob.
#[must_use]
pub(crate) fn rounded(dynamics: &Dynamics) -> Dynamics {
    dynamics_of(&weights_of(dynamics))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::networks::noise::normal;
    use crate::operators::reference_step::tests::random;
    use meniscus::latent::generic::FrictionLaw;
    use meniscus_optim::weights::{constants, numbers};

    /// The unrolled step in single precision is the exact step, and keeps the books of energy.
    #[test]
    fn unrolled_turn_agrees_with_the_exact_one() {
        agrees_with_the_exact_one(None);
    }

    /// The same where friction depends on the rate of shear.
    #[test]
    fn unrolled_turn_agrees_with_the_exact_one_under_a_law() {
        let law = FrictionLaw::new([20.0, 0.2, 0.5, 0.4]).expect("a law");
        agrees_with_the_exact_one(Some(law));
        let back = dynamics_of(&weights_of(&Dynamics { law: Some(law), ..random(11).0 })).law.expect("a law");
        for (back, due) in back.numbers().into_iter().zip(law.numbers()) {
            assert!((back / due - 1.0).abs() < 1e-6, "{back} for {due}");
        }
    }

    fn agrees_with_the_exact_one(law: Option<FrictionLaw>) {
        let (dynamics, mut rng) = random(11);
        let dynamics = Dynamics { law, ..dynamics };
        let device = Device::flex();
        let p = dynamics.preconditioners(&dynamics.stiffness());
        let operators = Operators::new(&constants(&weights_of(&dynamics), &device), &p, &device);
        for _ in 0..10 {
            let x = Latent::from_fn(|_, _| 0.7 * normal(&mut rng));
            let u = normal(&mut rng);
            let row = |v: Vec<f32>| Matrix::new(1, v.len(), v).tensor(&device);
            let x32 = row(x.iter().map(|&v| v as f32).collect());
            let (said, heat) = operators.turn(x32.clone(), row(vec![u as f32]), &operators.frozen());
            let (said, heat) = (numbers(said), f64::from(numbers(heat)[0]));
            let turn = dynamics.turn(&x, u);
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
