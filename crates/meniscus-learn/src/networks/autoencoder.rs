//! The joint autoencoder on scaled POD coefficients: thirteen latents for all groups together.
//!
//! One net for all groups beat five separate ones clearly, with a linear skip that starts as the joint
//! POD. Both halves are zero at zero, so that rest is x = 0 and decodes to rest exactly.

use crate::data::dataset::{Frame, Sequence};
use crate::hyperparameters::AutoencoderParameters;
use crate::networks::noise::normal;
use crate::operators::reference_step::Square;
use crate::stage::{Stage, StageRun, TrainingSplit};
use burn::tensor::{Device, Tensor, TensorData};
use meniscus::latent::generic::{LATENTS, Latent};
use meniscus_optim::descent::Descent;
use meniscus_optim::nets::perceptron;
use meniscus_optim::progress::{annealed, looks_at};
use meniscus_optim::weights::{Matrix, constants, leaves, numbers, scalar};
use nalgebra::{DMatrix, SymmetricEigen};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Width of the hidden layers.
const HIDDEN: usize = 64;

/// Matrices of one half: the skip, then W1, b1, W2, b2, W3.
const HALF: usize = 6;

/// Both halves of the autoencoder, on coefficients divided by their group's scale.
#[derive(Clone, Debug)]
pub(crate) struct Autoencoder {
    /// Encoder half, then decoder half.
    weights: Vec<Matrix>,
}

/// y = S x + n(x) - n(0), n(x) = W3 relu(W2 relu(W1 x + b1) + b2), for every row of `x`.
fn half(x: Tensor<2>, weights: &[Tensor<2>]) -> Tensor<2> {
    let mut layers = weights[1..].to_vec();
    // A bias of the last layer would cancel.
    layers.push(Tensor::zeros([1, weights[0].dims()[0]], &x.device()));
    let net = |x| perceptron(x, &layers, |layer| layer < 2);
    let at_rest = net(Tensor::zeros([1, x.dims()[1]], &x.device()));
    x.clone().matmul(weights[0].clone().transpose()) + net(x) - at_rest
}

fn fresh_half(skip: Matrix, rng: &mut ChaCha8Rng) -> Vec<Matrix> {
    let (outputs, inputs) = (skip.rows, skip.columns);
    let bound = |fan: usize| 1.0 / (fan as f64).sqrt();
    vec![
        skip,
        Matrix::uniform(HIDDEN, inputs, bound(inputs), rng),
        Matrix::uniform(1, HIDDEN, bound(inputs), rng),
        Matrix::uniform(HIDDEN, HIDDEN, bound(HIDDEN), rng),
        Matrix::uniform(1, HIDDEN, bound(HIDDEN), rng),
        // The nonlinear part grows from almost nothing.
        Matrix::uniform(outputs, HIDDEN, 0.02 * bound(HIDDEN), rng),
    ]
}

/// All frames of `sequences`, coefficients over their group's scale, row-major.
#[must_use]
pub(crate) fn scaled(sequences: &[Sequence], frame: &Frame) -> Vec<f32> {
    let scale = frame.coefficient_scale();
    let rows = sequences.iter().flat_map(|s| s.coefficients.chunks_exact(scale.len()));
    rows.flat_map(|row| row.iter().zip(&scale).map(|(c, s)| c / s)).collect()
}

impl Autoencoder {
    /// Linear skips from the joint POD of `rows`: x = l^(-1/2) V^T z, z = V l^(1/2) x.
    fn from_joint_pod(rows: &[f32], width: usize, rng: &mut ChaCha8Rng) -> Self {
        let all = DMatrix::from_row_slice(rows.len() / width, width, rows);
        let covariance = (all.transpose() * &all).map(f64::from) / all.nrows() as f64;
        let eigen = SymmetricEigen::new(covariance);
        let mut order: Vec<usize> = (0..width).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        // Fewer independent coefficients than latents leave the surplus latents silent.
        let deviation =
            |latent: usize| order.get(latent).map_or(0.0, |&i| eigen.eigenvalues[i].max(0.0).sqrt());
        let floor = 1e-3 * deviation(0).max(1e-12);
        let direction =
            |row: usize, latent: usize| order.get(latent).map_or(0.0, |&i| eigen.eigenvectors[(row, i)]);
        let encode = DMatrix::from_fn(LATENTS, width, |l, i| direction(i, l) / deviation(l).max(floor));
        let decode = DMatrix::from_fn(width, LATENTS, |i, l| direction(i, l) * deviation(l));
        let mut weights = fresh_half(Matrix::from_f64(&encode), rng);
        weights.extend(fresh_half(Matrix::from_f64(&decode), rng));
        Self { weights }
    }

