//! From recordings to a weight blob.
//!
//! ```text
//! recordings --dataset, pod--> coefficients --autoencoder--> latents --warm, rollout--> dynamics --.
//!                                                               '--noise, encoder--> encoder ------+--filter--> gain --> blob
//! ```
//!
//! Networks train through burn (`nets`, `weights`); operators are fitted and judged in double precision
//! (`generic`, `warm`, `filter`).

mod calibration;
pub mod correct;
mod data;
mod error;
pub mod evaluate;
mod learning_curves;
mod networks;
mod operators;
pub mod seeds;

pub use error::TrainError;
pub use learning_curves::curves_png;

use crate::calibration::error_model::{self as spread, Spread};
use crate::calibration::{blob_parts as parts, intervals as calibrate, measure, validation_report as report};
use crate::data::dataset::Frame;
use crate::networks::autoencoder::Autoencoder;
use crate::networks::encoded::Side;
use crate::networks::encoder::{Cost, Encoder};
use crate::networks::heat::Heat;
use crate::networks::noise::Noise;
use crate::networks::sparse::Sparse;
use crate::operators::linear::Linear;
use crate::operators::reference_step::{Dynamics, Square};
use crate::operators::soft::Soft;
use crate::operators::{filter, precondition, rollout, unrolled, warm};
use meniscus::blob::{Header, Tensor};
use meniscus::uncertainty::error_model::REACH;
use meniscus::units::FRAME_INTERVAL_S;

use meniscus_data::blob_file::{
    read,
    write::{self, Part},
};
use meniscus_data::recording::Recording;
use meniscus_optim::progress::{Checkpoints, Curve, Session};
use meniscus_optim::seed::derive_seed;
use meniscus_platform::files::AlignedBytes;
use meniscus_report::checks::Check;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::sync::atomic::AtomicBool;

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
    /// Some six minutes on two cores.
    pub const FULL: Self = Self { autoencoder: 4000, encoder: 300, rollout: 3000, seeds: 2 };

    /// Under a minute on two cores.
    pub const QUICK: Self = Self { autoencoder: 2000, encoder: 60, rollout: 400, seeds: 1 };
}

/// What to train and how.
#[derive(Clone, Debug)]
pub struct Options {
    /// Seed of everything that is drawn.
    pub seed: u64,
    /// How long.
    pub schedule: Schedule,
    /// Whether the paper's soft net is trained beside the exact step, to compare; it is not in the blob.
    pub soft: bool,
    /// Whether the paper's five sparse autoencoders are trained beside the joint one, to compare; they are not in
    /// the blob.
    pub sparse: bool,
    /// No bars.
    pub quiet: bool,
    /// The command, for the blob's provenance.
    pub command: String,
    /// Where checkpoints are kept; nowhere if `None`.
    pub checkpoints: Option<Checkpoints>,
}

/// Asked of the estimate, per cent: q, v, sigma, tau, surface.
const ASKED: [Option<f64>; 5] = [Some(12.0), Some(12.0), Some(15.0), Some(15.0), Some(12.0)];

/// Everything that has been learnt.
#[derive(Debug)]
struct Model {
    frame: Frame,
    autoencoder: Autoencoder,
    heat: Heat,
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
    /// How every stage learnt.
    pub curves: Vec<Curve>,
    /// Slosh-relative error of the filtered surface on the validation recordings: what a choice among seeds goes by.
    pub slosh_rel: f64,
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
    let session = Session::new(options.quiet, stop)
        .kept(options.checkpoints.clone(), fingerprint(training, validation, options));
    let seed = |stage| derive_seed(options.seed, stage);
    let mut frame = Frame::new(training)?;
    let project = |all: &[Recording]| all.iter().map(|r| frame.project(r)).collect::<Vec<_>>();
    let (mut seen, mut held) = (project(training), project(validation));
    frame.measure_feed(&seen)?;
    seen.iter_mut().chain(&mut held).for_each(|sequence| frame.take_out_feed(sequence));
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
    let start = warm::start(&linear, &seen.paths, &metric, &mut rng)?;

