//! Networks of GENERIC form for any closed system, learnt from its trajectories: exact, soft, and published weights.
//!
//! ```text
//! npz --dataset--> states --form--> what is known --squares--> exact (energy, operators)
//!                                                 --learn----> soft
//!                                   exact, soft, published --judge--> figures --report--> page
//! ```
//! There is no camera, no port and no latent: the network sees the state itself. [`train`] is the entry point. It compares
//! the two forms of GENERIC on data sets that others have published.

mod archive;
mod dataset;
mod energy;
mod exact;
mod form;
mod judge;
mod kinds;
mod learn;
mod operators;
mod published;
mod report;
mod scaling;
mod soft;
mod squares;

pub use archive::DatasetError;
pub use dataset::Dataset;
pub use form::ReversibleOperator;
pub use judge::Figures;
pub use kinds::Kinds;
pub use learn::Schedule;
pub use published::{Published, Said};
pub use report::{checks, markdown, rollouts_png};

use exact::Exact;
use form::Form;
use judge::Judged;
use learn::{Lessons, SoftDescent};
use meniscus_optim::progress::{Checkpoints, Curve, Session};
use meniscus_optim::weights::Matrix;
use nalgebra::DVector;
use safetensors::tensor::{Dtype, TensorView, serialize};
use scaling::Scaling;
use soft::Soft;
use std::sync::atomic::AtomicBool;

/// Of the trajectories that are learnt from, every so manieth is held back to choose by.
const CHOOSING: usize = 8;

/// Networks that a training makes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Networks {
    /// The exact net.
    #[default]
    Exact,
    /// The exact net and, for comparison, the soft one.
    ExactAndSoft,
}

/// Progress bars of a training on the terminal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ProgressBars {
    /// One bar a stage.
    #[default]
    Shown,
    /// No bars.
    Hidden,
}

/// Inputs of a training beside its data.
#[derive(Clone, Debug)]
pub struct Options {
    /// Seed of everything that is drawn.
    pub seed: u64,
    /// Length of the training.
    pub schedule: Schedule,
    /// Kinds of the variables.
    pub kinds: Kinds,
    /// Source of L.
    pub reversible: ReversibleOperator,
    /// Networks to train.
    pub networks: Networks,
    /// Bars on the terminal.
    pub progress: ProgressBars,
    /// Where checkpoints are kept; nowhere if `None`.
    pub checkpoints: Option<Checkpoints>,
}

/// Trained networks and their figures.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The trajectories.
    pub data: Dataset,
    /// Names of the variables.
    pub names: Vec<String>,
    /// Whether each of them moves.
    pub moving: Vec<bool>,
    /// The nets, the published one first, the exact one last.
    pub figures: Vec<Figures>,
    /// Weights of the exact net, by name.
    pub weights: Vec<(&'static str, Matrix)>,
    /// mean and scale of the states: x = (z - mean) / scale.
    pub scaling: [Vec<f64>; 2],
    /// Errors of every stage over its steps.
    pub curves: Vec<Curve>,
}

impl Outcome {
    /// The exact net as a safetensors file: its weights by name, `mean` and `scale` of the states, all float32.
    ///
    /// # Errors
    /// [`safetensors::SafeTensorError`] of the format; with these names there is none.
    pub fn safetensors(&self) -> Result<Vec<u8>, safetensors::SafeTensorError> {
        let row = |v: &Vec<f64>| Matrix::new(1, v.len(), v.iter().map(|&v| v as f32).collect());
        let scaling = ["mean", "scale"].into_iter().zip(self.scaling.iter().map(row));
        let all: Vec<(&str, [usize; 2], Vec<u8>)> = (self.weights.iter().map(|(name, m)| (*name, m.clone())))
            .chain(scaling)
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
    let scaling = Scaling::of(&data, &options.kinds);
    let form = Form::new(&data, &scaling, &options.kinds, options.reversible);
    let lessons = lessons(&data, &scaling);
    let quiet = options.progress == ProgressBars::Hidden;
    let session = Session::new(quiet, stop).kept(options.checkpoints.clone(), fingerprint(&data, options));
    let soft = Soft::new(&form);
    let soft_error = |w: &[Matrix]| lessons.validate(|x, count| soft.roll_out(w, x, count));
    let best = |train: &dyn Fn(u64) -> (Vec<Matrix>, f64)| {
        let tries =
            (0..options.schedule.seeds).map(|k| train(meniscus_optim::seed::derive_seed(options.seed, k)));
        tries.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(weights, _)| weights).unwrap_or_default()
    };
    let weights = best(&|seed| squares::learn(&form, &lessons, seed, options.schedule, &session));
    let soft_descent = |seed| SoftDescent {
        net: &soft,
        lessons: &lessons,
        seed,
        schedule: options.schedule,
        check: &soft_error,
        session: &session,
    };
    let soft_weights =
        (options.networks == Networks::ExactAndSoft).then(|| best(&|seed| soft_descent(seed).learn()));
    let row: Vec<f64> = weights.iter().flat_map(|m| &m.values).map(|&v| f64::from(v)).collect();

