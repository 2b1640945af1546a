//! Correction of the trained model on the measured recordings: what even the right liquid in the simulator misses.
//!
//! The model is already of this liquid, so that a correction leaves every group known. Its own simulated recordings stand against
//! forgetting. Where no candidate forecasts the held-out recording better, the trained model stays.

use crate::error::RelearnError;
use crate::folder::Folder;
use crate::identify::MeasuredRecording;
use meniscus::blob::Model;
use meniscus_data::recording::Recording;
use meniscus_learn::correct::{Correction, CorrectionParameters, Sightings, correct as learn};
use meniscus_platform::files::{AlignedBytes, write_whole};
use meniscus_report::checks::Check;
use meniscus_virtual::observe_recording::{DISPARITY_RMS_PX, sightings};
use meniscus_virtual::render::SceneSettings;
use std::sync::atomic::{AtomicBool, Ordering};

/// Steps of a correction; the verb `correct` has the same.
const STEPS: usize = 300;

/// Most simulated recordings against forgetting; each is run over at every look.
const AGAINST_FORGETTING: usize = 2;

/// Corrects the trained model in `folder` and writes the finished one.
///
/// # Errors
/// [`RelearnError`], when a model is refused, nothing can be written, or the correction was stopped.
pub(crate) fn correct(
    measured: &[MeasuredRecording],
    validation: &[Recording],
    folder: &Folder,
    seed: u64,
    quiet: bool,
    stop: &AtomicBool,
) -> Result<(), RelearnError> {
    let blob = AlignedBytes::read(&folder.trained())?;
    if measured.is_empty() {
        // Copied, so that the finished model has one name whatever was measured.
        return Ok(write_whole(&folder.model(), &blob)?);
    }
    let header = Model::load(&blob)?.header;
    let seen: Vec<Sightings> = measured.iter().map(|one| one.profiles.clone()).collect();
    let look = |(k, recording): (u64, &Recording)| {
        let scene = SceneSettings {
            disparity_rms_px: DISPARITY_RMS_PX,
            seed: seed + 1000 + k,
            ..SceneSettings::of(&recording.glass)
        };
        sightings(recording, scene)
    };
    let own = (0..).zip(validation.iter().take(AGAINST_FORGETTING)).map(look);
    let own = own.collect::<Result<Vec<_>, _>>()?;
    let how = Correction {
        seed,
        parameters: CorrectionParameters { steps: STEPS, ..CorrectionParameters::default() },
        liquid: header.liquid.as_str().into(),
        same_liquid: true,
        command: format!("meniscus learn: correction by {} recordings", measured.len()),
        quiet,
    };
    let corrected = learn(&blob, &seen, &own, &how, stop)?;
    if stop.load(Ordering::Relaxed) {
        let kept = String::from("trained.blob is finished, its correction is not");
        return Err(RelearnError::Interrupted { stage: "correct", kept });
    }
    let [before, after] = corrected.held.map(|error| 100.0 * error);
    let [own_before, own_after] = corrected.source.map(|error| 100.0 * error);
    let checks = [
        Check::informational("measured_before_forecast_250ms", before, "%"),
        Check::informational("measured_after_forecast_250ms", after, "%"),
        Check::informational("simulated_before_slosh_rel", own_before, "%"),
        Check::informational("simulated_after_slosh_rel", own_after, "%"),
    ];
    let figures = serde_json::json!({ "checks": checks, "improved": after < before });
    write_whole(&folder.corrected_figures(), format!("{figures:#}\n").as_bytes())?;
    Ok(write_whole(&folder.model(), if after < before { &corrected.blob } else { &blob })?)
}
