//! Trajectories that both nets learn from and are chosen by, and the descent of the soft one: single steps between true states
//! first, then roll-outs of growing length.
//!
//! Every look rolls out the trajectories that choose, whole, and the best look stays.
//!
//! ```text
//! loss = mean of sqrt(m^2 + d^2) - d,     m the miss of a variable, of its stride (steps) or its spread (roll-outs)
//! ```
//! A modulus for all but small misses, for the reason in [`super::squares`], whose turns are the exact net's.

use super::soft::Soft;
use burn::tensor::{Device, Tensor, TensorData};
use meniscus_optim::descent::Descent;
use meniscus_optim::progress::{Session, annealed, looks_at};
use meniscus_optim::weights::{Matrix, leaves, scalar};
use nalgebra::DVector;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Pairs of states of one step of the first stage.
const STEP_BATCH: usize = 512;

/// Roll-outs of one step of the second stage.
const ROLLOUT_BATCH: usize = 64;

/// Steps between two looks of the first stage.
const STEP_LOOK: usize = 500;

/// Steps between two looks of the second stage.
const ROLLOUT_LOOK: usize = 50;

/// Weight of what a step owes to the laws, against its relative error.
const PENALTY: f32 = 1e-2;

/// d: misses below this are squares.
const SMALL: f32 = 1e-2;

/// Horizons of the second stage, in turn.
const HORIZONS: [usize; 4] = [8, 16, 32, 48];

/// Steps of roll-outs by which the exact net is put right, in turn; the last is cut to what there is.
const AHEAD: [usize; 4] = [8, 24, 72, usize::MAX];

/// Length of a training.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Schedule {
    /// Turns of the exact net on single steps.
    pub steps: usize,
    /// Its turns on roll-outs.
    pub rollouts: usize,
    /// Steps of descent of the soft net on single steps, and on roll-outs.
    pub soft: [usize; 2],
    /// Trainings from different seeds; the best on the trajectories that choose stays.
    pub seeds: u64,
}

impl Schedule {
    /// Some ten minutes of one core for ten variables.
    pub const FULL: Self = Self { steps: 60, rollouts: 40, soft: [20_000, 600], seeds: 1 };

    /// A minute or two.
    pub const QUICK: Self = Self { steps: 20, rollouts: 8, soft: [3000, 60], seeds: 1 };

    /// Length of the roll-outs of turn `turn`.
    pub(super) fn horizon(&self, turn: usize) -> usize {
        AHEAD[AHEAD.len() * turn / self.rollouts.max(turn + 1)]
    }
}

/// Scaled trajectories that are learnt from and chosen by.
pub(super) struct Lessons {
    pub(super) training: Vec<Vec<DVector<f64>>>,
    pub(super) choosing: Vec<Vec<DVector<f64>>>,
    /// Root mean square of what one step changes, by variable; 1 of what does not move.
    pub(super) stride: Vec<f64>,
    /// Standard deviation of every variable; 1 of what does not move.
    pub(super) spread: Vec<f64>,
    /// Whether a variable moves.
    pub(super) moves: Vec<bool>,
}

impl Lessons {
    fn rows(&self, at: &[(usize, usize)], device: &Device) -> Tensor<2> {
        let numbers: Vec<f32> =
            at.iter().flat_map(|&(p, n)| self.training[p][n].iter().map(|&v| v as f32)).collect();
        let width = numbers.len() / at.len().max(1);
        Tensor::from_data(TensorData::new(numbers, [at.len(), width]), device)
    }

    /// `count` places from which `ahead` steps are known.
    fn draw(&self, count: usize, ahead: usize, rng: &mut ChaCha8Rng) -> Vec<(usize, usize)> {
        let place = |_| {
            let path = rng.random_range(0..self.training.len());
            let room = self.training[path].len().saturating_sub(ahead).max(1);
            (path, rng.random_range(0..room))
        };
        (0..count).map(place).collect()
    }

    /// Relative error of `roll` over the whole of every trajectory that chooses, the root mean square over variables.
    pub(super) fn validate(&self, roll: impl Fn(&DVector<f64>, usize) -> Vec<DVector<f64>>) -> f64 {
        let (mut miss, mut count) = (0.0, 0_usize);
        let moves = || (0..self.spread.len()).filter(|&i| self.moves[i]);
        for path in &self.choosing {
            for (said, x) in roll(&path[0], path.len()).iter().zip(path) {
                // A roll-out that has left counts as lost, not as infinitely bad, so that looks can be compared.
                miss += moves().map(|i| ((said[i] - x[i]) / self.spread[i]).powi(2).min(100.0)).sum::<f64>();
                count += moves().count();
            }
        }
        let error = (miss / count.max(1) as f64).sqrt();
        if error.is_finite() { error } else { f64::INFINITY }
    }
}

/// Sum of sqrt(m^2 + d^2) - d.
fn modulus(miss: Tensor<2>) -> Tensor<1> {
    ((miss.square() + SMALL * SMALL).sqrt() - SMALL).sum()
}

