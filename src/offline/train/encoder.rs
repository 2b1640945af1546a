//! The encoder: three GRU layers from a window of noisy profiles and accelerations to the latents.

use super::dataset::{Frame, Sequence};
use super::generic::{LATENTS, Latent, Square};
use super::nets::{self, CELLS, LAYERS};
use super::noise::{FEATURES, Noise, Seen, WINDOW};
use super::progress::{Session, annealed};
use super::weights::{Adam, Matrix, constants, leaves, numbers, scalar};
use crate::offline::prelude::*;
use burn::tensor::{Device, Tensor, TensorData};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Windows of one training step.
const BATCH: usize = 128;

/// Epochs between two looks at the validation recordings.
const LOOK: usize = 5;

/// The weights of the encoder, four matrices a GRU layer, then the head and its bias.
#[derive(Clone, Debug)]
pub(super) struct Encoder {
    /// W_i, W_h, b_i, b_h of each layer, then W and b of the head.
    pub(super) weights: Vec<Matrix>,
}

/// A sequence with what the encoder should say at each of its frames.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lesson<'a> {
    /// What happened.
    pub(super) sequence: &'a Sequence,
    /// The true latents.
    pub(super) latents: &'a [Latent],
}

impl Encoder {
    /// Random weights as PyTorch starts them.
    fn fresh(rng: &mut ChaCha8Rng) -> Self {
        let bound = 1.0 / (CELLS as f64).sqrt();
        let mut weights = Vec::new();
        for layer in 0..LAYERS {
            let inputs = if layer == 0 { FEATURES } else { CELLS };
            weights.push(Matrix::uniform(3 * CELLS, inputs, bound, rng));
            weights.push(Matrix::uniform(3 * CELLS, CELLS, bound, rng));
            weights.push(Matrix::uniform(1, 3 * CELLS, bound, rng));
            weights.push(Matrix::uniform(1, 3 * CELLS, bound, rng));
        }
        weights.push(Matrix::uniform(LATENTS, CELLS, bound, rng));
        weights.push(Matrix::uniform(1, LATENTS, bound, rng));
        Self { weights }
    }

    /// Trains for `epochs`, every epoch with fresh noise, and keeps what is best on the validation
    /// recordings seen by [`Noise::CAMERA`]. `metric` weighs the errors of the latents.
    #[must_use]
    pub(super) fn train(
        frame: &Frame,
        training: &[Lesson<'_>],
        validation: &[Lesson<'_>],
        metric: &Square,
        (epochs, seed): (usize, u64),
        session: &Session<'_>,
    ) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let device = Device::flex().autodiff();
        let mut net = Self::fresh(&mut rng);
        let held: Vec<Seen> =
            validation.iter().map(|l| Seen::new(l.sequence, frame, Some(Noise::CAMERA), &mut rng)).collect();
        let mut order: Vec<(usize, usize)> = training
            .iter()
            .enumerate()
            .flat_map(|(i, lesson)| (0..lesson.sequence.frames()).map(move |n| (i, n)))
            .collect();
        let metric_t = Matrix::from_f64(&nalgebra::DMatrix::from_fn(LATENTS, LATENTS, |i, j| metric[(j, i)]));
        let metric_t = metric_t.tensor(&device);
        let mut adam = Adam::new(&net.weights, 1.0);
        let (mut best, mut least) = (net.clone(), f64::INFINITY);
        let bar = session.bar("encoder", epochs);
        for epoch in 0..epochs {
            let seen: Vec<Seen> =
                training.iter().map(|l| Seen::new(l.sequence, frame, None, &mut rng)).collect();
            order.shuffle(&mut rng);
            let mut total = 0.0;
            for batch in order.chunks(BATCH) {
                let ends = batch.iter().map(|&(i, n)| (&seen[i], n));
                let target: Vec<f32> = batch
                    .iter()
                    .flat_map(|&(i, n)| training[i].latents[n].iter().map(|&v| v as f32))
                    .collect();
                let target = Tensor::<2>::from_data(TensorData::new(target, [batch.len(), LATENTS]), &device);
                let tensors = leaves(&net.weights, &device);
                let miss = nets::encoder(windows(ends, &device), &tensors) - target;
                let loss = miss.matmul(metric_t.clone()).square().sum() / batch.len() as f32;
                let grads = loss.backward();
                total += scalar(loss) * batch.len() as f32;
                adam.step(&mut net.weights, &tensors, grads, annealed(4e-3, epoch, epochs));
            }
            if epoch % LOOK == LOOK - 1 || epoch + 1 == epochs {
                let error = net.error(&held, validation, metric);
                if error < least {
                    (best, least) = (net.clone(), error);
                }
                bar.show(epoch + 1, f64::from(total / order.len() as f32).sqrt(), error.sqrt());
                if session.stopped() {
                    break;
                }
            }
        }
        bar.finish();
        best
    }

    /// Mean squared error of the latents in `metric` over all frames of `lessons`.
    fn error(&self, seen: &[Seen], lessons: &[Lesson<'_>], metric: &Square) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for (seen, lesson) in seen.iter().zip(lessons) {
            for (said, truth) in self.read(seen).iter().zip(lesson.latents) {
                sum += (metric * (said - truth)).norm_squared();
                count += 1;
            }
        }
        sum / f64::from(count.max(1))
    }

    /// What the encoder says at every frame of `seen`.
    #[must_use]
    pub(super) fn read(&self, seen: &Seen) -> Vec<Latent> {
        let device = Device::flex();
        let frames = seen.features.len() / FEATURES;
        let inputs = windows((0..frames).map(|n| (seen, n)), &device);
        let x = numbers(nets::encoder(inputs, &constants(&self.weights, &device)));
        x.chunks_exact(LATENTS).map(|row| Latent::from_iterator(row.iter().map(|&v| f64::from(v)))).collect()
    }
}

/// One tensor `[windows, features]` for each frame of the windows that end where `ends` says.
fn windows<'a>(ends: impl Iterator<Item = (&'a Seen, usize)>, device: &Device) -> Vec<Tensor<2>> {
    let mut frames = vec![Vec::new(); WINDOW];
    let mut count = 0;
    for (seen, end) in ends {
        frames.iter_mut().zip(seen.window(end)).for_each(|(all, one)| all.extend_from_slice(one));
        count += 1;
    }
    frames.into_iter().map(|f| Tensor::from_data(TensorData::new(f, [count, FEATURES]), device)).collect()
}

/// A seed for one stage out of the seed of the run.
#[must_use]
pub(super) fn derive_seed(seed: u64, stage: u64) -> u64 {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stage);
    rng.random()
}
