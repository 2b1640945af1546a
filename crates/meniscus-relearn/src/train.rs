//! Training on the simulated recordings.
//!
//! The model knows every group that it was trained on, but the heat of a liquid whose heat it cannot tell: the internal energy is
//! left out of the known groups where its interval is wider than half its size. In a low-viscosity liquid a slosh makes
//! microjoules, much of them by the simulator's own losses.

use crate::error::RelearnError;
use crate::folder::Folder;
use crate::plan::Plan;
use crate::progress::Progress;
use meniscus::blob::{FieldGroup, KnownGroups, Model};
use meniscus::runtime::Mode;
use meniscus_data::blob_file::{read, write};
use meniscus_data::liquids::Rheology;
use meniscus_data::recording::{Recording, STATE, group_range};
use meniscus_learn::{Base, Options, Trained, curves_png};
use meniscus_optim::progress::Checkpoints;
use meniscus_platform::files::{AlignedBytes, FileError, write_whole};
use meniscus_report::checks::Check;
use meniscus_virtual::observe_recording::{DISPARITY_RMS_PX, sightings, turns};
use meniscus_virtual::render::SceneSettings;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Half-width of the interval of the internal energy over its size above which the heat counts as unknown.
const UNKNOWN_HEAT: f64 = 0.5;

/// Share of the liquid that a recording may spill and still be trained on: a model has one fill.
const SPILLED_SHARE: f64 = 0.01;

/// Recordings of a training.
pub(crate) struct Recordings<'a> {
    /// Recordings that weights are learnt from.
    pub(crate) training: &'a [Recording],
    /// Recordings that choices are made by.
    pub(crate) validation: &'a [Recording],
    /// Liquid, as the commands of the recordings name it.
    pub(crate) liquid: &'a str,
    /// Flow law of the liquid.
    pub(crate) rheology: Rheology,
}

/// Whether `folder` holds a model that was trained on `liquid`. A person may have edited the liquid file since.
pub(crate) fn is_trained(folder: &Folder, liquid: &str) -> bool {
    let figures = std::fs::read(folder.trained_figures()).unwrap_or_default();
    let figures: serde_json::Value = serde_json::from_slice(&figures).unwrap_or_default();
    folder.trained().exists() && figures["liquid"] == liquid
}

/// Whether `recording` kept so much of its liquid that it shows the fill of its glass.
pub(crate) fn keeps_its_fill(recording: &Recording) -> bool {
    let glass = &recording.glass;
    let volume_m3 = std::f64::consts::PI * glass.radius_m * glass.radius_m * glass.fill_m;
    recording.spilled_m3.last().is_none_or(|spilled| *spilled <= SPILLED_SHARE * volume_m3)
}

/// Trains the model of `plan` and writes it with its figures to `folder`; what a broken-off training left there is continued.
///
/// # Errors
/// [`RelearnError`], when the recordings do not suffice, nothing can be written, or the training was stopped.
pub(crate) fn train(
    plan: &Plan,
    recordings: &Recordings<'_>,
    base: &[u8],
    folder: &Folder,
    command: &str,
    stop: &AtomicBool,
    progress: &dyn Progress,
) -> Result<(), RelearnError> {
    let begun = Instant::now();
    let checkpoints = folder.checkpoints();
    std::fs::create_dir_all(&checkpoints).map_err(|cause| FileError {
        path: checkpoints.clone(),
        doing: "make",
        cause,
    })?;
    let options = Options {
        seed: plan.seed,
        hyperparameters: plan.hyperparameters.clone(),
        soft: false,
        sparse: false,
        quiet: progress.quiet(),
        command: command.into(),
        checkpoints: Some(Checkpoints { folder: checkpoints.clone(), resume: true }),
        base: if plan.transfer { Base::Blob(Arc::from(base)) } else { Base::Scratch },
        flow_law: (!recordings.rheology.is_newtonian()).then_some(recordings.rheology),
    };
    let trained = meniscus_learn::train(recordings.training, recordings.validation, &options, stop);
    if stop.load(Ordering::Relaxed) {
        // A training that is stopped gives its best so far, which is another model than that of a whole one.
        let kept = format!("its checkpoints lie in {}", checkpoints.display());
        return Err(RelearnError::Interrupted { stage: "train", kept });
    }
    let Trained { blob, mut checks, curves, stages, .. } = trained?;
    let heat = heat_interval(&blob, recordings.validation)?;
    checks.push(Check::at_most("interval of e over its size", heat, "1", UNKNOWN_HEAT));
    let known = if heat <= UNKNOWN_HEAT { KnownGroups::ALL } else { all_but_heat() };
    let blob = knowing(&blob, known)?;
    let mut picture = folder.curves().into_os_string();
    picture.push(".part.png");
    curves_png(&curves, picture.as_ref())?;
    std::fs::rename(&picture, folder.curves()).map_err(|cause| FileError {
        path: folder.curves(),
        doing: "write",
        cause,
    })?;
    let figures = serde_json::json!({
        "liquid": recordings.liquid,
        "checks": checks,
        "stages": stages,
        "seconds": begun.elapsed().as_secs_f64(),
    });
    write_whole(&folder.trained_figures(), format!("{figures:#}\n").as_bytes())?;
    // Last, because its being there is what says that the stage is done.
    write_whole(&folder.trained(), &blob)?;
    // Checkpoints that cannot be removed harm nobody: a finished model is not trained again.
    let _left = std::fs::remove_dir_all(&checkpoints);
    Ok(())
}

