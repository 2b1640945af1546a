//! Stages of the training, one method each.

use super::Options;
use crate::TrainError;
use crate::calibration::blob_parts;
use crate::calibration::error_model::MeasuredErrors;
use crate::calibration::learnt_model::LearntModel;
use crate::data::dataset::{Frame, Sequence};
use crate::data::feed;
use crate::networks::autoencoder::Autoencoder;
use crate::networks::base::{Base, BaseWeights};
use crate::networks::encoded::EncodedRecordings;
use crate::networks::encoder::{Cost, Encoder};
use crate::networks::heat::Heat;
use crate::networks::noise::Noise;
use crate::operators::linear::Linear;
use crate::operators::open_loop::validate;
use crate::operators::reference_step::{Dynamics, Square};
use crate::operators::{filter, friction_law, precondition, rollout, unrolled, warm};
use crate::stage::{Stage, StageRun, TrainingSplit};
use meniscus_data::blob_file::write::Part;
use meniscus_data::recording::Recording;
use meniscus_optim::progress::Session;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::sync::atomic::AtomicBool;

/// Recordings, options and session of one training.
pub(super) struct Pipeline<'a> {
    pub(super) training: &'a [Recording],
    pub(super) validation: &'a [Recording],
    pub(super) options: &'a Options,
    pub(super) session: Session<'a>,
    base: Option<BaseWeights>,
}

/// Recordings projected on the bases of the training recordings.
pub(super) struct Projected {
    frame: Frame,
    training: Vec<Sequence>,
    validation: Vec<Sequence>,
}

/// Recordings in the coordinates of energy, with the operators that start there.
pub(super) struct LatentRecordings {
    frame: Frame,
    autoencoder: Autoencoder,
    heat: Heat,
    linear: Linear,
    start: Dynamics,
    metric: Square,
    training: EncodedRecordings,
    validation: EncodedRecordings,
    /// Error of the roll-outs of `start` on the validation recordings.
    start_error: f64,
}

/// Learnt model with the error model of its filter, and the recordings that both are judged on.
pub(super) struct Filtered {
    /// Everything that has been learnt.
    pub(super) model: LearntModel,
    /// Cost of an error of the latents.
    pub(super) metric: Square,
    /// Validation recordings in the latents.
    pub(super) validation: EncodedRecordings,
    /// Training recordings in the latents.
    pub(super) training: EncodedRecordings,
    /// Error of the roll-outs of the warm start on the validation recordings.
    pub(super) start_error: f64,
    errors: MeasuredErrors,
}

impl Filtered {
    /// Tensors of the blob, not calibrated.
    pub(super) fn blob_parts(&self) -> Vec<Part> {
        [blob_parts::parts(&self.model), self.errors.parts()].concat()
    }
}

impl<'a> Pipeline<'a> {
    /// Pipeline of `options` over the recordings.
    ///
    /// # Errors
    /// [`TrainError::NoRecording`], when one of the two sets is empty, or [`TrainError::Blob`], when the base is refused.
    pub(super) fn new(
        training: &'a [Recording],
        validation: &'a [Recording],
        options: &'a Options,
        stop: &'a AtomicBool,
    ) -> Result<Self, TrainError> {
        if training.is_empty() || validation.is_empty() {
            return Err(TrainError::NoRecording);
        }
        let session = Session::new(options.quiet, stop)
            .kept(options.checkpoints.clone(), fingerprint(training, validation, options));
        let base = BaseWeights::new(&options.base)?;
        Ok(Self { training, validation, options, session, base })
    }

