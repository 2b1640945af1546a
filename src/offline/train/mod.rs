//! From recordings to a weight blob.
//!
//! ```text
//! recordings --dataset, pod--> coefficients --autoencoder--> latents --warm, rollout--> dynamics --.
//!                                                               '--noise, encoder--> encoder ------+--filter--> gain --> blob
//! ```
//!
//! Networks train through burn (`nets`, `weights`); operators are fitted and judged in double precision
//! (`generic`, `warm`, `filter`).

mod autoencoder;
mod dataset;
mod encoder;
mod filter;
mod generic;
mod measure;
pub mod nets;
mod noise;
mod parts;
mod pod;
mod progress;
mod report;
mod rollout;
mod warm;
pub mod weights;

pub use measure::Check;

use super::export::{self, ExportError};
use super::recording::Recording;
use crate::model::Header;
use crate::offline::prelude::*;
use crate::units::FRAME_INTERVAL_S;
use autoencoder::Autoencoder;
use dataset::{Frame, Sequence};
use encoder::{Encoder, Lesson, derive_seed};
use filter::Track;
use generic::{Dynamics, Latent, Square};
use noise::{Noise, Seen};
use progress::Session;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::sync::atomic::AtomicBool;
use warm::{Linear, Path};

/// Why there is no model.
#[derive(Clone, Debug)]
pub enum TrainError {
    /// Training and validation each need at least one recording.
    NoRecording,
    /// Nothing moves in the training recordings: they must contain a slosh.
    NoMotion,
    /// The recordings do not determine the named step: record more, and different, motions.
    Singular(&'static str),
    /// Stopped before every part had been trained once: nothing was written.
    Interrupted,
    /// The blob could not be made.
    Export(ExportError),
}

impl std::fmt::Display for TrainError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoRecording => write!(f, "training and validation each need at least one recording"),
            Self::NoMotion => write!(f, "nothing moves in the training recordings: they must contain a slosh"),
            Self::Singular(step) => {
                write!(f, "the recordings do not determine {step}: record more, and different, motions")
            }
            Self::Interrupted => write!(f, "stopped before every part had been trained once: nothing was written"),
            Self::Export(error) => write!(f, "{error}"),
        }
    }
}

impl std::error::Error for TrainError {}

impl From<ExportError> for TrainError {
    fn from(error: ExportError) -> Self {
        Self::Export(error)
    }
}

/// How long to train.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Schedule {
    /// Steps of the autoencoder, 256 snapshots each.
    pub autoencoder: usize,
    /// Passes of the encoder over all windows.
    pub encoder: usize,
    /// Steps of one roll-out training, 128 roll-outs each.
    pub rollout: usize,
    /// Roll-out trainings from different seeds; the best on the validation recordings stays.
    pub seeds: u64,
}

impl Schedule {
    /// A quarter of an hour on two cores.
    pub const FULL: Self = Self { autoencoder: 12_000, encoder: 300, rollout: 1500, seeds: 3 };

    /// Under three minutes on two cores.
    pub const QUICK: Self = Self { autoencoder: 3000, encoder: 60, rollout: 300, seeds: 1 };
}

/// What to train and how.
#[derive(Clone, Debug)]
pub struct Options {
    /// Seed of everything that is drawn.
    pub seed: u64,
    /// How long.
    pub schedule: Schedule,
    /// No bars.
    pub quiet: bool,
    /// The command, for the blob's provenance.
    pub command: String,
}

/// Everything that has been learnt.
#[derive(Debug)]
struct Model {
    frame: Frame,
    autoencoder: Autoencoder,
    encoder: Encoder,
    dynamics: Dynamics,
    linear: Linear,
    preconditioner: Square,
    gain: Square,
}

/// A blob and what is known of it.
#[derive(Clone, Debug)]
pub struct Trained {
    /// The bytes of the blob.
    pub blob: Vec<u8>,
    /// Figures on the validation recordings.
    pub checks: Vec<Check>,
}

/// One side of the split, as the stages need it.
struct Side {
    sequences: Vec<Sequence>,
    latents: Vec<Vec<Latent>>,
    paths: Vec<Path>,
}

impl Side {
    fn new(sequences: Vec<Sequence>, autoencoder: &Autoencoder, frame: &Frame) -> Self {
        let latents: Vec<_> = sequences.iter().map(|s| autoencoder.encode(s, frame)).collect();
        let path = |(s, x): (&Sequence, &Vec<Latent>)| {
            let scale = f64::from(frame.acceleration_scale);
            let u = dataset::known_acceleration(&s.glass_x_m).iter().map(|a| a / scale).collect();
            let of_scale = |joules: &[f64]| joules.iter().map(|e| e / frame.energy_scale_j).collect();
            Path { x: x.clone(), u, energy: of_scale(&s.energy_j), heat: of_scale(&s.heat_j) }
        };
        let paths = sequences.iter().zip(&latents).map(path).collect();
        Self { sequences, latents, paths }
    }

