//! Adam on the trainable part of a blob, and the candidate blobs that come of it.

use super::Correction;
use crate::TrainError;
use crate::correct::checkpoint_parts::CheckpointParts;
use crate::correct::effects::{Held, StandIn, StepWithEffects, with_effects};
use crate::correct::residual_covariance::{FilterRun, ResidualCovariance};
use crate::correct::trainable_model::{Batch, DYNAMICS, Liquid, Rollouts, TrainableModel};
use crate::correct::training_sets::TrainingSets;
use crate::operators::unrolled::dynamics_of;
use burn::tensor::{Device, Tensor};
use meniscus::blob::{LoadError, Model};
use meniscus::latent::generic::LatentState;
use meniscus_optim::progress::annealed;
use meniscus_optim::weights::{Adam, Matrix, leaves, scalar};
use meniscus_platform::files::AlignedBytes;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Weights between two steps, with the filter states and residuals of the last candidate.
pub(super) struct Adaptation<'a> {
    parts: &'a CheckpointParts,
    sets: &'a TrainingSets,
    how: &'a Correction,
    device: Device,
    rng: ChaCha8Rng,
    weights: Vec<Matrix>,
    adam: Adam,
    last: LastCandidate,
    residuals: ResidualCovariance,
}

/// Knowledge of the last candidate that the steps after it use.
struct LastCandidate {
    /// States of its running filter on the new recordings and on the stretched ones, from which forecasts begin.
    filter_states: [Vec<Vec<LatentState>>; 2],
    /// The step that stands for its step with effects; `None` without effects.
    stand_in: Option<StandIn>,
}

impl LastCandidate {
    fn new(model: &Model<'_>, sets: &TrainingSets) -> Self {
        let filter_states = [&sets.new, &sets.stretched].map(|set| set.filter_states(model));
        let stand_in = StandIn::along(&model.generic, filter_states[0].iter().flatten());
        Self { filter_states, stand_in }
    }
}

impl<'a> Adaptation<'a> {
    /// Start from the weights of `blob`, whose `parts` these are.
    ///
    /// # Errors
    /// [`LoadError`], when the blob is refused.
    pub(super) fn new(
        blob: &[u8],
        parts: &'a CheckpointParts,
        sets: &'a TrainingSets,
        how: &'a Correction,
    ) -> Result<Self, LoadError> {
        let weights = parts.weights.clone();
        Ok(Self {
            parts,
            sets,
            how,
            device: Device::flex().autodiff(),
            rng: ChaCha8Rng::seed_from_u64(how.seed),
            adam: Adam::new(&weights, 1.0),
            weights,
            last: LastCandidate::new(&with_effects(blob)?, sets),
            residuals: parts.residuals,
        })
    }

    /// One step of Adam; returns the loss before it.
    ///
    /// # Errors
    /// [`TrainError::NoMotion`], when no recording is long enough for a roll-out.
    pub(super) fn step(&mut self, step: usize) -> Result<f64, TrainError> {
        let blob = match self.last.stand_in {
            Some(_) => {
                Some(AlignedBytes::copy(&self.parts.blob(&self.weights, &self.residuals, self.how)?))
            }
            None => None,
        };
        let model = blob.as_deref().map(with_effects).transpose()?;
        let Self { parts, sets, how, device, rng, weights, adam, last, .. } = self;
        let parameters = &how.parameters;
        let tensors = leaves(weights, device);
        let dynamics = dynamics_of(&weights[DYNAMICS]);
        let preconditioners = dynamics.preconditioners(&dynamics.stiffness());
        let effects = model.as_ref().zip(last.stand_in.as_ref()).map(|(model, stand_in)| {
            StepWithEffects::new(&model.generic, stand_in, &tensors[DYNAMICS], &dynamics, device)
        });
        let trainable = TrainableModel::new(&tensors, &parts.surface, &preconditioners, effects, device);
        let mut losses: Vec<Tensor<1>> = Vec::new();
        let [new, stretched] = &last.filter_states;
        let tracked =
            [(&sets.new, Some(new)), (&sets.stretched, Some(stretched)), (&sets.source, None)].into_iter();
        for ((set, states), count) in tracked.zip(parameters.batch) {
            let starts = set.draw(count, parameters.tracked_frames, rng);
            if starts.is_empty() {
                continue;
            }
            let (liquid, held) = match states {
                Some(states) => (Liquid::New, FilterRun { windows: &set.windows, states }.held(&starts)),
                None => (Liquid::Source, vec![Held::default(); starts.len()]),
            };
            let batch = Batch::new(&set.windows, &starts, held, parameters.tracked_frames, device);
            losses.push(trainable.tracking_loss(&batch, liquid, set.mean_square));
        }
        // Of the source nothing is forecast: its motion is another.
        let forecast =
            [&sets.new, &sets.stretched].into_iter().zip(&last.filter_states).zip(parameters.batch);
        for ((set, states), count) in forecast {
            let starts = set.draw(count, parameters.forecast_frames, rng);
            if !starts.is_empty() {
                let run = FilterRun { windows: &set.windows, states };
                let rollouts = Rollouts::new(&run, &starts, parameters.forecast_frames, device);
                losses.push(trainable.forecast_loss(&rollouts, set.mean_square));
            }
        }
        let total = losses.into_iter().reduce(|sum, part| sum + part).ok_or(TrainError::NoMotion)?;
        let loss = f64::from(scalar(total.clone()));
        let rate = annealed(parameters.learning_rate, step, parameters.steps);
        adam.step(weights, &tensors, total.backward(), rate);
        Ok(loss)
    }

    /// Blob with the weights as they stand, its residual covariance measured anew; the next forecasts begin where its
    /// filter stands.
    ///
    /// # Errors
    /// [`TrainError`], when a weight is not finite.
    pub(super) fn candidate(&mut self) -> Result<Vec<u8>, TrainError> {
        // The filter that is measured on follows the heights as closely as the source's.
        let follows = self.residuals.with_heights_of(&self.parts.residuals);
        let probe = AlignedBytes::copy(&self.parts.blob(&self.weights, &follows, self.how)?);
        let model = with_effects(&probe)?;
        self.last = LastCandidate::new(&model, self.sets);
        let [states, _] = &self.last.filter_states;
        let run = FilterRun { windows: &self.sets.new.windows, states };
        let parameters = &self.how.parameters.residuals;
        self.residuals = self.parts.measured_residuals(&model.generic, &run, parameters);
        self.parts.blob(&self.weights, &self.residuals, self.how)
    }
}