    /// Steps, seed and session of `stage`.
    pub(super) fn run(&self, stage: Stage, steps: usize) -> StageRun<'_> {
        StageRun { steps, seed: stage.seed(self.options.seed), session: &self.session }
    }

    /// Random numbers of the warm start, which go on through the camera noise of the filter and of its check.
    pub(super) fn warm_start_draws(&self) -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(Stage::WarmStart.seed(self.options.seed))
    }

    /// POD: bases, rest and scales of the training recordings, and both sets projected without the feed-through.
    pub(super) fn pod(&self) -> Result<Projected, TrainError> {
        let mut frame = Frame::new(self.training, &self.options.hyperparameters.pod)?;
        let project = |all: &[Recording]| all.iter().map(|r| frame.project(r)).collect::<Vec<_>>();
        let (mut training, mut validation) = (project(self.training), project(self.validation));
        frame.feed = feed::through(&training, &frame.ranges())?;
        training.iter_mut().chain(&mut validation).for_each(|sequence| frame.take_out_feed(sequence));
        frame.measure_scales(&training);
        Ok(Projected { frame, training, validation })
    }

    /// Joint autoencoder, its latents turned into the principal axes of the fields that they decode to.
    pub(super) fn autoencoder(&self, projected: &Projected) -> Result<Autoencoder, TrainError> {
        let parameters = &self.options.hyperparameters;
        let data = TrainingSplit {
            training: projected.training.as_slice(),
            validation: projected.validation.as_slice(),
        };
        let run = self.run(Stage::Autoencoder, parameters.schedule.autoencoder);
        let trained = Autoencoder::train(&projected.frame, &data, &parameters.autoencoder, run);
        if self.session.stopped() {
            return Err(TrainError::Interrupted);
        }
        let silent_share = parameters.autoencoder.silent_share;
        Ok(trained.whitened(&projected.training, &projected.frame, silent_share))
    }

    /// Linear fit, its split into operators, and the change to the coordinates of energy.
    pub(super) fn warm_start(
        &self,
        projected: Projected,
        autoencoder: &Autoencoder,
        rng: &mut ChaCha8Rng,
    ) -> Result<LatentRecordings, TrainError> {
        let parameters = &self.options.hyperparameters;
        let Projected { frame, training, validation } = projected;
        let metric = autoencoder.metric();
        let training = EncodedRecordings::new(training, autoencoder, &frame);
        let linear = Linear::fit(&training.paths, &metric)?;
        let start = warm::start(&linear, &training.paths, &metric, &parameters.warm_start, rng)?;

        // From here on the latents are K x: H starts as |x|^2 / 2 and all entries of L and D are rates. Training
        // is well scaled so, and the discrete gradient, whose correction depends on the coordinates, is mild.
        let energetic = TrainError::Singular("coordinates of energy");
        let (forth, back) = (start.linear, start.linear.try_inverse().ok_or(energetic.clone())?);
        let start = start.changed(&forth).ok_or(energetic)?;
        let (autoencoder, linear) = (autoencoder.mapped(&forth, &back), linear.mapped(&forth, &back));
        let metric = metric * back;
        let encoded = |sequences| EncodedRecordings::new(sequences, &autoencoder, &frame);
        let (training, validation) = (encoded(training.sequences), encoded(validation));
        let heat = Heat::fit(self.training, &training, &parameters.heat);
        let start = match &self.options.flow_law {
            Some(liquid) => friction_law::under_law(start, liquid, &training.paths, &metric),
            None => start,
        };
        let start_error = validate(|x, u| start.roll_out(x, u), &validation.paths, &metric);
        Ok(LatentRecordings {
            frame,
            autoencoder,
            heat,
            linear,
            start,
            metric,
            training,
            validation,
            start_error,
        })
    }

    /// GRU encoder and roll-out trainings, side by side; of the latter the best, as single precision keeps it.
    pub(super) fn encoder_and_dynamics(&self, latent: &LatentRecordings) -> (Encoder, Dynamics) {
        let parameters = &self.options.hyperparameters;
        let LatentRecordings { frame, start, metric, training, validation, .. } = latent;
        let cost = &Cost { metric: *metric, port: frame.feed_cost() };
        let (encoder, dynamics) = std::thread::scope(|scope| {
            let encoder = scope.spawn(move || {
                let (training, validation) = (training.labelled(), validation.labelled());
                let data = TrainingSplit { training: training.as_slice(), validation: validation.as_slice() };
                let run = self.run(Stage::Encoder, parameters.schedule.encoder);
                Encoder::train(frame, &data, cost, &parameters.encoder, self.base.as_ref(), run)
            });
            let one = |k: u64| {
                scope.spawn(move || {
                    let data = TrainingSplit {
                        training: training.paths.as_slice(),
                        validation: validation.paths.as_slice(),
                    };
                    let run = self.run(Stage::Rollout(k), parameters.schedule.rollout);
                    rollout::train(start, &data, metric, &parameters.rollout, run)
                })
            };
            let threads: Vec<_> = (0..parameters.schedule.seeds).map(one).collect();
            let trained = threads.into_iter().map(|thread| thread.join().expect("a roll-out's thread ends"));
            let best = trained.min_by(|a, b| a.1.total_cmp(&b.1));
            let best = best.map_or_else(|| start.clone(), |(dynamics, _)| dynamics);
            (encoder.join().expect("the encoder's thread ends"), best)
        });
        let dynamics = friction_law::at_mean_rate(&dynamics, &training.paths);
        (encoder, unrolled::rounded(&dynamics))
    }

    /// Preconditioner, constant gain and error model, on readings with the camera's noise.
    pub(super) fn filter(
        &self,
        latent: LatentRecordings,
        encoder: Encoder,
        dynamics: &Dynamics,
        rng: &mut ChaCha8Rng,
    ) -> Result<Filtered, TrainError> {
        let LatentRecordings { frame, autoencoder, heat, linear, metric, training, validation, .. } = latent;
        let preconditioner = precondition::best(dynamics, &training.paths);
        // The encoder is too good on its own training recordings, so the validation recordings count as often.
        let mut tracks = training.tracks(&frame, &encoder, Noise::CAMERA, rng);
        let passes = tracks.len().div_ceil(validation.sequences.len());
        tracks.extend((0..passes).flat_map(|_| validation.tracks(&frame, &encoder, Noise::CAMERA, rng)));
        let gain = filter::tune(dynamics, &tracks, &metric, &self.options.hyperparameters.filter)?;
        let dynamics = dynamics.clone();
        let model = LearntModel { frame, autoencoder, heat, encoder, dynamics, linear, preconditioner, gain };
        let errors = MeasuredErrors::new(&model, &tracks, &validation, &metric);
        Ok(Filtered { model, metric, validation, training, errors, start_error: latent.start_error })
    }
}

/// Digest of the data, the seed and the hyperparameters: a checkpoint goes on in the training that wrote it alone.
fn fingerprint(training: &[Recording], validation: &[Recording], options: &Options) -> u32 {
    let mut digest = meniscus::blob::CRC.digest();
    for recording in training.iter().chain(validation) {
        recording.profile_m.iter().for_each(|height| digest.update(&height.to_le_bytes()));
    }
    let (version, parameters) = (env!("CARGO_PKG_VERSION"), &options.hyperparameters);
    digest.update(format!("{version} {} {parameters:?}", options.seed).as_bytes());
    if let Base::Blob(base) = &options.base {
        digest.update(base);
    }
    digest.finalize()
}
