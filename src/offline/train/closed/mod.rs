//! Any closed system from its trajectories: the exact net and the soft one, beside a published net's weights.
//!
//! ```text
//! npz --dataset--> states --form--> what is known (L, friction) --learn(unrolled)--> weights
//!                                                     exact, soft, published --judge--> figures --report--> page
//! ```
//! This is the trainer of the glass without the glass: no camera, no port, the state itself in place of latents. It
//! holds the two forms of GENERIC against each other on data that others have published.

mod dataset;
mod exact;
mod form;
mod judge;
mod learn;
mod published;
mod report;
mod unrolled;

pub use dataset::{Dataset, DatasetError};
pub use judge::Figures;
pub use learn::Schedule;
pub use published::{Published, Said};
pub use report::{checks, markdown, rollouts_png};

use super::progress::{Checkpoints, Curve, Session};
use super::weights::Matrix;
use crate::offline::prelude::*;
use dataset::Frame;
use form::Form;
use judge::Judged;
use learn::{Lessons, learn};
use nalgebra::DVector;
use safetensors::tensor::{Dtype, TensorView, serialize};
use std::sync::atomic::AtomicBool;
use unrolled::Net;

/// Of the trajectories that are learnt from, every so manieth is held back to choose by.
const CHOOSING: usize = 8;

/// What to train and how.
#[derive(Clone, Debug)]
pub struct Options {
    /// Seed of everything that is drawn.
    pub seed: u64,
    /// How long.
    pub schedule: Schedule,
    /// Whether the soft net is trained too.
    pub soft: bool,
    /// No bars.
    pub quiet: bool,
    /// Where checkpoints are kept; nowhere if `None`.
    pub checkpoints: Option<Checkpoints>,
}

/// What came out.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The trajectories.
    pub data: Dataset,
    /// Names of the variables.
    pub names: Vec<String>,
    /// Which of them move.
    pub moving: Vec<bool>,
    /// The nets, the published one first, the exact one last.
    pub figures: Vec<Figures>,
    /// Weights of the exact net, by name.
    pub weights: Vec<(&'static str, Matrix)>,
    /// mean and scale of the states: x = (z - mean) / scale.
    pub frame: [Vec<f64>; 2],
    /// How the stages learnt.
    pub curves: Vec<Curve>,
}

/// Names of the exact net's weights, in their order.
const NAMES: [&str; 14] = [
    "H.K", "H.h", "H.W1", "H.b1", "H.W2", "H.b2", "H.w", "L.lower", "C.lower", "LC.V1", "LC.c1", "LC.V2",
    "LC.c2", "LC.V3",
];

impl Outcome {
    /// The exact net as a safetensors file: its weights by name, `mean` and `scale` of the states, all float32.
    ///
    /// # Errors
    /// What the format says; with names as they are it does not.
    pub fn safetensors(&self) -> Result<Vec<u8>, safetensors::SafeTensorError> {
        let row = |v: &Vec<f64>| Matrix::new(1, v.len(), v.iter().map(|&v| v as f32).collect());
        let frame = ["mean", "scale"].into_iter().zip(self.frame.iter().map(row));
        let all: Vec<(&str, [usize; 2], Vec<u8>)> = (self.weights.iter().map(|(name, m)| (*name, m.clone())))
            .chain(frame)
            .map(|(name, m)| {
                (name, [m.rows, m.columns], m.values.iter().flat_map(|v| v.to_le_bytes()).collect())
            })
            .collect();
        let views = all
            .iter()
            .map(|(name, shape, bytes)| Ok((*name, TensorView::new(Dtype::F32, shape.to_vec(), bytes)?)));
        serialize(views.collect::<Result<Vec<_>, safetensors::SafeTensorError>>()?, None)
    }

    /// The figures of the net `name`.
    #[must_use]
    pub fn of(&self, name: &str) -> Option<&Figures> {
        self.figures.iter().find(|figures| figures.name == name)
    }
}