/// All groups but the internal energy.
fn all_but_heat() -> KnownGroups {
    let others = FieldGroup::ALL.into_iter().filter(|group| *group != FieldGroup::InternalEnergy);
    others.fold(KnownGroups::NONE, KnownGroups::with)
}

/// `blob` with the statement that it knows `known`.
///
/// # Errors
/// [`RelearnError`], when the blob is refused.
fn knowing(blob: &[u8], known: KnownGroups) -> Result<Vec<u8>, RelearnError> {
    let (mut header, parts) = read::parts(&AlignedBytes::copy(blob))?;
    header.stated_known = known;
    Ok(write::blob(header, &parts)?)
}

/// Mean half-width of the interval of the internal energy over the root mean square of its change, on `validation` behind the
/// simulated camera; infinite where no estimate was made.
///
/// # Errors
/// [`RelearnError`], when the blob is refused or a glass cannot be seen.
fn heat_interval(blob: &[u8], validation: &[Recording]) -> Result<f64, RelearnError> {
    let blob = AlignedBytes::copy(blob);
    let model = Model::load(&blob)?;
    let heat = FieldGroup::InternalEnergy as usize;
    let (mut half_square, mut size_square) = (0.0, 0.0);
    let (mut rest, mut state) = (vec![0.0; STATE], vec![0.0; STATE]);
    for (seed, recording) in (1..).zip(validation) {
        let scene =
            SceneSettings { disparity_rms_px: DISPARITY_RMS_PX, seed, ..SceneSettings::of(&recording.glass) };
        recording.state(0, &mut rest);
        for (frame, logged) in turns(&model, &sightings(recording, scene)?).iter().enumerate() {
            let estimate = &logged.turn.estimate;
            if estimate.mode != Mode::Tracking {
                continue;
            }
            recording.state(frame, &mut state);
            let change = state[group_range(heat)].iter().zip(&rest[group_range(heat)]);
            size_square += change.map(|(e, rest)| f64::from(e - rest).powi(2)).sum::<f64>();
            let half = f64::from(estimate.interval.field[heat]);
            half_square += half * half * group_range(heat).len() as f64;
        }
    }
    let ratio = (half_square / size_square).sqrt();
    Ok(if ratio.is_finite() { ratio } else { f64::INFINITY })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_without_heat_states_the_other_five_groups() {
        let blob = knowing(meniscus_shipped::MODEL, all_but_heat()).expect("the shipped model");
        let bytes = AlignedBytes::copy(&blob);
        let known = Model::load(&bytes).expect("a model").header.known();
        for group in FieldGroup::ALL {
            assert_eq!(known.contains(group), group != FieldGroup::InternalEnergy, "{group:?}");
        }
    }
}
