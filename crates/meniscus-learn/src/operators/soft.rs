//! Structure-preserving net of the paper, for comparison: its degeneracy is a penalty in the loss alone.
//!
//! ```text
//! net(x) = (L, C, e, s);   x1 = x + dt [ L e + M s + B u ],   L skew, M = C C^T, e for dE/dx, s for dS/dx
//! loss   = |x1 - x|^2 over a roll-out + weight ( |M e|^2 + |L s|^2 )      L s = 0 and M e = 0 only so far
//! ```
//! (Hernandez et al., J. Comput. Phys. 426 (2021) 109950, with the pair of conditions the right way round.)
//! It learns from the same trajectories, port, batches and horizons as the exact step, and is judged by the same
//! roll-outs. e is the gradient of nothing, so that its energy is what its own e says along the way.

use crate::data::trajectory::Path;
use crate::hyperparameters::Hyperparameters;
use crate::operators::laws;
use crate::operators::open_loop::{Open, open_loop, validate};
use crate::operators::reference_step::{Dynamics, Square};
use crate::operators::rollout::draw;
use crate::stage::{Stage, StageRun, TrainingSplit};
use burn::tensor::{Device, Tensor, TensorData};
use meniscus::latent::generic::{LATENTS, Latent};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_optim::descent::Descent;
use meniscus_optim::laws::Laws;
use meniscus_optim::nets::perceptron;
use meniscus_optim::progress::{annealed, looks_at};
use meniscus_optim::weights::{Matrix, constants, leaves, numbers, scalar};
use meniscus_report::checks::Check;
use nalgebra::DMatrix;
use rand_chacha::ChaCha8Rng;

/// Strict lower triangle of L, lower triangle of C, e, s.
const OUTPUTS: usize = LATENTS * (LATENTS - 1) / 2 + LATENTS * (LATENTS + 1) / 2 + 2 * LATENTS;

/// Width of the three hidden layers. The paper has thirteen of 195, which cost a hundred times as much.
const WIDTH: usize = 96;

/// Operators are rates, 1/s; the net gives them in this unit.
const RATE: f32 = 30.0;

/// Output of the net at one state.
struct StateOperators {
    skew: Square,
    friction: Square,
    energy: Latent,
    entropy: Latent,
}

impl StateOperators {
    /// L e + M s.
    fn rate(&self) -> Latent {
        self.skew * self.energy + self.friction * self.entropy
    }
}

/// Index of entry (i, j) among the outputs, and its sign, for L flattened row by row; `None` on the diagonal.
fn skew_index(i: usize, j: usize) -> Option<(usize, f32)> {
    let at = |i: usize, j: usize| i * (i - 1) / 2 + j;
    match i.cmp(&j) {
        core::cmp::Ordering::Greater => Some((at(i, j), 1.0)),
        core::cmp::Ordering::Less => Some((at(j, i), -1.0)),
        core::cmp::Ordering::Equal => None,
    }
}

/// Constant matrices that spread the outputs over the full L and C, row-major.
fn spreads(device: &Device) -> [Tensor<2>; 2] {
    let full = LATENTS * LATENTS;
    let (lower, triangle) = (LATENTS * (LATENTS - 1) / 2, LATENTS * (LATENTS + 1) / 2);
    let (mut l, mut c) = (Matrix::zeros(lower, full), Matrix::zeros(triangle, full));
    for (i, j) in (0..full).map(|k| (k / LATENTS, k % LATENTS)) {
        if let Some((from, sign)) = skew_index(i, j) {
            l.values[from * full + i * LATENTS + j] = sign;
        }
        if i >= j {
            c.values[(i * (i + 1) / 2 + j) * full + i * LATENTS + j] = 1.0;
        }
    }
    [l.tensor(device), c.tensor(device)]
}

/// Rate L e + M s of every row of `x`, and M e, L s.
fn rate(x: Tensor<2>, weights: &[Tensor<2>], spread: &[Tensor<2>; 2]) -> [Tensor<2>; 3] {
    let rows = x.dims()[0];
    let said = perceptron(x, weights, |layer| layer < 3);
    let (lower, triangle) = (LATENTS * (LATENTS - 1) / 2, LATENTS * (LATENTS + 1) / 2);
    let square = |from: usize, count: usize, spread: &Tensor<2>| {
        let flat = said.clone().narrow(1, from, count).matmul(spread.clone());
        flat.reshape([rows, LATENTS, LATENTS])
    };
    let (l, c) = (square(0, lower, &spread[0]), square(lower, triangle, &spread[1]));
    let column = |from: usize| said.clone().narrow(1, from, LATENTS).reshape([rows, LATENTS, 1]);
    let (e, s) = (column(lower + triangle), column(lower + triangle + LATENTS));
    let friction = |v: Tensor<3>| c.clone().matmul(c.clone().swap_dims(1, 2).matmul(v));
    let flat = |v: Tensor<3>| v.reshape([rows, LATENTS]) * RATE;
    [flat(l.clone().matmul(e.clone()) + friction(s.clone())), flat(friction(e)), flat(l.matmul(s))]
}