/// Trains on `data` and judges, beside `published`. When `stop` is raised every stage ends with its best so far.
#[must_use]
pub fn train(
    data: Dataset,
    names: Vec<String>,
    published: Option<&Published>,
    options: &Options,
    stop: &AtomicBool,
) -> Outcome {
    let frame = Frame::of(&data);
    let form = Form::new(&data, &frame);
    let lessons = lessons(&data, &frame);
    let session =
        Session::new(options.quiet, stop).kept(options.checkpoints.clone(), fingerprint(&data, options));
    let (exact, soft) = (unrolled::Exact::new(&form), unrolled::Soft::new(&form));
    let exact_error = |w: &[Matrix]| {
        let net = exact::Exact::new(&form, w);
        lessons.validate(|x, count| net.roll_out(x, count))
    };
    let soft_error = |w: &[Matrix]| lessons.validate(|x, count| soft.roll_out(w, x, count));
    let best = |net: &dyn Net, name: &'static str, check: &(dyn Fn(&[Matrix]) -> f64 + Sync)| {
        let tries: Vec<_> = std::thread::scope(|scope| {
            let all: Vec<_> = (0..options.schedule.seeds)
                .map(|k| (name, super::encoder::derive_seed(options.seed, k)))
                .map(|plan| {
                    let (lessons, session) = (&lessons, &session);
                    scope.spawn(move || learn(net, lessons, plan, options.schedule, &check, session))
                })
                .collect();
            all.into_iter().map(|thread| thread.join().expect("a training's thread ends")).collect()
        });
        tries.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).map(|(weights, _)| weights).unwrap_or_default()
    };
    let weights = best(&exact, "exact", &exact_error);
    let soft_weights = options.soft.then(|| best(&soft, "soft", &soft_error));

    let mut judged: Vec<Judged<'_>> = published.map(Judged::Published).into_iter().collect();
    judged.extend(soft_weights.map(|w| Judged::Soft(&frame, &soft, w)));
    judged.push(Judged::Exact(&frame, exact::Exact::new(&form, &weights)));
    let figures = judged.iter().map(|net| net.figures(&data, &frame)).collect();
    let list = |v: &DVector<f64>| v.iter().copied().collect();
    Outcome {
        figures,
        names,
        moving: frame.moving.clone(),
        weights: NAMES.into_iter().zip(weights).collect(),
        frame: [list(&frame.mean), list(&frame.scale)],
        curves: session.curves(),
        data,
    }
}

/// Scaled trajectories, every [`CHOOSING`]th of them to choose by.
fn lessons(data: &Dataset, frame: &Frame) -> Lessons {
    let scaled = |&k: &usize| data.paths[k].iter().map(|z| frame.inward(z)).collect::<Vec<_>>();
    let every = CHOOSING.min(data.training.len());
    let (mut training, mut choosing) = (Vec::new(), Vec::new());
    for (at, k) in data.training.iter().enumerate() {
        if at % every == every - 1 { choosing.push(scaled(k)) } else { training.push(scaled(k)) }
    }
    let pairs = || training.iter().flat_map(|path: &Vec<DVector<f64>>| path.windows(2));
    let square = |i: usize| pairs().map(|pair| (pair[1][i] - pair[0][i]).powi(2)).sum::<f64>();
    let count = pairs().count().max(1) as f64;
    let stride = (0..data.variables())
        .map(|i| if frame.moving[i] { (square(i) / count).sqrt() } else { 1.0 })
        .collect();
    Lessons { training, choosing, stride }
}

/// What tells a training from another: its data, its seed and its schedule.
fn fingerprint(data: &Dataset, options: &Options) -> u32 {
    let mut digest = crate::model::CRC.digest();
    for z in data.paths.iter().flatten() {
        z.iter().for_each(|v| digest.update(&v.to_le_bytes()));
    }
    digest.update(
        format!("closed {} {} {:?}", env!("CARGO_PKG_VERSION"), options.seed, options.schedule).as_bytes(),
    );
    digest.finalize()
}
