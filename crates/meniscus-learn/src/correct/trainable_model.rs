//! Trainable tensors of a correction, and their loss.
//!
//! ```text
//! y_n   = head(GRU_3(...))                        the reading; GRU_1 and GRU_2 stay as they are
//! x_n-  = step(x_(n-1), u_n)                      the exact GENERIC step
//! x_n   = x_n- + r_n G (y_n - x_n-)               r_n = 1 where there is a reading
//! f_k   = step(f_(k-1), u_k),   f_0 = x^          a roll-out: a forecast that knows the motion
//! loss  = < |S(x_n) - z_n|^2 + |S(y_n) - z_n|^2 / 2 > / <|z|^2>     of tracking_loss, new liquid and source
//!       + < |S(f_k) - z_k|^2 > / <|z|^2>                            of forecast_loss, the new liquid alone
//! ```
//! over the points that were seen, with S the decoder's surface, which stays as it is. A roll-out begins at the
//! state x^ of the running filter under the weights of the last candidate, because a run forecasts from there, and goes on
//! for half a second: an error of frequency or damping grows with the time. Nothing else of the liquid enters. The
//! degeneracy conditions L grad S = 0 and M grad E = 0 hold for every weight, so that the loss needs no term for them (the
//! paper adds one, for the wrong pair).

use crate::correct::effects::{Held, StepWithEffects};
use crate::correct::residual_covariance::FilterRun;
use crate::correct::surface_decoder::{SurfaceDecoder, SurfaceTensors};
use crate::correct::training_window::TrainingWindow;
use crate::operators::reference_step::Square;
use crate::operators::unrolled::Operators;
use burn::tensor::{Device, Tensor, TensorData};
use meniscus::latent::generic::LATENTS;
use meniscus::latent::nn::HIDDEN;
use meniscus::latent::window::WINDOW;
use meniscus::surface::POINTS;
use meniscus_optim::nets::{gru_layer, linear};

/// Matrices that a correction changes: four of the last GRU layer, two of the head, the gain, seven of the
/// dynamics or eight.
pub(super) const GRU: std::ops::Range<usize> = 0..4;
/// The head.
pub(super) const HEAD: std::ops::Range<usize> = 4..6;
/// The gain.
pub(super) const GAIN: usize = 6;
/// The dynamics, in the order of [`crate::operators::unrolled::weights_of`].
pub(super) const DYNAMICS: std::ops::RangeFrom<usize> = 7..;

/// Measured heights, frame by frame, and what an error of each counts.
struct Heights {
    height: Tensor<2>,
    seen: Tensor<2>,
}

/// A batch of roll-outs as tensors.
pub(super) struct Batch {
    /// `WINDOW` tensors `[frames x batch, HIDDEN]`, frame by frame.
    hidden: Vec<Tensor<2>>,
    /// Frames that the filter is followed over.
    frames: usize,
    u: Vec<Tensor<2>>,
    read: Vec<Tensor<2>>,
    truth: Heights,
    /// Memories of the effects at the start, one row each.
    held: Vec<Held>,
}

impl Batch {
    /// Roll-outs that start at (window, frame), with the memories `held`.
    pub(super) fn new(
        windows: &[TrainingWindow],
        starts: &[(usize, usize)],
        held: Vec<Held>,
        tracked_frames: usize,
        device: &Device,
    ) -> Self {
        let frames = tracked_frames + 1;
        let places = || (0..frames).flat_map(|k| starts.iter().map(move |&(i, n)| (i, n + k)));
        let gather = |width: usize, of: &dyn Fn(&TrainingWindow) -> &[f32], from: usize, step: usize| {
            let row = |(i, n): (usize, usize)| {
                let at = n * step + from;
                of(&windows[i])[at..at + width].to_vec()
            };
            let values: Vec<f32> = places().flat_map(row).collect();
            Tensor::<2>::from_data(TensorData::new(values, [frames * starts.len(), width]), device)
        };
        let split = |all: Tensor<2>| -> Vec<Tensor<2>> {
            (0..frames).map(|k| all.clone().narrow(0, k * starts.len(), starts.len())).collect()
        };
        let window = WINDOW * HIDDEN;
        Self {
            hidden: (0..WINDOW).map(|k| gather(HIDDEN, &|l| &l.hidden, k * HIDDEN, window)).collect(),
            u: split(gather(1, &|l| &l.u, 0, 1)),
            read: split(gather(1, &|l| &l.read, 0, 1)),
            truth: Heights {
                height: gather(POINTS, &|l| &l.height, 0, POINTS),
                seen: gather(POINTS, &|l| &l.seen, 0, POINTS),
            },
            frames: tracked_frames,
            held,
        }
    }
}

/// A batch of rollouts as tensors.
pub(super) struct Rollouts {
    from: Tensor<2>,
    /// Memories of the effects at the start, one row each.
    held: Vec<Held>,
    /// A tensor `[rollouts, 1]` for each frame.
    u: Vec<Tensor<2>>,
    truth: Heights,
}

