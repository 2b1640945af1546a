//! Training: the list of its stages, from recordings to a calibrated blob.

mod pipeline;
mod results;

use crate::TrainError;
use crate::calibration::blob_draft::{BlobDraft, CalibratedBlob};
use crate::hyperparameters::Hyperparameters;
use crate::networks::base::Base;
use crate::stage::{Stage, StageRecord};
use meniscus_data::blob_file::read;
use meniscus_data::liquids::Rheology;
use meniscus_data::recording::Recording;
use meniscus_optim::progress::{Checkpoints, Curve};
use meniscus_platform::files::AlignedBytes;
use meniscus_report::checks::Check;
use pipeline::Pipeline;
use std::sync::atomic::AtomicBool;

/// Inputs of a training beside its recordings.
#[derive(Clone, Debug)]
pub struct Options {
    /// Seed of everything that is drawn.
    pub seed: u64,
    /// Lengths, rates and weights of the stages.
    pub hyperparameters: Hyperparameters,
    /// Whether the paper's soft net is trained beside the exact step, to compare; it is not in the blob.
    pub soft: bool,
    /// Whether the paper's five sparse autoencoders are trained beside the joint one, to compare; they are not in
    /// the blob.
    pub sparse: bool,
    /// No bars.
    pub quiet: bool,
    /// The command, for the blob's provenance.
    pub command: String,
    /// Folder of the checkpoints; none are written if `None`.
    pub checkpoints: Option<Checkpoints>,
    /// Weights that the networks start from.
    pub base: Base,
    /// Flow law of the liquid, whose friction the step takes over; `None` where friction is taken as linear.
    pub flow_law: Option<Rheology>,
}

/// Trained blob with its figures.
#[derive(Clone, Debug)]
pub struct Trained {
    /// The bytes of the blob.
    pub blob: Vec<u8>,
    /// Figures on the validation recordings.
    pub checks: Vec<Check>,
    /// Errors of every optimisation over its steps.
    pub curves: Vec<Curve>,
    /// Seed, metric and checkpoint of every stage, in their order.
    pub stages: Vec<StageRecord>,
    /// Slosh-relative error of the filtered surface on the validation recordings, by which a choice among seeds is made.
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
    let pipeline = Pipeline::new(training, validation, options, stop)?;
    let mut noise = pipeline.warm_start_draws();

    let projected = pipeline.pod()?;
    let autoencoder = pipeline.autoencoder(&projected)?;
    let latent = pipeline.warm_start(projected, &autoencoder, &mut noise)?;
    // The two need nothing of each other, and neither gains from a second core.
    let (encoder, dynamics) = pipeline.encoder_and_dynamics(&latent);
    let filtered = pipeline.filter(latent, encoder, &dynamics, &mut noise)?;

    let soft = options.soft.then(|| pipeline.soft(&filtered));
    let sparse = options.sparse.then(|| pipeline.sparse(&filtered));
    let mut checks = pipeline.checks_of_parts(&filtered, &mut noise);
    let calibrated = BlobDraft::new(pipeline.header(&filtered)?, filtered.blob_parts())
        .calibrate(validation, options.seed)?;

    let exact = &filtered.model.dynamics;
    checks.extend(
        soft.iter().flat_map(|soft| soft.checks(exact, &filtered.validation.paths, &filtered.metric)),
    );
    checks.extend(
        sparse
            .iter()
            .flat_map(|five| five.checks(&filtered.model.frame, validation, &filtered.validation.sequences)),
    );
    checks.extend(calibrated.checks);
    let (stages, curves) = pipeline.records(&filtered, calibrated.stages);
    Ok(Trained { blob: calibrated.blob, checks, curves, stages, slosh_rel: calibrated.slosh_rel })
}

/// Measures the intervals of `blob` and its stated error again, on `validation`; the weights stay. Use after changing the
/// estimator or adding validation data.
///
/// # Errors
/// [`TrainError`], when the blob is refused or a recording cannot be seen.
pub fn measured_again(blob: &[u8], validation: &[Recording], seed: u64) -> Result<Trained, TrainError> {
    if validation.is_empty() {
        return Err(TrainError::NoRecording);
    }
    let (header, parts) = read::parts(&AlignedBytes::copy(blob))?;
    let CalibratedBlob { blob, checks, slosh_rel, stages } =
        BlobDraft::new(header, parts).calibrate(validation, seed)?;
    Ok(Trained { blob, checks, curves: Vec::new(), stages, slosh_rel })
}

/// Stages of a training with `options`, in their order.
#[must_use]
pub fn stages(options: &Options) -> Vec<Stage> {
    let mut all = vec![Stage::Pod, Stage::Autoencoder, Stage::WarmStart, Stage::Encoder];
    all.extend((0..options.hyperparameters.schedule.seeds).map(Stage::Rollout));
    all.push(Stage::Filter);
    all.extend(options.soft.then_some(Stage::Soft));
    all.extend(options.sparse.then_some(Stage::Sparse));
    all.extend([Stage::Calibration, Stage::Evaluation]);
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hyperparameters::Schedule;
    use std::collections::BTreeSet;

    /// Every stage has a name of its own, so that no checkpoint or record takes another's place.
    #[test]
    fn stages_have_distinct_names() {
        let schedule = Schedule { seeds: 3, ..Schedule::QUICK };
        let mut options = Options {
            seed: 5,
            hyperparameters: Hyperparameters::with_schedule(schedule),
            soft: true,
            sparse: true,
            quiet: true,
            command: String::new(),
            checkpoints: None,
            base: Base::Scratch,
            flow_law: None,
        };
        let all = stages(&options);
        let names: BTreeSet<String> = all.iter().map(|stage| stage.label(options.seed)).collect();
        assert_eq!((all.len(), names.len()), (12, 12), "{names:?}");
        assert_eq!(all.iter().filter(|stage| matches!(stage, Stage::Rollout(_))).count(), 3);
        (options.soft, options.sparse) = (false, false);
        assert_eq!(stages(&options).len(), 10);
    }
}
