//! What a correction may change, as burn tensors, and the loss that it changes it by.
//!
//! ```text
//! y_n   = head(GRU_3(...))                        the reading; GRU_1 and GRU_2 stay as they are
//! x_n-  = step(x_(n-1), u_n)                      the exact GENERIC step
//! x_n   = x_n- + r_n G (y_n - x_n-)               r_n = 1 where there is a reading
//! f_k   = step(f_(k-1), u_k),   f_0 = x^          a flight: a forecast that knows the motion
//! loss  = < |S(x_n) - z_n|^2 + |S(y_n) - z_n|^2 / 2 > / <|z|^2>     of following, new liquid and source
//!       + < |S(f_k) - z_k|^2 > / <|z|^2>                            of foretelling, the new liquid alone
//! ```
//! over the points that were seen, with S the decoder's surface, which stays as it is. A flight begins where the running
//! filter itself stood (x^, under the weights of the last look), because it is from there that a run foretells, and goes on for
//! half a second: what is wrong with frequency and damping grows with the time. Nothing else of the liquid enters. The
//! degeneracy conditions L grad S = 0 and M grad E = 0 hold for every weight, so that the loss needs no term for them (the
//! paper adds one, for the wrong pair).

use crate::correct::training_window::Lesson;
use crate::operators::reference_step::Square;
use crate::operators::unrolled::Operators;
use burn::tensor::{Device, Tensor, TensorData};
use meniscus::blob::Tensor as Name;
use meniscus::latent::decoder::MAX_TRUNK;
use meniscus::latent::generic::LATENTS;
use meniscus::latent::generic::Latent;
use meniscus::latent::nn::HIDDEN;
use meniscus::latent::window::WINDOW;
use meniscus::surface::POINTS;
use meniscus_data::blob_file::write::Part;
use meniscus_optim::nets::{gru_layer, linear, perceptron};
use meniscus_optim::weights::{Matrix, numbers};

/// Frames of one lesson's roll-out: 0.2 s, most of a period.
pub(super) const HORIZON: usize = 12;

/// Frames of a flight: 0.5 s.
pub(super) const FLIGHT: usize = 30;

/// Matrices that a correction changes: four of the last GRU layer, two of the head, seven of the
/// dynamics, the gain.
pub(super) const GRU: std::ops::Range<usize> = 0..4;
/// The head.
pub(super) const HEAD: std::ops::Range<usize> = 4..6;
/// The dynamics, in the order of [`crate::operators::unrolled::weights_of`].
pub(super) const DYNAMICS: std::ops::Range<usize> = 6..13;
/// The gain.
pub(super) const GAIN: usize = 13;

/// The surface of the decoder: `rest + B (T x + n(x))`.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    linear: Matrix,
    trunk: Vec<Matrix>,
    basis: Matrix,
    /// Heights at rest, m.
    pub(super) rest: Vec<f32>,
}

impl Surface {
    /// From the tensors of a blob; `None` where one is missing.
    pub(super) fn new(parts: &[Part]) -> Option<Self> {
        let part = |name: Name| parts.iter().find(|part| part.tensor == name);
        let matrix = |part: &Part| Matrix::new(part.rows, part.columns, part.values.clone());
        let row = |part: &Part| Matrix::new(1, part.rows, part.values.clone());
        // The surface is the last group of the trunk.
        let basis = part(Name::GroupBasis(5))?;
        let last = |m: Matrix| {
            let from = (m.rows - basis.columns) * m.columns;
            Matrix::new(basis.columns, m.columns, m.values[from..].to_vec())
        };
        let bias = row(part(Name::TrunkBias(2))?);
        let bias = bias.values[bias.columns - basis.columns..].to_vec();
        let trunk = vec![
            matrix(part(Name::TrunkWeight(0))?),
            row(part(Name::TrunkBias(0))?),
            matrix(part(Name::TrunkWeight(1))?),
            row(part(Name::TrunkBias(1))?),
            last(matrix(part(Name::TrunkWeight(2))?)),
            Matrix::new(1, bias.len(), bias),
        ];
        debug_assert!(trunk[0].rows <= MAX_TRUNK);
        let rest = part(Name::GroupRest(5))?.values.clone();
        Some(Self { linear: last(matrix(part(Name::TrunkLinear)?)), trunk, basis: matrix(basis), rest })
    }

    /// Heights over rest of every state of `x`, row-major, m.
    pub(super) fn heights(&self, x: &[Latent]) -> Vec<f32> {
        let device = Device::flex();
        let rows: Vec<f32> = x.iter().flat_map(|x| x.iter().map(|&v| v as f32)).collect();
        let x = Tensor::from_data(TensorData::new(rows, [x.len(), LATENTS]), &device);
        numbers(Decoded::new(self, &device).heights(x))
    }
}

/// The decoder's surface as tensors.
struct Decoded {
    linear_t: Tensor<2>,
    trunk: Vec<Tensor<2>>,
    basis_t: Tensor<2>,
}

impl Decoded {
    fn new(surface: &Surface, device: &Device) -> Self {
        Self {
            linear_t: surface.linear.tensor(device).transpose(),
            trunk: surface.trunk.iter().map(|m| m.tensor(device)).collect(),
            basis_t: surface.basis.tensor(device).transpose(),
        }
    }

    /// Heights over rest of every row of `x`, m.
    fn heights(&self, x: Tensor<2>) -> Tensor<2> {
        let bent = perceptron(x.clone(), &self.trunk, |layer| layer < 2);
        (x.matmul(self.linear_t.clone()) + bent).matmul(self.basis_t.clone())
    }
}