/// A trained soft net: the weights of the perceptron, then B.
pub(crate) struct Soft {
    weights: Vec<Matrix>,
}

impl Soft {
    fn fresh(port: &Latent, rng: &mut ChaCha8Rng) -> Vec<Matrix> {
        let bound = |fan: usize| 1.0 / (fan as f64).sqrt();
        let mut weights = Vec::new();
        for (inputs, outputs) in [(LATENTS, WIDTH), (WIDTH, WIDTH), (WIDTH, WIDTH), (WIDTH, OUTPUTS)] {
            weights.push(Matrix::uniform(outputs, inputs, bound(inputs), rng));
            weights.push(Matrix::uniform(1, outputs, bound(inputs), rng));
        }
        let port = port.iter().map(|b| (b / f64::from(RATE)) as f32).collect();
        weights.push(Matrix::new(1, LATENTS, port));
        weights
    }

    /// Trains on the training paths and keeps the weights that roll out best on the others; B starts where that of
    /// `exact` ended.
    #[must_use]
    pub(crate) fn train(
        exact: &Dynamics,
        data: &TrainingSplit<'_, [Path]>,
        metric: &Square,
        parameters: &Hyperparameters,
        run: StageRun<'_>,
    ) -> Self {
        let StageRun { steps, seed, session } = run;
        let TrainingSplit { training, validation } = *data;
        // As many roll-outs a step as the exact net learns from.
        let (batch, parameters) = (parameters.rollout.batch, &parameters.soft);
        let stage = Stage::Soft.info().name;
        let device = Device::flex().autodiff();
        let metric_t =
            Matrix::from_f64(&DMatrix::from_fn(LATENTS, LATENTS, |i, j| metric[(j, i)])).tensor(&device);
        let spread = spreads(&device);
        let all = || training.iter().flat_map(|p| &p.x);
        let size = (all().map(|x| (metric * x).norm_squared()).sum::<f64>() / all().count() as f64) as f32;
        let start = Self::fresh(&exact.port, &mut Descent::draws(seed, usize::MAX));
        let check = |weights: &[Matrix]| {
            let soft = Self { weights: weights.to_vec() };
            validate(|x, u| soft.roll_out(x, u), validation, metric)
        };
        let mut descent = Descent::new(stage, start, f64::INFINITY, session);
        let bar = session.bar(stage, steps);
        for step in descent.done()..steps {
            let mut rng = Descent::draws(seed, step);
            let horizon = parameters.horizons[3 * step / steps];
            let starts = draw(training, batch, horizon, &mut rng);
            let column = |f: &dyn Fn(&Path, usize) -> Vec<f32>, k: usize| {
                let rows: Vec<f32> = starts.iter().flat_map(|&(p, n)| f(&training[p], n + k)).collect();
                let width = rows.len() / batch;
                Tensor::<2>::from_data(TensorData::new(rows, [batch, width]), &device)
            };
            let state = |k| column(&|p, n| p.x[n].iter().map(|&v| v as f32).collect(), k);
            let tensors = leaves(descent.weights(), &device);
            let (net, port) = tensors.split_at(tensors.len() - 1);
            let mut x = state(0);
            let mut loss: Option<Tensor<1>> = None;
            for k in 1..=horizon {
                let [flow, m_e, l_s] = rate(x.clone(), net, &spread);
                let kick = column(&|p, n| vec![p.u[n] as f32], k).matmul(port[0].clone()) * RATE;
                x = x + (flow + kick) * FRAME_INTERVAL_S as f32;
                let miss = (x.clone() - state(k)).matmul(metric_t.clone()).square().sum() * size.recip();
                let degenerate = (m_e.square().sum() + l_s.square().sum())
                    * (parameters.degeneracy_weight / (RATE * RATE));
                let part = (miss + degenerate) * (1.0 / (horizon * batch) as f32);
                loss = Some(loss.map_or(part.clone(), |sum| sum + part));
            }
            let Some(loss) = loss else { break };
            let (weights, adam) = descent.parts();
            adam.step(weights, &tensors, loss.backward(), annealed(parameters.learning_rate, step, steps));
            if looks_at(step, parameters.validate_every, steps) {
                let errors = (f64::from(scalar(loss)).sqrt(), check(descent.weights()));
                if descent.look(step + 1, errors, &bar, session) {
                    break;
                }
            }
        }
        bar.finish();
        Self { weights: descent.end(stage, session).0 }
    }

