//! Blob in the making: its tensors stand, its error factors and its error are still to be measured.
//!
//! ```text
//! draft, k = 1, g = 0 --errors, rest noise--> draft, k = 1, g --interval factors--> draft, k, g --disagreement--> blob --coverage-->
//! ```
//! The rest noise g is part of every interval, and the factors k scale the intervals that have it. The disagreement theta compares
//! errors with scaled intervals. Each measurement therefore runs a blob that states what the measurements before it have found.

use crate::TrainError;
use crate::calibration::camera_views::{CameraView, camera_views};
use crate::calibration::intervals::{
    IntervalFactors, coverage, disagreement, errors, interval_factors, rest_noise_m,
};
use crate::stage::{Stage, StageRecord};
use meniscus::blob::Header;
use meniscus::uncertainty::error_factors::ErrorFactors;
use meniscus_data::blob_file::factors;
use meniscus_data::blob_file::write::{self, ExportError, Part};
use meniscus_data::recording::Recording;
use meniscus_report::checks::Check;

/// Targets of the estimate, per cent: q, v, sigma, tau, surface.
const TARGETS: [Option<f64>; 5] = [Some(12.0), Some(12.0), Some(15.0), Some(15.0), Some(12.0)];

/// Depth noise of the harder run, in units of the noise that the targets hold for.
const MORE_NOISE: f64 = 3.0;

/// Header and tensors of a blob that has not been calibrated.
#[derive(Clone, Debug)]
pub(crate) struct BlobDraft {
    header: Header,
    parts: Vec<Part>,
}

/// Calibrated blob with its figures.
#[derive(Clone, Debug)]
pub(crate) struct CalibratedBlob {
    /// The bytes of the blob.
    pub(crate) blob: Vec<u8>,
    /// Figures behind the rendered camera.
    pub(crate) checks: Vec<Check>,
    /// Slosh-relative error of the filtered surface.
    pub(crate) slosh_rel: f64,
    /// Records of the two stages behind the camera.
    pub(crate) stages: Vec<StageRecord>,
}

impl BlobDraft {
    /// Draft of `header` and `parts`, with every interval factor one and no rest noise whatever `parts` say of them.
    pub(crate) fn new(header: Header, parts: Vec<Part>) -> Self {
        let mut draft = Self { header, parts };
        factors::change(&mut draft.parts, |of| *of = ErrorFactors::uncalibrated(of.weight_floor));
        draft
    }

    /// Bytes of the blob as it stands.
    fn bytes(&self) -> Result<Vec<u8>, ExportError> {
        write::blob(self.header.clone(), &self.parts)
    }

    /// Measures errors, rest noise, interval factors and coverage on `validation`, in the run of `seed`.
    ///
    /// # Errors
    /// [`TrainError`], when the blob is refused or the glass of a recording cannot be seen.
    pub(crate) fn calibrate(
        mut self,
        validation: &[Recording],
        seed: u64,
    ) -> Result<CalibratedBlob, TrainError> {
        let views = |noise: f64, stage: Stage| camera_views(validation, noise, stage.seed(seed));
        // One draw of the camera noise gives the factors, another the errors and the coverage.
        let calibration: Vec<CameraView<'_>> = views(1.0, Stage::Calibration)?;
        let evaluation: Vec<CameraView<'_>> = views(1.0, Stage::Evaluation)?;

        let uncalibrated = self.bytes()?;
        let estimate = errors(&uncalibrated, &evaluation)?;
        let noisy = errors(&uncalibrated, &views(MORE_NOISE, Stage::Evaluation)?)?;
        let mut checks = estimate.checks("estimate, camera noise", TARGETS);
        checks.extend(noisy.checks("estimate, three times the noise", [None; 5]));

        let rest_noise_m = rest_noise_m(&uncalibrated, &calibration)?;
        factors::change(&mut self.parts, |of| of.rest_noise_std_m = rest_noise_m);

        let IntervalFactors { k, left_out } = interval_factors(&self.bytes()?, &calibration)?;
        factors::change(&mut self.parts, |of| of.quantiles_mut().zip(k).for_each(|(factor, k)| *factor = k));
        let disagreement = disagreement(&self.bytes()?, &calibration)?;
        factors::change(&mut self.parts, |of| of.disagreement = disagreement);
        checks.push(Check::informational(
            "interval: disagreement with the camera",
            f64::from(disagreement),
            "1",
        ));
        checks.push(Check::informational("interval: rest missed by", 1e3 * f64::from(rest_noise_m), "mm"));
        checks.extend(left_out);

        self.header.validation_slosh_rel = estimate.surface() as f32;
        let blob = self.bytes()?;
        checks.extend(coverage(&blob, &evaluation)?);
        let stages = vec![
            StageRecord::new(Stage::Calibration, seed, Some(f64::from(rest_noise_m))),
            StageRecord::new(Stage::Evaluation, seed, Some(estimate.surface())),
        ];
        Ok(CalibratedBlob { blob, checks, slosh_rel: estimate.surface(), stages })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::blob::Model;
    use meniscus_data::blob_file::read;
    use meniscus_platform::files::AlignedBytes;

    /// The draft of a calibrated blob keeps the floor of w, has no calibration left, and is a blob.
    #[test]
    fn a_draft_has_no_calibration() {
        let (header, parts) =
            read::parts(&AlignedBytes::copy(meniscus_shipped::MODEL)).expect("the shipped model");
        let shipped = factors::of(&parts).expect("its error factors");
        let draft = BlobDraft::new(header, parts);
        let drafted = factors::of(&draft.parts).expect("its error factors");
        assert_eq!(drafted, ErrorFactors::uncalibrated(shipped.weight_floor), "only the floor of w is kept");
        assert_ne!(drafted, shipped);
        let bytes = AlignedBytes::copy(&draft.bytes().expect("finite numbers"));
        assert!(Model::load(&bytes).is_ok());
    }
}