    // From here on the latents are K x: H starts as |x|^2 / 2 and all entries of L and D are rates. Training
    // is well scaled so, and the discrete gradient, whose correction depends on the coordinates, is mild.
    let energetic = TrainError::Singular("coordinates of energy");
    let (forth, back) = (start.linear, start.linear.try_inverse().ok_or(energetic.clone())?);
    let start = start.changed(&forth).ok_or(energetic)?;
    let (autoencoder, linear) = (autoencoder.mapped(&forth, &back), linear.mapped(&forth, &back));
    let metric = metric * back;
    let cost = Cost { metric, port: frame.feed_cost() };
    let anew = |side: Side| Side::new(side.sequences, &autoencoder, &frame);
    let (seen, held) = (anew(seen), anew(held));
    let heat = Heat::fit(training, &seen);

    // The stages need nothing of each other, and none gains from a second core.
    let (encoder, dynamics) = std::thread::scope(|scope| {
        let plan = (options.schedule.encoder, seed(2));
        let (seen, held, session, start) = (&seen, &held, &session, &start);
        let (frame, cost, metric) = (&frame, &cost, &metric);
        let encoder =
            scope.spawn(move || Encoder::train(frame, &seen.lessons(), &held.lessons(), cost, plan, session));
        let paths = (seen.paths.as_slice(), held.paths.as_slice());
        let tries: Vec<_> = (0..options.schedule.seeds)
            .map(|k| (options.schedule.rollout, seed(8 + k)))
            .map(|plan| scope.spawn(move || rollout::train(start, paths, metric, plan, session)))
            .collect();
        let tries = tries.into_iter().map(|thread| thread.join().expect("a roll-out's thread ends"));
        let best = tries.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(start.clone(), |(dynamics, _)| dynamics);
        (encoder.join().expect("the encoder's thread ends"), best)
    });
    let dynamics = unrolled::rounded(&dynamics);
    let preconditioner = precondition::best(&dynamics, &seen.paths);
    // The encoder is too good on what it was trained on, so the validation recordings are seen as often.
    let mut tracks = seen.tracks(&frame, &encoder, Noise::CAMERA, &mut rng);
    let passes = tracks.len().div_ceil(held.sequences.len());
    tracks.extend((0..passes).flat_map(|_| held.tracks(&frame, &encoder, Noise::CAMERA, &mut rng)));
    let gain = filter::tune(&dynamics, &tracks, &metric)?;

    let model = Model { frame, autoencoder, heat, encoder, dynamics, linear, preconditioner, gain };
    let spread = Spread::new(&model, &tracks, &held, &metric);
    // Fresh noise: the gain has seen the other.
    let tracks = held.tracks(&model.frame, &model.encoder, Noise::CAMERA, &mut rng);
    let soft = options.soft.then(|| {
        let (paths, plan) =
            ((seen.paths.as_slice(), held.paths.as_slice()), (options.schedule.rollout, seed(5)));
        Soft::train(&model.dynamics, paths, &metric, plan, &session)
    });
    let sparse = options.sparse.then(|| {
        let (recordings, sequences) = ((training, validation), (&*seen.sequences, &*held.sequences));
        Sparse::train(&model.frame, recordings, sequences, (options.schedule.autoencoder, seed(6)), &session)
    });
    let mut checks = report::checks(&model, &held, &tracks);
    checks.push(measure::percent(
        String::from("decoder alone: e"),
        model.heat.missed(validation, &held),
        None,
    ));
    let header = Header {
        liquid: fit(&first.provenance.liquid),
        provenance: fit(&options.command),
        particles: meniscus_data::recording::TRACERS as u32,
        dt_s: FRAME_INTERVAL_S,
        radius_m: first.glass.radius_m,
        fill_m: first.glass.fill_m,
        rim_m: first.glass.rim_m,
        height_scale_m: model.frame.height_scale_m,
        acceleration_scale: model.frame.acceleration_scale,
        energy_scale_j: model.frame.energy_scale_j,
        validation_slosh_rel: 0.0,
        sections: heapless::Vec::new(),
        named: None,
    };
    let parts = [parts::parts(&model), spread.parts(&spread::UNIT)].concat();
    let finished = finish(header, parts, validation, options.seed)?;
    checks.extend(soft.iter().flat_map(|soft| soft.checks(&model.dynamics, &held.paths, &metric)));
    checks.extend(sparse.iter().flat_map(|five| five.checks(&model.frame, validation, &held.sequences)));
    checks.extend(finished.checks);
    Ok(Trained { curves: session.curves(), checks, ..finished })
}

