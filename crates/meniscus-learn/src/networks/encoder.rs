//! The encoder: three GRU layers from a window of noisy profiles and accelerations to the latents.

use crate::data::dataset::{Frame, Sequence};
use crate::hyperparameters::EncoderParameters;
use crate::networks::base::BaseWeights;
use crate::networks::noise::{Noise, Seen};
use crate::operators::reference_step::Square;
use crate::stage::{Stage, StageRun, TrainingSplit};
use burn::tensor::{Device, Tensor, TensorData};
use meniscus::latent::encoder::GRU_LAYERS as LAYERS;
use meniscus::latent::encoder::READINGS;
use meniscus::latent::generic::{LATENTS, Latent};
use meniscus::latent::nn::HIDDEN as CELLS;
use meniscus::latent::window::{FEATURES, WINDOW};
use meniscus_optim::descent::Descent;
use meniscus_optim::nets;
use meniscus_optim::progress::{annealed, looks_at};
use meniscus_optim::weights::{Matrix, constants, leaves, numbers, scalar};
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

/// Ridge of the least squares for a head on layers of another model; hidden states are of order one.
const HEAD_RIDGE: f64 = 1e-2;

/// The weights of the encoder, four matrices a GRU layer, then the head and its bias.
#[derive(Clone, Debug)]
pub(crate) struct Encoder {
    /// W_i, W_h, b_i, b_h of each layer, then W and b of the head.
    pub(crate) weights: Vec<Matrix>,
}

/// Reading of one frame: the latents, and the port value of that instant, which the glass
/// position gives only a frame later.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reading {
    /// Latents.
    pub(crate) latent: Latent,
    /// Port value.
    pub(crate) port: f64,
}

/// Cost of an error of a reading: |U dx|^2 + w^2 du^2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cost {
    /// U.
    pub(crate) metric: Square,
    /// w.
    pub(crate) port: f64,
}

impl Cost {
    fn of(&self, said: &Reading, latent: &Latent, port: f64) -> f64 {
        (self.metric * (said.latent - latent)).norm_squared() + (self.port * (said.port - port)).powi(2)
    }

    /// The matrix that turns a row of errors into one whose squared length is the cost.
    fn matrix(&self) -> Matrix {
        let entry = |i: usize, j: usize| match (i < LATENTS, j < LATENTS) {
            (true, true) => self.metric[(j, i)],
            (false, false) => self.port,
            _ => 0.0,
        };
        Matrix::from_f64(&DMatrix::from_fn(READINGS, READINGS, entry))
    }
}

