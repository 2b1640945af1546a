//! Comparisons, figures and records of a training, once its model is learnt.

use super::pipeline::{Filtered, Pipeline};
use super::stages;
use crate::TrainError;
use crate::blob_text::fitting;
use crate::calibration::validation_report;
use crate::data::errors::percent;
use crate::networks::noise::Noise;
use crate::networks::sparse::{Sparse, SparseData};
use crate::operators::soft::Soft;
use crate::stage::{Stage, StageRecord, TrainingSplit};
use meniscus::blob::{FilterConfig, Header, KnownGroups, Variant};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::recording::TRACERS;
use meniscus_optim::progress::Curve;
use meniscus_report::checks::Check;
use rand_chacha::ChaCha8Rng;

impl Pipeline<'_> {
    /// Soft net on the same trajectories, to compare.
    pub(super) fn soft(&self, filtered: &Filtered) -> Soft {
        let parameters = &self.options.hyperparameters;
        let data = TrainingSplit {
            training: filtered.training.paths.as_slice(),
            validation: filtered.validation.paths.as_slice(),
        };
        let run = self.run(Stage::Soft, parameters.schedule.rollout);
        Soft::train(&filtered.model.dynamics, &data, &filtered.metric, parameters, run)
    }

    /// Sparse autoencoders on the same recordings, to compare.
    pub(super) fn sparse(&self, filtered: &Filtered) -> Sparse {
        let parameters = &self.options.hyperparameters;
        let data = SparseData {
            frame: &filtered.model.frame,
            recordings: TrainingSplit { training: self.training, validation: self.validation },
            sequences: TrainingSplit {
                training: filtered.training.sequences.as_slice(),
                validation: filtered.validation.sequences.as_slice(),
            },
        };
        Sparse::train(&data, parameters, self.run(Stage::Sparse, parameters.schedule.autoencoder))
    }

    /// Figures of every part on the validation recordings, with fresh camera noise: the gain was fitted to the other.
    pub(super) fn checks_of_parts(&self, filtered: &Filtered, rng: &mut ChaCha8Rng) -> Vec<Check> {
        let Filtered { model, validation, .. } = filtered;
        let tracks = validation.tracks(&model.frame, &model.encoder, Noise::CAMERA, rng);
        let mut checks = validation_report::checks(model, validation, &tracks);
        let heat = model.heat.missed(self.validation, validation);
        checks.push(percent(String::from("decoder alone: e"), heat, None));
        checks
    }

    /// Header of the blob; its error is measured later.
    pub(super) fn header(&self, filtered: &Filtered) -> Result<Header, TrainError> {
        let first = self.training.first().ok_or(TrainError::NoRecording)?;
        let frame = &filtered.model.frame;
        Ok(Header {
            liquid: fitting(&first.provenance.liquid),
            provenance: fitting(&self.options.command),
            particles: TRACERS as u32,
            dt_s: FRAME_INTERVAL_S,
            radius_m: first.glass.radius_m,
            fill_m: first.glass.fill_m,
            rim_m: first.glass.rim_m,
            height_scale_m: frame.height_scale_m,
            acceleration_scale: frame.acceleration_scale,
            energy_scale_j: frame.energy_scale_j,
            validation_slosh_rel: 0.0,
            sections: heapless::Vec::new(),
            embedded: None,
            model_version: 1,
            stated_known: KnownGroups::ALL,
            filter: FilterConfig::REFERENCE,
            variant: Variant::Full,
        })
    }

    /// Records of all stages, with those that the calibration has made, and the curves.
    pub(super) fn records(
        self,
        filtered: &Filtered,
        calibrated: Vec<StageRecord>,
    ) -> (Vec<StageRecord>, Vec<Curve>) {
        let (curves, seed) = (self.session.curves(), self.options.seed);
        let truncation = filtered.model.frame.bases.iter().map(|basis| basis.left_out).fold(0.0, f64::max);
        let filtered_surface = calibrated.last().and_then(|record| record.value);
        let mut records = Vec::new();
        for stage in stages(self.options) {
            records.push(match stage {
                Stage::Pod => StageRecord::new(stage, seed, Some(truncation)),
                Stage::WarmStart => StageRecord::new(stage, seed, Some(filtered.start_error)),
                Stage::Filter => StageRecord::new(stage, seed, filtered_surface),
                Stage::Calibration | Stage::Evaluation => continue,
                _ => StageRecord::from_curve(stage, seed, &curves),
            });
        }
        records.extend(calibrated);
        (records, curves)
    }
}
