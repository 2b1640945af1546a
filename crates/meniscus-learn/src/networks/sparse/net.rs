//! One sparse autoencoder: a perceptron down to a bottleneck and one up again, and which latents are worth keeping.

use crate::hyperparameters::SparseParameters;
use crate::stage::{StageRun, TrainingSplit};
use burn::tensor::{Device, Tensor, TensorData};
use meniscus_optim::descent::Descent;
use meniscus_optim::nets::perceptron;
use meniscus_optim::progress::{annealed, looks_at};
use meniscus_optim::weights::{Matrix, constants, leaves, numbers, scalar};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// One of the paper's autoencoders.
pub(super) struct NetShape {
    /// Group.
    pub(super) name: &'static str,
    /// Its place among the trunk groups; none of the internal energy, which the trunk does not decode.
    pub(super) trunk: Option<usize>,
    /// Width of a hidden layer.
    pub(super) hidden_width: usize,
    /// Hidden layers of a half.
    pub(super) hidden_layers: usize,
    /// Width of the bottleneck.
    pub(super) bottleneck: usize,
}

/// Rows of one group, divided by their scale.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    pub(super) values: Vec<f32>,
    pub(super) width: usize,
}

impl Rows {
    pub(super) fn count(&self) -> usize {
        self.values.len() / self.width
    }

    fn tensor(&self, device: &Device) -> Tensor<2> {
        Tensor::from_data(TensorData::new(self.values.clone(), [self.count(), self.width]), device)
    }
}

/// One trained autoencoder.
#[derive(Clone, Debug)]
pub(super) struct Net {
    /// Encoder half, then decoder half, W and b of each layer.
    weights: Vec<Matrix>,
    /// Hidden layers of a half.
    depth: usize,
    /// 1 for a latent that stays, 0 for one that is held at its mean; and the means.
    pub(super) keep: Vec<f32>,
    mean: Vec<f32>,
}

fn half(x: Tensor<2>, weights: &[Tensor<2>], depth: usize) -> Tensor<2> {
    perceptron(x, weights, |layer| 0 < layer && layer < depth)
}

impl Net {
    pub(super) fn fresh(shape: &NetShape, width: usize, rng: &mut ChaCha8Rng) -> Self {
        let (hidden, depth) = (shape.hidden_width, shape.hidden_layers);
        let mut weights = Vec::new();
        for (from, to) in [(width, shape.bottleneck), (shape.bottleneck, width)] {
            for layer in 0..=depth {
                let inputs = if layer == 0 { from } else { hidden };
                let outputs = if layer == depth { to } else { hidden };
                let bound = 1.0 / (inputs as f64).sqrt();
                weights.push(Matrix::uniform(outputs, inputs, bound, rng));
                weights.push(Matrix::uniform(1, outputs, bound, rng));
            }
        }
        Self { weights, depth, keep: vec![1.0; shape.bottleneck], mean: vec![0.0; shape.bottleneck] }
    }

    /// z^ and x of every row of `z`.
    fn through(&self, z: Tensor<2>, weights: &[Tensor<2>]) -> [Tensor<2>; 2] {
        let (encoder, decoder) = weights.split_at(2 * (self.depth + 1));
        let x = half(z, encoder, self.depth);
        let row = |values: Vec<f32>| {
            let width = values.len();
            Tensor::<2>::from_data(TensorData::new(values, [1, width]), &x.device())
        };
        let held = self.mean.iter().zip(&self.keep).map(|(m, k)| m * (1.0 - k)).collect();
        let kept = x.clone() * row(self.keep.clone()) + row(held);
        [half(kept, decoder, self.depth), x]
    }

    /// z^ and x of all `rows`.
    pub(super) fn run(&self, rows: &Rows) -> [Vec<f32>; 2] {
        let device = Device::flex();
        self.through(rows.tensor(&device), &constants(&self.weights, &device)).map(numbers)
    }

    /// Mean of |z^ - z|^2 over `rows`; |z|^2 is 1 in the mean for every group in them.
    pub(super) fn error(&self, rows: &Rows) -> f64 {
        let [again, _] = self.run(rows);
        let square = |(a, z): (&f32, &f32)| f64::from(a - z).powi(2);
        again.iter().zip(&rows.values).map(square).sum::<f64>() / rows.count() as f64
    }