    let mut judged: Vec<Judged<'_>> = published.map(Judged::Published).into_iter().collect();
    judged.extend(soft_weights.map(|w| Judged::Soft(&scaling, &soft, w)));
    judged.push(Judged::Exact(&scaling, Box::new(Exact::new(&form, &row))));
    let figures = judged.iter().map(|net| net.figures(&data, &scaling, &options.kinds)).collect();
    let list = |v: &DVector<f64>| v.iter().copied().collect();
    Outcome {
        figures,
        names,
        moving: scaling.moving.clone(),
        weights: named(&form, &row),
        scaling: [list(&scaling.mean), list(&scaling.scale)],
        curves: session.curves(),
        data,
    }
}

/// The exact net's weights by name.
fn named(form: &Form, w: &[f64]) -> Vec<(&'static str, Matrix)> {
    let mut rest = w;
    let take = |(name, rows, columns): (&'static str, usize, usize)| {
        let (own, others) = rest.split_at(rows * columns);
        rest = others;
        (name, Matrix::new(rows, columns, own.iter().map(|&v| v as f32).collect()))
    };
    let logs = ["length.mean", "length.scale"].into_iter().zip(&form.logs);
    let logs = logs.map(|(name, v)| (name, Matrix::new(1, v.len(), v.iter().map(|&v| v as f32).collect())));
    Exact::shapes(form).into_iter().map(take).chain(logs).filter(|(_, m)| !m.values.is_empty()).collect()
}

/// Scaled trajectories, every [`CHOOSING`]th of them to choose by.
fn lessons(data: &Dataset, scaling: &Scaling) -> Lessons {
    let scaled = |&k: &usize| data.paths[k].iter().map(|z| scaling.inward(z)).collect::<Vec<_>>();
    let every = CHOOSING.min(data.training.len());
    let (mut training, mut choosing) = (Vec::new(), Vec::new());
    for (at, k) in data.training.iter().enumerate() {
        if at % every == every - 1 { choosing.push(scaled(k)) } else { training.push(scaled(k)) }
    }
    let root = |squares: Vec<f64>| (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
    let all = || training.iter().map(|path: &Vec<DVector<f64>>| path.as_slice());
    let moved = |i: usize, f: &dyn Fn(usize) -> Vec<f64>| {
        if scaling.moving[i] { root(f(i)).max(f64::MIN_POSITIVE) } else { 1.0 }
    };
    let strides =
        |i: usize| all().flat_map(|p| p.windows(2).map(move |w| (w[1][i] - w[0][i]).powi(2))).collect();
    let spreads = |i: usize| {
        let count = all().map(<[_]>::len).sum::<usize>() as f64;
        let mean = all().flatten().map(|x| x[i]).sum::<f64>() / count;
        all().flatten().map(|x| (x[i] - mean).powi(2)).collect()
    };
    let n = data.variables();
    Lessons {
        stride: (0..n).map(|i| moved(i, &strides)).collect(),
        spread: (0..n).map(|i| moved(i, &spreads)).collect(),
        moves: scaling.moving.clone(),
        training,
        choosing,
    }
}

/// Digest of the data, the seed and the schedule: a checkpoint goes on in the training that wrote it alone.
fn fingerprint(data: &Dataset, options: &Options) -> u32 {
    let mut digest = meniscus::blob::CRC.digest();
    for z in data.paths.iter().flatten() {
        z.iter().for_each(|v| digest.update(&v.to_le_bytes()));
    }
    digest.update(
        format!(
            "closed {} {} {:?} {:?} {}",
            env!("CARGO_PKG_VERSION"),
            options.seed,
            options.schedule,
            options.kinds,
            options.reversible == ReversibleOperator::Learnt
        )
        .as_bytes(),
    );
    digest.finalize()
}