/// Inputs of the descent of the soft net.
#[derive(Clone, Copy)]
pub(super) struct SoftDescent<'a> {
    /// Net that is trained.
    pub(super) net: &'a Soft,
    /// Trajectories to learn from.
    pub(super) lessons: &'a Lessons,
    /// Seed of everything that is drawn.
    pub(super) seed: u64,
    /// Steps of both stages.
    pub(super) schedule: Schedule,
    /// Error by which the best look is chosen.
    pub(super) check: &'a dyn Fn(&[Matrix]) -> f64,
    /// Bars, stop flag and checkpoints.
    pub(super) session: &'a Session<'a>,
}

/// Inverse scales of the variables as one row.
fn inverse_scales(scales: &[f64], device: &Device) -> Tensor<2> {
    let inverse: Vec<f32> = scales.iter().map(|s| (1.0 / s) as f32).collect();
    Matrix::new(1, inverse.len(), inverse).tensor(device)
}

impl SoftDescent<'_> {
    /// Trains on single steps, then on roll-outs; returns the best weights and their error.
    pub(super) fn learn(&self) -> (Vec<Matrix>, f64) {
        let device = Device::flex().autodiff();
        let fresh = self.net.fresh(&mut Descent::draws(self.seed, usize::MAX));
        let (weights, least) = self.single_steps(fresh, &device);
        self.rollouts(weights, least, &device)
    }

    /// First stage: single steps between true states.
    fn single_steps(&self, fresh: Vec<Matrix>, device: &Device) -> (Vec<Matrix>, f64) {
        let Self { net, lessons, seed, schedule, check, session } = *self;
        let steps = schedule.soft[0];
        let weigh = inverse_scales(&lessons.stride, device);
        let width = lessons.stride.len() as f32;
        let stage = format!("soft steps {:04x}", seed & 0xffff);
        let mut descent = Descent::new(&stage, fresh, f64::INFINITY, session);
        let bar = session.bar(&stage, steps);
        for step in descent.done()..steps {
            if session.stopped() {
                break;
            }
            let mut rng = Descent::draws(seed, step);
            let from = lessons.draw(STEP_BATCH, 1, &mut rng);
            let to: Vec<_> = from.iter().map(|&(p, n)| (p, n + 1)).collect();
            let tensors = leaves(descent.weights(), device);
            let (miss, owed) = net.miss(&tensors, lessons.rows(&from, device), lessons.rows(&to, device));
            let weighed = modulus(miss * weigh.clone()) * (1.0 / width);
            let loss = (weighed + owed.sum() * PENALTY) * (1.0 / STEP_BATCH as f32);
            let (weights, adam) = descent.parts();
            adam.step(weights, &tensors, loss.clone().backward(), annealed(4e-3, step, steps));
            if looks_at(step, STEP_LOOK, steps) {
                let errors = (f64::from(scalar(loss)), check(descent.weights()));
                if descent.look(step + 1, errors, &bar, session) {
                    break;
                }
            }
        }
        bar.finish();
        descent.end(&stage, session)
    }

    /// Second stage: roll-outs of growing length, from `weights` with the error `least`.
    fn rollouts(&self, weights: Vec<Matrix>, least: f64, device: &Device) -> (Vec<Matrix>, f64) {
        let Self { net, lessons, seed, schedule, check, session } = *self;
        let steps = schedule.soft[1];
        let spreads = inverse_scales(&lessons.spread, device);
        let width = lessons.stride.len() as f32;
        let stage = format!("soft roll-outs {:04x}", seed & 0xffff);
        let mut descent = Descent::new(&stage, weights, least, session);
        let bar = session.bar(&stage, steps);
        let longest = lessons.training.iter().map(Vec::len).min().unwrap_or(2) - 1;
        for step in descent.done()..steps {
            if session.stopped() {
                break;
            }
            let mut rng = Descent::draws(seed ^ 1, step);
            let horizon = HORIZONS[HORIZONS.len() * step / steps].min(longest);
            let from = lessons.draw(ROLLOUT_BATCH, horizon, &mut rng);
            let tensors = leaves(descent.weights(), device);
            let mut x = lessons.rows(&from, device);
            let mut loss = Tensor::<1>::zeros([1], device);
            for k in 1..=horizon {
                let (next, owed) = net.turn(&tensors, x);
                let due: Vec<_> = from.iter().map(|&(p, n)| (p, n + k)).collect();
                let miss = modulus((next.clone() - lessons.rows(&due, device)) * spreads.clone());
                loss = loss + miss * (1.0 / width) + owed.sum() * (PENALTY * 1e-2);
                x = next;
            }
            let loss = loss * (1.0 / (horizon * ROLLOUT_BATCH) as f32);
            let (weights, adam) = descent.parts();
            adam.step(weights, &tensors, loss.clone().backward(), annealed(5e-4, step, steps));
            if looks_at(step, ROLLOUT_LOOK, steps) {
                let errors = (f64::from(scalar(loss)), check(descent.weights()));
                if descent.look(step + 1, errors, &bar, session) {
                    break;
                }
            }
        }
        bar.finish();
        descent.end(&stage, session)
    }
}