    /// Output of the net at `x`.
    fn say(&self, x: &Latent) -> StateOperators {
        let device = Device::flex();
        let row = Matrix::new(1, LATENTS, x.iter().map(|&v| v as f32).collect()).tensor(&device);
        let said = numbers(perceptron(row, &constants(&self.weights[..8], &device), |layer| layer < 3));
        let lower = LATENTS * (LATENTS - 1) / 2;
        let triangle = LATENTS * (LATENTS + 1) / 2;
        let skew = Square::from_fn(|i, j| {
            skew_index(i, j).map_or(0.0, |(at, sign)| f64::from(RATE * sign * said[at]))
        });
        let c =
            Square::from_fn(|i, j| if i >= j { f64::from(said[lower + i * (i + 1) / 2 + j]) } else { 0.0 });
        let column = |from: usize| Latent::from_fn(|i, _| f64::from(said[from + i]));
        StateOperators {
            skew,
            friction: c * c.transpose() * f64::from(RATE),
            energy: column(lower + triangle),
            entropy: column(lower + triangle + LATENTS),
        }
    }

    /// B.
    fn port(&self) -> Latent {
        Latent::from_iterator(self.weights[8].values.iter().map(|&v| f64::from(RATE * v)))
    }

    /// The states after each of `ports`, from `x`.
    #[must_use]
    pub(crate) fn roll_out(&self, x: Latent, ports: &[f64]) -> Vec<Latent> {
        let b = self.port();
        let next = |x: &mut Latent, &u: &f64| {
            *x += (self.say(x).rate() + b * u) * FRAME_INTERVAL_S;
            Some(*x)
        };
        ports.iter().scan(x, next).collect()
    }

    /// The two laws along the roll-outs of `paths`, on each of which the net goes its own way.
    fn laws(&self, paths: &[Path]) -> Laws {
        let (b, mut laws) = (self.port(), Laws::default());
        for Open { from, ports, .. } in paths.iter().flat_map(open_loop) {
            let mut x = from;
            for &u in ports {
                let said = self.say(&x);
                let StateOperators { skew, friction, energy, entropy } = &said;
                let closed = said.rate() * FRAME_INTERVAL_S;
                laws.step(energy.as_slice(), entropy.as_slice(), closed.as_slice());
                laws.reversible((skew * entropy).norm(), (skew * energy).norm());
                laws.irreversible((friction * energy).norm(), (friction * entropy).norm());
                x += closed + b * (u * FRAME_INTERVAL_S);
            }
        }
        laws
    }

    /// Roll-outs and laws of both steps on `paths`, side by side.
    #[must_use]
    pub(crate) fn checks(&self, exact: &Dynamics, paths: &[Path], metric: &Square) -> Vec<Check> {
        let percent = |name: &str, share: f64| Check::informational(name, 100.0 * share, "%");
        let (hard, soft) = (laws::of_exact(exact, paths), self.laws(paths));
        let mut checks = vec![
            percent("exact_rollout", validate(|x, u| exact.roll_out(x, u), paths, metric)),
            percent("soft_rollout", validate(|x, u| self.roll_out(x, u), paths, metric)),
            Check::exactly("entropy_falls", f64::from(hard.laws.falls()), "1", 0.0),
            Check::informational("soft_entropy_falls", f64::from(soft.falls()), "1"),
            Check::informational("steps_of_both", f64::from(soft.steps()), "1"),
            Check::at_most("energy_drift_step", hard.drift, "H", 1e-6),
        ];
        checks.extend(hard.laws.checks("exact"));
        checks.extend(soft.checks("soft"));
        checks
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    /// The tensors of training and the plain numbers of the judge are the same net.
    #[test]
    fn rate_agrees_with_what_is_said() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let soft = Soft { weights: Soft::fresh(&Latent::zeros(), &mut rng) };
        let device = Device::flex();
        let x = Latent::from_fn(|i, _| 0.3 * (i as f64 + 1.0).sin());
        let row = Matrix::new(1, LATENTS, x.iter().map(|&v| v as f32).collect()).tensor(&device);
        let [flow, m_e, l_s] = rate(row, &constants(&soft.weights[..8], &device), &spreads(&device));
        let StateOperators { skew, friction, energy, entropy } = soft.say(&x);
        assert!((skew + skew.transpose()).norm() < 1e-9, "L is skew");
        for (tensor, due) in
            [(flow, skew * energy + friction * entropy), (m_e, friction * energy), (l_s, skew * entropy)]
        {
            let said = Latent::from_iterator(numbers(tensor).into_iter().map(f64::from));
            assert!((said - due).norm() < 1e-4 * due.norm(), "{said} against {due}");
        }
    }
}