/// Sequence with the latents that the encoder has to give at each of its frames.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LabelledSequence<'a> {
    /// Projected recording.
    pub(crate) sequence: &'a Sequence,
    /// The true latents.
    pub(crate) latents: &'a [Latent],
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
        weights.push(Matrix::uniform(READINGS, CELLS, bound, rng));
        weights.push(Matrix::uniform(1, READINGS, bound, rng));
        Self { weights }
    }

    /// The recurrent `layers` of another model with a head by least squares on `training`, seen once by the camera; `None` where the
    /// layers have other shapes.
    fn with_layers(
        layers: Vec<Matrix>,
        training: &[LabelledSequence<'_>],
        frame: &Frame,
        rng: &mut ChaCha8Rng,
    ) -> Option<Self> {
        let fresh = Self::fresh(rng).weights;
        let same = |(a, b): (&Matrix, &Matrix)| (a.rows, a.columns) == (b.rows, b.columns);
        if layers.len() != 4 * LAYERS || !layers.iter().zip(&fresh).all(same) {
            return None;
        }
        let device = Device::flex();
        let mut probe = layers.clone();
        probe.push(Matrix::from_f64(&DMatrix::identity(CELLS, CELLS)));
        probe.push(Matrix::zeros(1, CELLS));
        let probe = constants(&probe, &device);
        // (W b) minimises |W h + b - x|^2 over all frames: normal equations of (h, 1).
        let mut normal = DMatrix::<f64>::identity(CELLS + 1, CELLS + 1) * HEAD_RIDGE;
        let mut right = DMatrix::<f64>::zeros(CELLS + 1, READINGS);
        for labelled in training {
            let seen = Seen::new(labelled.sequence, frame, Some(Noise::CAMERA), rng);
            let frames = labelled.sequence.frames();
            let hidden = numbers(nets::encoder(windows((0..frames).map(|n| (&seen, n)), &device), &probe));
            for ((row, latent), port) in
                hidden.chunks_exact(CELLS).zip(labelled.latents).zip(&labelled.sequence.port)
            {
                let h = DVector::from_iterator(CELLS + 1, row.iter().map(|&v| f64::from(v)).chain([1.0]));
                let due = DVector::from_iterator(READINGS, latent.iter().copied().chain([*port]));
                normal.ger(1.0, &h, &h, 1.0);
                right.ger(1.0, &h, &due, 1.0);
            }
        }
        let head = normal.cholesky()?.solve(&right).transpose();
        let mut weights = layers;
        weights.push(Matrix::from_f64(&head.columns(0, CELLS).into_owned()));
        let bias = head.column(CELLS).iter().map(|&v| v as f32).collect();
        weights.push(Matrix::new(1, READINGS, bias));
        Some(Self { weights })
    }

    /// Trains for the epochs of `run`, every epoch with fresh noise, and keeps what is best on the validation
    /// recordings seen by [`Noise::CAMERA`]. `cost` weighs the errors.
    #[must_use]
    pub(crate) fn train(
        frame: &Frame,
        data: &TrainingSplit<'_, [LabelledSequence<'_>]>,
        cost: &Cost,
        parameters: &EncoderParameters,
        base: Option<&BaseWeights>,
        run: StageRun<'_>,
    ) -> Self {
        let StageRun { steps: epochs, seed, session } = run;
        let TrainingSplit { training, validation } = *data;
        let stage = Stage::Encoder.info().name;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let device = Device::flex().autodiff();
        let start = base
            .and_then(BaseWeights::recurrent)
            .and_then(|layers| Self::with_layers(layers, training, frame, &mut rng))
            .unwrap_or_else(|| Self::fresh(&mut rng));
        let held: Vec<Seen> =
            validation.iter().map(|l| Seen::new(l.sequence, frame, Some(Noise::CAMERA), &mut rng)).collect();
        let order: Vec<(usize, usize)> = training
            .iter()
            .enumerate()
            .flat_map(|(i, labelled_sequence)| (0..labelled_sequence.sequence.frames()).map(move |n| (i, n)))
            .collect();
        let cost_t = cost.matrix().tensor(&device);
        let mut descent = Descent::new(stage, start.weights, f64::INFINITY, session);
        let bar = session.bar(stage, epochs);
        for epoch in descent.done()..epochs {
            let mut rng = Descent::draws(seed, epoch);
            let mut order = order.clone();
            let seen: Vec<Seen> =
                training.iter().map(|l| Seen::new(l.sequence, frame, None, &mut rng)).collect();
            order.shuffle(&mut rng);
            let mut total = 0.0;
            for batch in order.chunks(parameters.batch) {
                let ends = batch.iter().map(|&(i, n)| (&seen[i], n));
                let due = |&(i, n): &(usize, usize)| {
                    let labelled_sequence: &LabelledSequence<'_> = &training[i];
                    let all = labelled_sequence.latents[n]
                        .iter()
                        .copied()
                        .chain([labelled_sequence.sequence.port[n]]);
                    all.map(|v| v as f32).collect::<Vec<f32>>()
                };
                let target: Vec<f32> = batch.iter().flat_map(due).collect();
                let target =
                    Tensor::<2>::from_data(TensorData::new(target, [batch.len(), READINGS]), &device);
                let tensors = leaves(descent.weights(), &device);
                let miss = nets::encoder(windows(ends, &device), &tensors) - target;
                let loss = miss.matmul(cost_t.clone()).square().sum() / batch.len() as f32;
                let grads = loss.backward();
                total += scalar(loss) * batch.len() as f32;
                let (weights, adam) = descent.parts();
                adam.step(weights, &tensors, grads, annealed(parameters.learning_rate, epoch, epochs));
            }
            if looks_at(epoch, parameters.validate_every, epochs) {
                let now = Self { weights: descent.weights().to_vec() };
                let error = now.error(&held, validation, cost).sqrt();
                let errors = (f64::from(total / order.len() as f32).sqrt(), error);
                if descent.look(epoch + 1, errors, &bar, session) {
                    break;
                }
            }
        }
        bar.finish();
        Self { weights: descent.end(stage, session).0 }
    }

    /// Mean cost over all frames of `labelled`.
    fn error(&self, seen: &[Seen], labelled: &[LabelledSequence<'_>], cost: &Cost) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for (seen, labelled_sequence) in seen.iter().zip(labelled) {
            for ((said, truth), &port) in
                self.read(seen).iter().zip(labelled_sequence.latents).zip(&labelled_sequence.sequence.port)
            {
                sum += cost.of(said, truth, port);
                count += 1;
            }
        }
        sum / f64::from(count.max(1))
    }

    /// Returns the readings at every frame of `seen`.
    #[must_use]
    pub(crate) fn read(&self, seen: &Seen) -> Vec<Reading> {
        let device = Device::flex();
        let frames = seen.features.len() / FEATURES;
        let inputs = windows((0..frames).map(|n| (seen, n)), &device);
        let said = numbers(nets::encoder(inputs, &constants(&self.weights, &device)));
        let reading = |row: &[f32; READINGS]| {
            let [latent @ .., port] = row.map(f64::from);
            Reading { latent: Latent::from(latent), port }
        };
        said.as_chunks::<READINGS>().0.iter().map(reading).collect()
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