/// `blob` with its intervals, and what it says of its own error, measured again on `validation`; the weights stay. For
/// when what estimates are made by has changed, or there are recordings that tell more.
///
/// # Errors
/// [`TrainError`], when the blob is refused or a recording cannot be looked at.
pub fn measured_again(blob: &[u8], validation: &[Recording], seed: u64) -> Result<Trained, TrainError> {
    if validation.is_empty() {
        return Err(TrainError::NoRecording);
    }
    let (header, mut parts) = read::parts(&AlignedBytes::copy(blob))?;
    for part in parts.iter_mut().filter(|part| part.tensor == Tensor::Reach) {
        // The first number is the floor of w; g comes behind the factors.
        part.values.truncate(1);
        part.values.extend(spread::UNIT);
        part.values.push(0.0);
        part.rows = part.values.len();
    }
    finish(header, parts, validation, seed)
}

/// The blob of `parts`, whose k are all one and g none, with its error and its intervals as the recordings of `validation` tell them
/// behind the rendered camera.
fn finish(
    mut header: Header,
    mut parts: Vec<Part>,
    validation: &[Recording],
    seed: u64,
) -> Result<Trained, TrainError> {
    let looks = |times, stage| calibrate::looks(validation, times, derive_seed(seed, stage));
    // One draw of the noise makes the factors, another tells what they hold and what the errors are.
    let (measured, judged) = (looks(1.0, 3)?, looks(1.0, 4)?);
    let unit = write::blob(header.clone(), &parts)?;
    let asked = ("estimate, camera noise", ASKED);
    let (mut checks, slosh_rel) = calibrate::errors(&unit, &judged, asked)?;
    let worse = ("estimate, three times the noise", [None; 5]);
    checks.extend(calibrate::errors(&unit, &looks(3.0, 4)?, worse)?.0);
    let grain = calibrate::grain(&unit, &measured)?;
    for part in parts.iter_mut().filter(|part| part.tensor == Tensor::Reach) {
        part.values.iter_mut().skip(REACH).for_each(|g| *g = grain);
    }
    let unit = write::blob(header.clone(), &parts)?;
    let calibrate::Reach { k: reach, left_out } = calibrate::reach(&unit, &measured)?;
    for part in parts.iter_mut().filter(|part| part.tensor == Tensor::Reach) {
        part.values.iter_mut().skip(1).zip(reach).for_each(|(k, reach)| *k = reach);
    }
    checks.push(Check::told("interval: rest missed by", 1e3 * f64::from(grain), "mm"));
    checks.extend(left_out);
    header.validation_slosh_rel = slosh_rel as f32;
    let blob = write::blob(header, &parts)?;
    checks.extend(calibrate::held(&blob, &judged)?);
    Ok(Trained { blob, checks, curves: Vec::new(), slosh_rel })
}

/// What tells a training from another: its data, its seed and its schedule.
fn fingerprint(training: &[Recording], validation: &[Recording], options: &Options) -> u32 {
    let mut digest = meniscus::blob::CRC.digest();
    for recording in training.iter().chain(validation) {
        recording.profile_m.iter().for_each(|height| digest.update(&height.to_le_bytes()));
    }
    digest
        .update(format!("{} {} {:?}", env!("CARGO_PKG_VERSION"), options.seed, options.schedule).as_bytes());
    digest.finalize()
}

/// As much of `text` as fits.
fn fit<const N: usize>(text: &str) -> heapless::String<N> {
    let mut short = heapless::String::new();
    // The first character that does not fit ends it.
    let _ = text.chars().try_for_each(|c| short.push(c));
    short
}
