//! Training of the exact GENERIC step through unrolled roll-outs, each turn solved.
//!
//! One-step training is erratic for every variant; ten and more steps are not. What is unrolled is the
//! step that runs, so its weights need no allowance for another integrator.

use crate::operators::linear::Path;
use crate::operators::precondition::typical;
use crate::operators::reference_step::{Dynamics, Square};
use crate::operators::unrolled::{Operators, dynamics_of, weights_of};
use burn::tensor::{Device, Tensor, TensorData};
use meniscus::latent::generic::{LATENTS, Latent};
use meniscus_optim::descent::Descent;
use meniscus_optim::progress::{Session, annealed};
use meniscus_optim::weights::{Matrix, leaves, scalar};
use nalgebra::DMatrix;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Roll-outs of one training step: at these sizes the cost is calls, not numbers.
pub(crate) const BATCH: usize = 128;

/// Weight of the energy against the states in the loss, both relative to their mean square: what makes
/// H the energy of the slosh and not just any function that falls.
const ENERGY_WEIGHT: f32 = 0.05;

/// Weight of the heat of a whole roll-out in the loss, likewise.
const HEAT_WEIGHT: f32 = 0.02;

/// Turns of a validation roll-out: two seconds.
pub(crate) const HORIZON: usize = 120;

/// Steps between two looks at the validation recordings.
const LOOK: usize = 25;

/// Steps for which one preconditioner serves.
const REFRESH: usize = 10;

/// Sum of sqrt(1 + m^2) - 1: a square for small misses, a modulus for large ones, so that books which
/// are far off at first do not drown the states.
fn soft(miss: Tensor<2>) -> Tensor<1> {
    ((miss.square() + 1.0).sqrt() - 1.0).sum()
}

/// Relative error of roll-outs of up to [`HORIZON`] turns from true states, in `metric`.
#[must_use]
pub(crate) fn validate(
    roll_out: impl Fn(Latent, &[f64]) -> Vec<Latent>,
    paths: &[Path],
    metric: &Square,
) -> f64 {
    let (mut miss, mut size) = (0.0, 0.0);
    for Open { from, ports, truth } in paths.iter().flat_map(open_loop) {
        for (said, x) in roll_out(from, ports).iter().zip(truth) {
            miss += (metric * (said - x)).norm_squared();
            size += (metric * x).norm_squared();
        }
    }
    (miss / size.max(f64::MIN_POSITIVE)).sqrt()
}

/// One roll-out to judge by: a true state, the ports after it, and where they truly led.
pub(crate) struct Open<'p> {
    /// The true state.
    pub(crate) from: Latent,
    /// Ports of the turns from there.
    pub(crate) ports: &'p [f64],
    /// The true state after each.
    pub(crate) truth: &'p [Latent],
}

/// The roll-outs of up to [`HORIZON`] turns along `path`, each beginning in the middle of the one before.
pub(crate) fn open_loop(path: &Path) -> impl Iterator<Item = Open<'_>> {
    (0..path.x.len().saturating_sub(HORIZON / 2)).step_by(HORIZON / 2).map(move |from| {
        let to = (from + 1 + HORIZON).min(path.x.len());
        Open { from: path.x[from], ports: &path.u[from + 1..to], truth: &path.x[from + 1..to] }
    })
}

/// Trains `start` on `training` for `steps` steps and keeps what rolls out best on `validation`.
#[must_use]
pub(crate) fn train(
    start: &Dynamics,
    (training, validation): (&[Path], &[Path]),
    metric: &Square,
    (steps, seed): (usize, u64),
    session: &Session<'_>,
) -> (Dynamics, f64) {
    let device = Device::flex().autodiff();
    let metric_t =
        Matrix::from_f64(&DMatrix::from_fn(LATENTS, LATENTS, |i, j| metric[(j, i)])).tensor(&device);
    let check = |d: &Dynamics| validate(|x, u| d.roll_out(x, u), validation, metric);
    let stage = format!("dynamics {:04x}", seed & 0xffff);
    let mut descent = Descent::new(&stage, weights_of(start), check(start), session);
    let fresh = |weights: &[Matrix]| typical(&dynamics_of(weights), training.iter().flat_map(|p| &p.x));
    let mut preconditioner = fresh(descent.weights());
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
        let horizon = [8, 16, 30][3 * step / steps];
        let starts = draw(training, horizon, &mut rng);
        let column = |f: &dyn Fn(&Path, usize) -> Vec<f32>, k: usize| {
            let rows: Vec<f32> = starts.iter().flat_map(|&(p, n)| f(&training[p], n + k)).collect();
            let width = rows.len() / BATCH;
            Tensor::<2>::from_data(TensorData::new(rows, [BATCH, width]), &device)
        };
        let state = |k| column(&|p, n| p.x[n].iter().map(|&v| v as f32).collect(), k);
        let tensors = leaves(descent.weights(), &device);
        if step % REFRESH == 0 {
            preconditioner = fresh(descent.weights());
        }
        let operators = Operators::new(&tensors, &preconditioner, &device);
        let frozen = operators.frozen();
        let energy = column(&|p, n| vec![p.energy[n] as f32], 0);
        let mut loss =
            soft((operators.energy(state(0)) - energy) * energy_size.sqrt().recip()) * ENERGY_WEIGHT;
        let (mut x, mut due) = (state(0), column(&|p, n| vec![(p.heat[n + horizon] - p.heat[n]) as f32], 0));
        for k in 1..=horizon {
            let (next, heat) = operators.turn(x, column(&|p, n| vec![p.u[n] as f32], k), &frozen);
            (x, due) = (next, due - heat);
            let miss = (x.clone() - state(k)).matmul(metric_t.clone()).square().sum();
            loss = loss + miss * (1.0 / (horizon as f32 * state_size));
        }
        let loss = (loss + soft(due * heat_size(horizon).sqrt().recip()) * HEAT_WEIGHT) / BATCH as f32;
        let (weights, adam) = descent.parts();
        adam.step(weights, &tensors, loss.backward(), annealed(2e-3, step, steps));
        if step % LOOK == LOOK - 1 || step + 1 == steps {
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

/// Where [`BATCH`] roll-outs start, as (path, frame): anywhere, but of two draws the livelier.
pub(crate) fn draw(training: &[Path], horizon: usize, rng: &mut ChaCha8Rng) -> Vec<(usize, usize)> {
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