/// A batch of roll-outs as tensors.
pub(super) struct Batch {
    /// `WINDOW` tensors `[frames x batch, HIDDEN]`, frame by frame.
    hidden: Vec<Tensor<2>>,
    u: Vec<Tensor<2>>,
    read: Vec<Tensor<2>>,
    height: Tensor<2>,
    seen: Tensor<2>,
    size: usize,
}

impl Batch {
    /// Roll-outs that start at (lesson, frame).
    pub(super) fn new(lessons: &[&Lesson], starts: &[(usize, usize)], device: &Device) -> Self {
        let frames = HORIZON + 1;
        let places = || (0..frames).flat_map(|k| starts.iter().map(move |&(i, n)| (i, n + k)));
        let gather = |width: usize, of: &dyn Fn(&Lesson) -> &[f32], from: usize, step: usize| {
            let row = |(i, n): (usize, usize)| {
                let at = n * step + from;
                of(lessons[i])[at..at + width].to_vec()
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
            height: gather(POINTS, &|l| &l.height, 0, POINTS),
            seen: gather(POINTS, &|l| &l.seen, 0, POINTS),
            size: starts.len(),
        }
    }
}

/// A batch of flights as tensors.
pub(super) struct Flights {
    from: Tensor<2>,
    /// [`FLIGHT`] tensors `[flights, 1]`.
    u: Vec<Tensor<2>>,
    /// Frame by frame.
    height: Tensor<2>,
    seen: Tensor<2>,
}

impl Flights {
    /// Flights that begin at (lesson, frame), where `stood` has the latents of every lesson's frames.
    pub(super) fn new(
        (lessons, stood): (&[&Lesson], &[Vec<Latent>]),
        starts: &[(usize, usize)],
        device: &Device,
    ) -> Self {
        let tensor = |values: Vec<f32>, width: usize| {
            let rows = values.len() / width;
            Tensor::<2>::from_data(TensorData::new(values, [rows, width]), device)
        };
        let row = |k: usize, width: usize, of: &dyn Fn(&Lesson) -> &[f32]| -> Vec<f32> {
            let one = |&(i, n): &(usize, usize)| &of(lessons[i])[(n + k) * width..(n + k + 1) * width];
            starts.iter().flat_map(one).copied().collect()
        };
        let points = |of: &dyn Fn(&Lesson) -> &[f32]| {
            tensor((1..=FLIGHT).flat_map(|k| row(k, POINTS, of)).collect(), POINTS)
        };
        let from = starts.iter().flat_map(|&(i, n)| stood[i][n].iter().map(|&x| x as f32));
        Self {
            from: tensor(from.collect(), LATENTS),
            u: (1..=FLIGHT).map(|k| tensor(row(k, 1, &|l| &l.u), 1)).collect(),
            height: points(&|l| &l.height),
            seen: points(&|l| &l.seen),
        }
    }
}

/// What the losses of one step are made with.
pub(super) struct Student<'a> {
    weights: &'a [Tensor<2>],
    decoded: Decoded,
    operators: Operators,
    frozen: Operators,
}

impl<'a> Student<'a> {
    /// With `weights` (leaves) and with what stays.
    pub(super) fn new(
        weights: &'a [Tensor<2>],
        surface: &Surface,
        preconditioner: &Square,
        device: &Device,
    ) -> Self {
        let operators = Operators::new(&weights[DYNAMICS], preconditioner, device);
        Self { weights, decoded: Decoded::new(surface, device), frozen: operators.frozen(), operators }
    }

    /// < |S(x) - z|^2 >, relative to the mean square height `size`, m2.
    fn miss(&self, x: Tensor<2>, [height, seen]: [&Tensor<2>; 2], size: f32) -> Tensor<1> {
        let points = (x.dims()[0] * POINTS) as f32;
        ((self.decoded.heights(x) - height.clone()) * seen.clone()).square().sum() * (1.0 / (points * size))
    }

    /// The loss of following `batch`.
    pub(super) fn following(&self, batch: &Batch, size: f32) -> Tensor<1> {
        let mut states = gru_layer(batch.hidden.clone(), &self.weights[GRU]);
        let last = states.pop().expect("a window has at least one frame");
        let head = &self.weights[HEAD];
        let y_all = linear(last, &head[0], &head[1]).narrow(1, 0, LATENTS);
        let y = |k: usize| y_all.clone().narrow(0, k * batch.size, batch.size);
        let gain_t = self.weights[GAIN].clone().transpose();
        let mut x = y(0);
        let mut filtered = vec![x.clone()];
        for k in 1..=HORIZON {
            let (predicted, _) = self.operators.turn(x, batch.u[k].clone(), &self.frozen);
            let innovation = (y(k) - predicted.clone()).matmul(gain_t.clone()) * batch.read[k].clone();
            x = predicted + innovation;
            filtered.push(x.clone());
        }
        let truth = [&batch.height, &batch.seen];
        self.miss(Tensor::cat(filtered, 0), truth, size) + self.miss(y_all, truth, size) * 0.5
    }

    /// The loss of foretelling `flights`.
    pub(super) fn foretelling(&self, flights: &Flights, size: f32) -> Tensor<1> {
        let mut f = flights.from.clone();
        let mut all = Vec::with_capacity(FLIGHT);
        for u in &flights.u {
            f = self.operators.turn(f, u.clone(), &self.frozen).0;
            all.push(f.clone());
        }
        self.miss(Tensor::cat(all, 0), [&flights.height, &flights.seen], size)
    }
}
