//! Roll-outs of every net from the first state of each trajectory that judges, and what they do to the laws.

use super::dataset::{Dataset, Frame};
use super::exact::Exact;
use super::published::Published;
use super::unrolled;
use crate::offline::prelude::*;
use crate::offline::train::laws::{Laws, full};
use crate::offline::train::weights::{Matrix, constants, numbers};
use burn::tensor::{Device, Tensor};
use nalgebra::{DMatrix, DVector};

/// A net that is judged.
pub(super) enum Judged<'a> {
    Published(&'a Published),
    Exact(&'a Frame, Exact),
    Soft(&'a Frame, &'a unrolled::Soft, Vec<Matrix>),
}

/// What a net made of the trajectories that judge.
#[derive(Clone, Debug)]
pub struct Figures {
    /// `published`, `soft` or `exact`.
    pub name: &'static str,
    /// Mean square error of each variable over all steps, the first included, in its unit squared.
    pub mse: Vec<f64>,
    /// |z - said| / |z - mean of z| of each variable that moves; NaN of one that does not.
    pub relative: Vec<f64>,
    /// The root mean square of `relative` over the variables that move.
    pub rollout: f64,
    /// The same at every step.
    pub over_time: Vec<f64>,
    /// The roll-outs, `[trajectory][step]`.
    pub paths: Vec<Vec<DVector<f64>>>,
    /// Steps rolled out.
    pub steps: u32,
    /// Steps whose entropy fell.
    pub falls: u32,
    /// Root mean squares of |dE . dz| / (|dE| |dz|), |L dS| / |L dE| and |M dE| / |M dS|.
    pub laws: [f64; 3],
    /// Of the exact net, the largest |E1 - E0| of a step over the spread of H; NaN of others, which have no energy.
    pub drift: f64,
}

impl Judged<'_> {
    fn name(&self) -> &'static str {
        match self {
            Self::Published(_) => "published",
            Self::Exact(..) => "exact",
            Self::Soft(..) => "soft",
        }
    }

    /// `count` states from `state` on; `laws` sees every step, and `books` x, H and s of the exact net.
    fn roll(
        &self,
        state: &DVector<f64>,
        count: usize,
        laws: &mut Laws,
        books: &mut Vec<[f64; 2]>,
    ) -> Vec<DVector<f64>> {
        let slices = |e: &DVector<f64>, s: &DVector<f64>, dz: &DVector<f64>, laws: &mut Laws| {
            laws.step((e.as_slice(), s.as_slice()), dz.as_slice());
        };
        let said =
            |laws: &mut Laws, (l, m): (&DMatrix<f64>, &DMatrix<f64>), e: &DVector<f64>, s: &DVector<f64>| {
                laws.reversible((l * s).norm(), (l * e).norm());
                laws.irreversible((m * e).norm(), (m * s).norm());
            };
        let mut path = vec![state.clone()];
        match self {
            Self::Published(net) => {
                let mut z = net.inward(state);
                while path.len() < count {
                    let step = net.say(&z);
                    slices(&step.energy, &step.entropy, &(&step.next - &z), laws);
                    said(laws, (&net.skew, &net.friction), &step.energy, &step.entropy);
                    z = step.next;
                    path.push(net.outward(&z));
                }
            }
            Self::Soft(frame, net, weights) => {
                let device = Device::flex();
                let tensors = constants(weights, &device);
                let vector =
                    |t: Tensor<2>| DVector::from_iterator(state.len(), numbers(t).into_iter().map(f64::from));
                let n = state.len();
                let matrix =
                    |t: Tensor<3>| DMatrix::from_row_iterator(n, n, numbers(t).into_iter().map(f64::from));
                let mut x = frame.inward(state);
                while path.len() < count {
                    let row = Matrix::new(1, n, x.iter().map(|&v| v as f32).collect()).tensor(&device);
                    let ([e, s], [l, m]) = net.say(&tensors, row);
                    let (e, s, l, m) = (vector(e), vector(s), matrix(l), matrix(m));
                    let step = &l * &e + &m * &s;
                    slices(&e, &s, &step, laws);
                    said(laws, (&l, &m), &e, &s);
                    x += step;
                    path.push(frame.outward(&x));
                }
            }
            Self::Exact(frame, net) => {
                let (mut x, mut s) = (frame.inward(state), 0.0);
                books.push([net.energy(&x), s]);
                while path.len() < count {
                    let turn = net.turn(&x);
                    let [l, m] = full(&turn.skew, &turn.friction, &turn.gradient);
                    let n = x.len();
                    let one = |last: f64, g: &DVector<f64>| g.clone().insert_row(n, last);
                    let (de, ds) = (one(1.0, &turn.gradient), one(1.0, &(&turn.gradient * 0.0)));
                    slices(&de, &ds, &one(turn.heat, &(&turn.x - &x)), laws);
                    said(laws, (&l, &m), &de, &ds);
                    (x, s) = (turn.x, s + turn.heat);
                    books.push([net.energy(&x), s]);
                    path.push(frame.outward(&x));
                }
            }
        }
        path
    }

    /// Rolls out from the first state of every trajectory of `data` that judges.
    pub(super) fn figures(&self, data: &Dataset, frame: &Frame) -> Figures {
        let (mut laws, mut drift, mut spread) = (Laws::default(), 0.0_f64, 0.0_f64);
        let mut paths = Vec::new();
        for &k in &data.test {
            let truth = &data.paths[k];
            let mut books = Vec::new();
            paths.push(self.roll(&truth[0], truth.len(), &mut laws, &mut books));
            let first = books.first().map_or(0.0, |b| b[0]);
            spread = books.iter().map(|b| (b[0] - first).abs()).fold(spread, f64::max);
            let change = |pair: &[[f64; 2]]| ((pair[1][0] + pair[1][1]) - (pair[0][0] + pair[0][1])).abs();
            drift = books.windows(2).map(change).fold(drift, f64::max);
        }
        let drift = if spread > 0.0 { drift / spread } else { f64::NAN };
        let truth: Vec<&[DVector<f64>]> = data.test.iter().map(|&k| data.paths[k].as_slice()).collect();
        let square = square_errors(&truth, &paths);
        let count = (truth.len() * truth[0].len()) as f64;
        let mean = truth.iter().copied().flatten().fold(&truth[0][0] * 0.0, |sum, z| sum + z) / count;
        let variance =
            truth.iter().copied().flatten().fold(&mean * 0.0, |sum, z| sum + (z - &mean).map(|d| d * d))
                / count;
        let mse = square.iter().fold(&mean * 0.0, |sum, s| sum + s) / square.len() as f64;
        let part = |errors: &DVector<f64>| {
            let all = (0..errors.len()).filter(|&i| frame.moving[i]).map(|i| errors[i] / variance[i]);
            (all.clone().sum::<f64>() / all.count().max(1) as f64).sqrt()
        };
        let relative = (0..mse.len())
            .map(|i| if frame.moving[i] { (mse[i] / variance[i]).sqrt() } else { f64::NAN })
            .collect();
        Figures {
            name: self.name(),
            rollout: part(&mse),
            over_time: square.iter().map(part).collect(),
            mse: mse.iter().copied().collect(),
            relative,
            paths,
            steps: laws.steps(),
            falls: laws.falls(),
            laws: laws.figures(),
            drift,
        }
    }
}

/// Mean over the trajectories of the square error of each variable, at every step.
fn square_errors(truth: &[&[DVector<f64>]], said: &[Vec<DVector<f64>>]) -> Vec<DVector<f64>> {
    (0..truth[0].len())
        .map(|step| {
            let all = truth.iter().zip(said).map(|(z, y)| (&z[step] - &y[step]).map(|d| d * d));
            all.fold(&truth[0][0] * 0.0, |sum, d| sum + d) / truth.len() as f64
        })
        .collect()
}