    /// Trains with the given weight of the L1 norm. Without it the weights that are best on the validation rows are kept,
    /// under it the last: the best would be the least sparse.
    pub(super) fn train(
        &mut self,
        stage: &str,
        data: &TrainingSplit<'_, Rows>,
        l1_weight: f32,
        parameters: &SparseParameters,
        run: StageRun<'_>,
    ) {
        let StageRun { steps, seed, session } = run;
        let TrainingSplit { training: rows, validation } = *data;
        let batch = parameters.batch;
        let device = Device::flex().autodiff();
        let mut descent = Descent::new(stage, self.weights.clone(), self.error(validation).sqrt(), session);
        let bar = session.bar(stage, steps);
        for step in descent.done()..steps {
            let mut rng = Descent::draws(seed, step);
            let drawn = (0..batch).map(|_| rng.random_range(0..rows.count()) * rows.width);
            let values = drawn.flat_map(|at| rows.values[at..at + rows.width].iter().copied()).collect();
            let z = Rows { values, width: rows.width }.tensor(&device);
            let tensors = leaves(descent.weights(), &device);
            let [again, x] = self.through(z.clone(), &tensors);
            let miss = (again - z).square().sum() / batch as f32;
            let loss = miss.clone() + x.abs().sum() * (l1_weight / batch as f32);
            let (weights, adam) = descent.parts();
            adam.step(weights, &tensors, loss.backward(), annealed(parameters.learning_rate, step, steps));
            if looks_at(step, parameters.validate_every, steps) {
                let now =
                    Self { weights: descent.weights().to_vec(), ..self.clone() }.error(validation).sqrt();
                if descent.look(step + 1, (f64::from(scalar(miss)).sqrt(), now), &bar, session) {
                    break;
                }
            }
        }
        bar.finish();
        let last = descent.weights().to_vec();
        let (best, _) = descent.end(stage, session);
        self.weights = if l1_weight > 0.0 { last } else { best };
    }

    /// Deviation of each latent over `rows`; their means are kept for those that will be cut off.
    pub(super) fn measure(&mut self, rows: &Rows) -> Vec<f32> {
        let [_, x] = self.run(rows);
        let (width, count) = (self.keep.len(), rows.count() as f32);
        let column = |l: usize| x.iter().skip(l).step_by(width);
        self.mean = (0..width).map(|l| column(l).sum::<f32>() / count).collect();
        let spread = |l: usize| column(l).map(|v| (v - self.mean[l]).powi(2)).sum::<f32>() / count;
        (0..width).map(|l| spread(l).sqrt()).collect()
    }

    /// The latents, the dearest first, and the error with the first k of them for k from 0.
    pub(super) fn ordered(&self, rows: &Rows) -> (Vec<usize>, Vec<f64>) {
        let width = self.keep.len();
        let with = |keep: &dyn Fn(usize) -> bool| {
            let keep = (0..width).map(|l| f32::from(u8::from(keep(l)))).collect();
            Self { keep, ..self.clone() }.error(rows)
        };
        let cost: Vec<f64> = (0..width).map(|gone| with(&|l| l != gone)).collect();
        let mut order: Vec<usize> = (0..width).collect();
        order.sort_by(|&a, &b| cost[b].total_cmp(&cost[a]));
        let errors = (0..=width).map(|k| with(&|l| order[..k].contains(&l))).collect();
        (order, errors)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_optim::progress::Session;
    use rand::SeedableRng;

    #[test]
    fn what_the_data_do_not_need_is_switched_off_and_what_stays_learns_on() {
        // Six numbers that follow from two.
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut rows = |count: usize| {
            let mut values = Vec::new();
            for _ in 0..count {
                let [a, b]: [f32; 2] = std::array::from_fn(|_| (2.0 * rng.random::<f64>() - 1.0) as f32);
                values.extend([a, b, a + b, a - b, 0.5 * a, 0.5 * b].map(|z| 0.6 * z));
            }
            Rows { values, width: 6 }
        };
        let (seen, held) = (rows(400), rows(100));
        let shape = NetShape { name: "six", trunk: None, hidden_width: 24, hidden_layers: 2, bottleneck: 6 };
        let parameters = SparseParameters::default();
        let stop = std::sync::atomic::AtomicBool::new(false);
        let session = Session::new(true, &stop);
        let mut net = Net::fresh(&shape, 6, &mut ChaCha8Rng::seed_from_u64(5));
        let data = TrainingSplit { training: &seen, validation: &held };
        let run = |steps, seed| StageRun { steps, seed, session: &session };
        net.train("six", &data, 3e-2, &parameters, run(600, 6));
        net.measure(&seen);
        let (order, curve) = net.ordered(&seen);
        // Two would do; the penalty knows no corners of a plane and leaves a third. The other three do nothing.
        assert!(
            curve[3] < 1e-3 * curve[0] && curve[3] < 1.1 * curve[6] && curve[1] > 100.0 * curve[3],
            "{curve:?}"
        );
        net.keep = (0..6).map(|l| f32::from(u8::from(order[..2].contains(&l)))).collect();
        let before = net.error(&held);
        net.train("six, cut", &data, 0.0, &parameters, run(400, 7));
        assert!(net.error(&held) <= before && net.error(&held) < 5e-3, "{}", net.error(&held));
    }
}