    fn lessons(&self) -> Vec<Lesson<'_>> {
        let lesson = |(sequence, latents)| Lesson { sequence, latents };
        self.sequences.iter().zip(self.latents.iter().map(Vec::as_slice)).map(lesson).collect()
    }

    /// What the camera and the encoder make of every sequence.
    fn tracks(&self, frame: &Frame, encoder: &Encoder, rng: &mut ChaCha8Rng) -> Vec<Track> {
        let track = |(sequence, truth): (&Sequence, &Vec<Latent>)| {
            let seen = Seen::new(sequence, frame, Some(Noise::CAMERA), rng);
            let u = (0..sequence.frames()).map(|n| seen.port(n)).collect();
            Track { y: encoder.read(&seen), u, truth: truth.clone() }
        };
        self.sequences.iter().zip(&self.latents).map(track).collect()
    }
}

/// Trains on `training`, chooses by `validation`, and writes the blob in memory. When `stop` is
/// raised every stage ends early with its best so far.
///
/// # Errors
/// [`TrainError`], when the recordings do not suffice or a stage was stopped before it had begun.
pub fn train(
    training: &[Recording],
    validation: &[Recording],
    options: &Options,
    stop: &AtomicBool,
) -> Result<Trained, TrainError> {
    let first = training.first().ok_or(TrainError::NoRecording)?;
    if validation.is_empty() {
        return Err(TrainError::NoRecording);
    }
    let session = Session::new(options.quiet, stop);
    let seed = |stage| derive_seed(options.seed, stage);
    let mut frame = Frame::new(training)?;
    let project = |all: &[Recording]| all.iter().map(|r| frame.project(r)).collect::<Vec<_>>();
    let (seen, held) = (project(training), project(validation));
    frame.measure_scales(&seen);

    let autoencoder =
        Autoencoder::train(&frame, &seen, &held, options.schedule.autoencoder, seed(0), &session);
    if session.stopped() {
        return Err(TrainError::Interrupted);
    }
    let autoencoder = autoencoder.whitened(&seen, &frame);
    let metric = autoencoder.metric();
    let (seen, held) = (Side::new(seen, &autoencoder, &frame), Side::new(held, &autoencoder, &frame));
    let linear = Linear::fit(&seen.paths, &metric)?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed(1));
    let start = warm::start(&linear, &seen.paths, &mut rng)?;

    // The two need nothing of each other, and neither gains from a second core.
    let (encoder, dynamics) = std::thread::scope(|scope| {
        let plan = (options.schedule.encoder, seed(2));
        let (seen, held, session, shared) = (&seen, &held, &session, (&frame, &metric));
        let encoder =
            scope.spawn(move || Encoder::train(shared.0, &seen.lessons(), &held.lessons(), shared.1, plan, session));
        let paths = (seen.paths.as_slice(), held.paths.as_slice());
        let tries = (0..options.schedule.seeds)
            .map(|k| rollout::train(&start, paths, &metric, (options.schedule.rollout, seed(8 + k)), session));
        let best = tries.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(start.clone(), |(dynamics, _)| dynamics);
        (encoder.join().expect("the encoder's thread ends"), best)
    });
    let dynamics = rollout::rounded(&dynamics);
    let preconditioner = dynamics.typical_preconditioner(seen.latents.iter().flatten());
    let mut tracks = seen.tracks(&frame, &encoder, &mut rng);
    tracks.extend(held.tracks(&frame, &encoder, &mut rng));
    let gain = filter::tune(&dynamics, &tracks)?;

    let model = Model { frame, autoencoder, encoder, dynamics, linear, preconditioner, gain };
    // Fresh noise: the gain has seen the other.
    let tracks = held.tracks(&model.frame, &model.encoder, &mut rng);
    let (checks, slosh_rel) = report::checks(&model, &held, &tracks);
    let header = Header {
        liquid: fit(&first.provenance.liquid),
        provenance: fit(&options.command),
        particles: super::recording::TRACERS as u32,
        dt_s: FRAME_INTERVAL_S,
        radius_m: first.glass.radius_m,
        fill_m: first.glass.fill_m,
        rim_m: first.glass.rim_m,
        height_scale_m: model.frame.height_scale_m,
        acceleration_scale: model.frame.acceleration_scale,
        energy_scale_j: model.frame.energy_scale_j,
        validation_slosh_rel: slosh_rel as f32,
        sections: heapless::Vec::new(),
    };
    Ok(Trained { blob: export::blob(header, &parts::parts(&model))?, checks })
}

/// As much of `text` as fits.
fn fit<const N: usize>(text: &str) -> heapless::String<N> {
    let mut short = heapless::String::new();
    // The first character that does not fit ends it.
    let _ = text.chars().try_for_each(|c| short.push(c));
    short
}