    /// Trains on all frames of the training sequences and keeps the weights that are best on the others.
    #[must_use]
    pub(crate) fn train(
        frame: &Frame,
        data: &TrainingSplit<'_, [Sequence]>,
        parameters: &AutoencoderParameters,
        run: StageRun<'_>,
    ) -> Self {
        let StageRun { steps, seed, session } = run;
        let batch_size = parameters.batch;
        let stage = Stage::Autoencoder.info().name;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (width, device) = (frame.width(), Device::flex().autodiff());
        let (rows, held) = (scaled(data.training, frame), scaled(data.validation, frame));
        let count = rows.len() / width;
        let start = Self::from_joint_pod(&rows, width, &mut rng);
        let least = f64::from(start.loss(&held, width)).sqrt();
        let mut descent = Descent::new(stage, start.weights, least, session);
        let bar = session.bar(stage, steps);
        for step in descent.done()..steps {
            let mut rng = Descent::draws(seed, step);
            let batch: Vec<f32> = (0..batch_size)
                .map(|_| rng.random_range(0..count))
                .flat_map(|n| rows[n * width..(n + 1) * width].iter().copied())
                .collect();
            let noise = parameters.latent_noise;
            let jitter = (0..batch_size * LATENTS).map(|_| (noise * normal(&mut rng)) as f32).collect();
            let z = Tensor::from_data(TensorData::new(batch, [batch_size, width]), &device);
            let jitter = Tensor::from_data(TensorData::new(jitter, [batch_size, LATENTS]), &device);
            let tensors = leaves(descent.weights(), &device);
            let (encoder, decoder) = tensors.split_at(HALF);
            let again = half(half(z.clone(), encoder) + jitter, decoder);
            let loss = (again - z).square().sum() / (5 * batch_size) as f32;
            let (weights, adam) = descent.parts();
            adam.step(weights, &tensors, loss.backward(), annealed(parameters.learning_rate, step, steps));
            if looks_at(step, parameters.validate_every, steps) {
                let now = Self { weights: descent.weights().to_vec() }.loss(&held, width);
                let errors = (f64::from(scalar(loss)).sqrt(), f64::from(now).sqrt());
                if descent.look(step + 1, errors, &bar, session) {
                    break;
                }
            }
        }
        bar.finish();
        Self { weights: descent.end(stage, session).0 }
    }

    /// Mean over groups of the squared relative error on `rows`.
    fn loss(&self, rows: &[f32], width: usize) -> f32 {
        let z =
            Tensor::from_data(TensorData::new(rows.to_vec(), [rows.len() / width, width]), &Device::flex());
        let weights = constants(&self.weights, &Device::flex());
        let (encoder, decoder) = weights.split_at(HALF);
        scalar((half(half(z.clone(), encoder), decoder) - z).square().sum())
            / (5 * (rows.len() / width)) as f32
    }

    /// Latents of every frame of `sequence`.
    #[must_use]
    pub(crate) fn encode(&self, sequence: &Sequence, frame: &Frame) -> Vec<Latent> {
        let rows = scaled(std::slice::from_ref(sequence), frame);
        let z = Tensor::from_data(TensorData::new(rows, [sequence.frames(), frame.width()]), &Device::flex());
        let x = numbers(half(z, &constants(&self.weights[..HALF], &Device::flex())));
        x.chunks_exact(LATENTS).map(|row| Latent::from_iterator(row.iter().map(|&v| f64::from(v)))).collect()
    }

    /// Coefficients in SI units of every latent of `x`, row-major.
    #[must_use]
    pub(crate) fn decode(&self, x: &[Latent], frame: &Frame) -> Vec<f32> {
        let rows: Vec<f32> = x.iter().flat_map(|x| x.iter().map(|&v| v as f32)).collect();
        let x = Tensor::from_data(TensorData::new(rows, [x.len(), LATENTS]), &Device::flex());
        let z = numbers(half(x, &constants(&self.weights[HALF..], &Device::flex())));
        let scale = frame.coefficient_scale();
        z.chunks_exact(scale.len()).flat_map(|row| row.iter().zip(&scale).map(|(z, s)| z * s)).collect()
    }

