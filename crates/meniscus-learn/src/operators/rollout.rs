//! Training of the exact GENERIC step through unrolled roll-outs, each turn solved.
//!
//! One-step training is erratic for every variant; ten and more steps are not. What is unrolled is the
//! step that runs, so its weights need no allowance for another integrator.

use crate::data::trajectory::Path;
use crate::hyperparameters::RolloutParameters;
use crate::operators::open_loop::validate;
use crate::operators::precondition::typical;
use crate::operators::reference_step::{Dynamics, Square};
use crate::operators::unrolled::{Operators, dynamics_of, weights_of};
use crate::stage::{StageRun, TrainingSplit};
use burn::tensor::{Device, Tensor, TensorData};
use meniscus::latent::generic::LATENTS;
use meniscus_optim::descent::Descent;
use meniscus_optim::progress::{annealed, looks_at};
use meniscus_optim::weights::{Matrix, leaves, scalar};
use nalgebra::DMatrix;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Sum of sqrt(1 + m^2) - 1: a square for small misses, a modulus for large ones, so that books which
/// are far off at first do not drown the states.
fn soft(miss: Tensor<2>) -> Tensor<1> {
    ((miss.square() + 1.0).sqrt() - 1.0).sum()
}

/// Trains `start` on the training paths and keeps the weights that roll out best on the others, with their error.
#[must_use]
pub(crate) fn train(
    start: &Dynamics,
    data: &TrainingSplit<'_, [Path]>,
    metric: &Square,
    parameters: &RolloutParameters,
    run: StageRun<'_>,
) -> (Dynamics, f64) {
    let StageRun { steps, seed, session } = run;
    let TrainingSplit { training, validation } = *data;
    let batch = parameters.batch;
    let device = Device::flex().autodiff();
    let metric_t =
        Matrix::from_f64(&DMatrix::from_fn(LATENTS, LATENTS, |i, j| metric[(j, i)])).tensor(&device);
    let check = |d: &Dynamics| validate(|x, u| d.roll_out(x, u), validation, metric);
    let stage = format!("dynamics {:04x}", seed & 0xffff);
    let mut descent = Descent::new(&stage, weights_of(start), check(start), session);
    let fresh = |weights: &[Matrix]| typical(&dynamics_of(weights), training.iter().flat_map(|p| &p.x));
    let mut preconditioner = fresh(descent.weights());
    // After each look, too: a training that goes on from there begins with that of its weights.
    let mut looked = false;
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
    let bar = session.bar(&stage, steps);
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
        if looked || step % parameters.precondition_every == 0 {
            preconditioner = fresh(descent.weights());
        }
        let operators = Operators::new(&tensors, &preconditioner, &device);
        let frozen = operators.frozen();
        let energy = column(&|p, n| vec![p.energy[n] as f32], 0);
        let mut loss = soft((operators.energy(state(0)) - energy) * energy_size.sqrt().recip())
            * parameters.energy_weight;
        let (mut x, mut due) = (state(0), column(&|p, n| vec![(p.heat[n + horizon] - p.heat[n]) as f32], 0));
        for k in 1..=horizon {
            let (next, heat) = operators.turn(x, column(&|p, n| vec![p.u[n] as f32], k), &frozen);
            (x, due) = (next, due - heat);
            let miss = (x.clone() - state(k)).matmul(metric_t.clone()).square().sum();
            loss = loss + miss * (1.0 / (horizon as f32 * state_size));
        }
        let loss =
            (loss + soft(due * heat_size(horizon).sqrt().recip()) * parameters.heat_weight) / batch as f32;
        let (weights, adam) = descent.parts();
        adam.step(weights, &tensors, loss.backward(), annealed(parameters.learning_rate, step, steps));
        looked = looks_at(step, parameters.validate_every, steps);
        if looked {
            let error = check(&dynamics_of(descent.weights()));
            if descent.look(step + 1, (f64::from(scalar(loss)).sqrt(), error), &bar, session) {
                break;
            }
        }
    }
    bar.finish();
    let (best, least) = descent.end(&stage, session);
    (dynamics_of(&best), least)
}

/// Starts of `count` roll-outs as (path, frame): anywhere, but of two draws the livelier.
pub(crate) fn draw(
    training: &[Path],
    count: usize,
    horizon: usize,
    rng: &mut ChaCha8Rng,
) -> Vec<(usize, usize)> {
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
    (0..count).map(livelier).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::networks::noise::normal;
    use crate::operators::friction_law;
    use crate::operators::reference_step::tests::random;
    use meniscus::latent::generic::{FrictionLaw, Latent};
    use meniscus_data::liquids::Rheology;
    use meniscus_optim::progress::Session;
    use std::sync::atomic::AtomicBool;

    /// Paths of a liquid with a yield stress: operators whose friction is linear follow them less well than those under the liquid's law,
    /// trained alike from the same start.
    #[test]
    fn a_law_follows_a_yielding_liquid_that_linear_friction_does_not() {
        let liquid = Rheology { consistency: 2.0, index: 0.4, yield_stress: 8.0, largest: 100.0 };
        let (base, mut rng) = random(21);
        let path = |dynamics: &Dynamics, rng: &mut ChaCha8Rng| {
            // Strong and weak motions, each of its own strength.
            let strength = 3.0 * normal(rng).abs();
            let u: Vec<f64> =
                (0..150).map(|n| strength * normal(rng) * f64::from(u8::from(n < 90))).collect();
            let turns = dynamics.turns(Latent::zeros(), &u);
            let x: Vec<Latent> = turns.iter().map(|turn| turn.x).collect();
            let energy = x.iter().map(|x| dynamics.energy(x)).collect();
            let heat = turns.iter().scan(0.0, |sum, turn| {
                *sum += turn.heat;
                Some(*sum)
            });
            Path { heat: heat.collect(), x, u, energy }
        };
        let plain: Vec<Path> = (0..4).map(|_| path(&base, &mut rng)).collect();
        let law = friction_law::first(&base, &liquid, &plain).expect("no Newtonian liquid");
        let truth = Dynamics { law: Some(law), ..base.clone() };
        let [training, validation] =
            [8, 4].map(|n| (0..n).map(|_| path(&truth, &mut rng)).collect::<Vec<_>>());
        let data = TrainingSplit { training: training.as_slice(), validation: validation.as_slice() };
        let stop = AtomicBool::new(false);
        let session = Session::new(true, &stop);
        let parameters = RolloutParameters { batch: 32, horizons: [8, 12, 16], ..Default::default() };
        // Half of the friction, and a law that starts a factor of three beside.
        let start = Dynamics { friction: base.friction * 0.7, ..base };
        let [linear, under] = [None, Some(FrictionLaw { typical: 3.0 * law.typical, ..law })].map(|law| {
            let run = StageRun { steps: 90, seed: 5, session: &session };
            train(&Dynamics { law, ..start.clone() }, &data, &Square::identity(), &parameters, run).1
        });
        println!("error of roll-outs: {linear:.3} with linear friction, {under:.3} under the law");
        assert!(under < 0.5 * linear, "{under} for {linear}");
    }
}