impl Rollouts {
    /// Roll-outs that begin at (window, frame) in the states of `run`.
    pub(super) fn new(
        run: &FilterRun<'_>,
        starts: &[(usize, usize)],
        frames: usize,
        device: &Device,
    ) -> Self {
        let FilterRun { windows, states } = *run;
        let tensor = |values: Vec<f32>, width: usize| {
            let rows = values.len() / width;
            Tensor::<2>::from_data(TensorData::new(values, [rows, width]), device)
        };
        let row = |k: usize, width: usize, of: &dyn Fn(&TrainingWindow) -> &[f32]| -> Vec<f32> {
            let one = |&(i, n): &(usize, usize)| &of(&windows[i])[(n + k) * width..(n + k + 1) * width];
            starts.iter().flat_map(one).copied().collect()
        };
        let points = |of: &dyn Fn(&TrainingWindow) -> &[f32]| {
            tensor((1..=frames).flat_map(|k| row(k, POINTS, of)).collect(), POINTS)
        };
        let from = starts.iter().flat_map(|&(i, n)| states[i][n].latent.iter().map(|&x| x as f32));
        Self {
            from: tensor(from.collect(), LATENTS),
            held: run.held(starts),
            u: (1..=frames).map(|k| tensor(row(k, 1, &|l| &l.u), 1)).collect(),
            truth: Heights { height: points(&|l| &l.height), seen: points(&|l| &l.seen) },
        }
    }
}

/// Model of one step of Adam, from which its losses are made.
pub(super) struct TrainableModel<'a> {
    weights: &'a [Tensor<2>],
    decoded: SurfaceTensors,
    operators: Operators,
    frozen: Operators,
    effects: Option<StepWithEffects<'a>>,
}

/// Liquid of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Liquid {
    /// The one that is learnt, with the effects that the model carries.
    New,
    /// The one that the model was trained on.
    Source,
}

impl<'a> TrainableModel<'a> {
    /// With `weights` (leaves), with what stays, and with the step of a model that carries effects.
    pub(super) fn new(
        weights: &'a [Tensor<2>],
        surface: &SurfaceDecoder,
        preconditioners: &[Square],
        effects: Option<StepWithEffects<'a>>,
        device: &Device,
    ) -> Self {
        let operators = Operators::new(&weights[DYNAMICS], preconditioners, device);
        let decoded = SurfaceTensors::new(surface, device);
        Self { weights, decoded, frozen: operators.frozen(), operators, effects }
    }

    /// One turn of every row under the ports `u`.
    fn turn(&self, liquid: Liquid, x: Tensor<2>, u: &Tensor<2>, held: &mut [Held]) -> Tensor<2> {
        match &self.effects {
            Some(effects) if liquid == Liquid::New => effects.turn(x, u.clone(), held),
            _ => self.operators.turn(x, u.clone(), &self.frozen).0,
        }
    }

    /// < |S(x) - z|^2 >, relative to the mean square height `size`, m2.
    fn miss(&self, x: Tensor<2>, truth: &Heights, size: f32) -> Tensor<1> {
        let points = (x.dims()[0] * POINTS) as f32;
        ((self.decoded.heights(x) - truth.height.clone()) * truth.seen.clone()).square().sum()
            * (1.0 / (points * size))
    }

    /// The loss of tracking_loss `batch` of `liquid`.
    pub(super) fn tracking_loss(&self, batch: &Batch, liquid: Liquid, size: f32) -> Tensor<1> {
        let mut states = gru_layer(batch.hidden.clone(), &self.weights[GRU]);
        let last = states.pop().expect("a window has at least one frame");
        let head = &self.weights[HEAD];
        let y_all = linear(last, &head[0], &head[1]).narrow(1, 0, LATENTS);
        let y = |k: usize| y_all.clone().narrow(0, k * batch.held.len(), batch.held.len());
        let gain_t = self.weights[GAIN].clone().transpose();
        let (mut x, mut held) = (y(0), batch.held.clone());
        let mut filtered = vec![x.clone()];
        for k in 1..=batch.frames {
            let predicted = self.turn(liquid, x, &batch.u[k], &mut held);
            let innovation = (y(k) - predicted.clone()).matmul(gain_t.clone()) * batch.read[k].clone();
            x = predicted + innovation;
            filtered.push(x.clone());
        }
        self.miss(Tensor::cat(filtered, 0), &batch.truth, size) + self.miss(y_all, &batch.truth, size) * 0.5
    }

    /// The loss of forecast_loss `rollouts`.
    pub(super) fn forecast_loss(&self, rollouts: &Rollouts, size: f32) -> Tensor<1> {
        let (mut f, mut held) = (rollouts.from.clone(), rollouts.held.clone());
        let mut all = Vec::with_capacity(rollouts.u.len());
        for u in &rollouts.u {
            f = self.turn(Liquid::New, f, u, &mut held);
            all.push(f.clone());
        }
        self.miss(Tensor::cat(all, 0), &rollouts.truth, size)
    }
}