    /// Turns the latents into the principal axes of what they decode to, of unit variance, strongest
    /// first, and silences those that carry nothing. Exact for what is kept: both halves get the same
    /// linear map, and regressions on the latents become well conditioned.
    ///
    /// With U the metric and <y y^T> = Q l Q^T for y = U x: x' = l^(-1/2) Q^T U x.
    #[must_use]
    pub(crate) fn whitened(&self, training: &[Sequence], frame: &Frame, silent_share: f64) -> Self {
        let u = self.metric();
        let latents: Vec<Latent> = training.iter().flat_map(|s| self.encode(s, frame)).collect();
        let spread: Square = latents.iter().map(|x| (u * x) * (u * x).transpose()).sum();
        let eigen = SymmetricEigen::new(spread / latents.len() as f64);
        let mut order: Vec<usize> = (0..LATENTS).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        let deviation = |k: usize| eigen.eigenvalues[order[k]].max(0.0).sqrt();
        let inverse =
            |k: usize| if deviation(k) > silent_share * deviation(0) { 1.0 / deviation(k) } else { 0.0 };
        let turn = Square::from_fn(|i, k| eigen.eigenvectors[(i, order[k])]);
        let forth = Square::from_fn(|k, i| if k == i { inverse(k) } else { 0.0 }) * turn.transpose() * u;
        let back = u.try_inverse().unwrap_or_else(Square::identity)
            * turn
            * Square::from_fn(|k, i| if k == i && inverse(k) > 0.0 { deviation(k) } else { 0.0 });
        self.mapped(&forth, &back)
    }

    /// The same autoencoder with the latents `forth` x in place of x; `back` is the way back.
    #[must_use]
    pub(crate) fn mapped(&self, forth: &Square, back: &Square) -> Self {
        let dynamic = |m: &Square| DMatrix::from_iterator(LATENTS, LATENTS, m.iter().copied());
        let mut weights = self.weights.clone();
        for into_latents in [0, HALF - 1] {
            weights[into_latents] = Matrix::from_f64(&(dynamic(forth) * weights[into_latents].to_f64()));
        }
        for from_latents in [HALF, HALF + 1] {
            weights[from_latents] = Matrix::from_f64(&(weights[from_latents].to_f64() * dynamic(back)));
        }
        Self { weights }
    }

    /// U with |U dx|^2 = |T dx|^2 / 5: how much an error of the latents costs, as the mean over groups
    /// of the squared relative error, to first order.
    #[must_use]
    pub(crate) fn metric(&self) -> Square {
        let t = self.weights[HALF].to_f64();
        let cost = t.tr_mul(&t) / 5.0;
        // A latent that decodes to nothing must still be kept near zero, or it wanders.
        let floor = 1e-4 * cost.trace();
        let cost = Square::from_iterator(cost.iter().copied()) + Square::identity() * floor;
        cost.cholesky().map_or_else(Square::identity, |c| c.l().transpose())
    }

    /// The decoder trunk in SI units as the blob wants it: T, then W and b of three layers, with the
    /// constant of the net at rest folded into b3.
    #[must_use]
    pub(crate) fn trunk(&self, frame: &Frame) -> Vec<Matrix> {
        let scale = frame.coefficient_scale();
        let in_si = |m: &Matrix| {
            let mut m = m.clone();
            for (row, s) in m.values.chunks_exact_mut(m.columns).zip(&scale) {
                row.iter_mut().for_each(|v| *v *= s);
            }
            m
        };
        let [skip, w1, b1, w2, b2, w3] = &self.weights[HALF..] else {
            unreachable!("a half has {HALF} matrices")
        };
        let last = in_si(w3);
        // n(0) = W3 relu(W2 relu(b1) + b2), in single precision like the run time.
        let ramp =
            |row: &[f32], b: &[f32]| row.iter().zip(b).map(|(v, b)| (v + b).max(0.0)).collect::<Vec<f32>>();
        let times = |m: &Matrix, x: &[f32]| {
            let dot = |row: &[f32]| row.iter().zip(x).map(|(w, x)| w * x).sum::<f32>();
            m.values.chunks_exact(m.columns).map(dot).collect::<Vec<f32>>()
        };
        let first = ramp(&vec![0.0; HIDDEN], &b1.values);
        let at_rest = times(&last, &ramp(&times(w2, &first), &b2.values));
        let b3 = Matrix::new(1, at_rest.len(), at_rest.iter().map(|v| -v).collect());
        vec![in_si(skip), w1.clone(), b1.clone(), w2.clone(), b2.clone(), last, b3]
    }
}
