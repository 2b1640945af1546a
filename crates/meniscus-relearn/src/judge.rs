//! Errors and coverage of a model on simulated recordings that no stage saw.
//!
//! The model sees them through the simulated camera (2 mm of depth noise). Errors of a group are relative to the fluctuation,
//! root mean square over the recordings; sigma is taken one frame late, when the camera has measured the acceleration that it
//! follows.

use crate::error::RelearnError;
use meniscus::blob::{FieldGroup, Model};
use meniscus_data::recording::Recording;
use meniscus_learn::evaluate::{Trial, trial};
use meniscus_platform::files::AlignedBytes;
use meniscus_report::checks::Check;
use meniscus_virtual::observe_recording::{DISPARITY_RMS_PX, sightings};
use meniscus_virtual::render::SceneSettings;

/// Targets of the groups q, v, e, sigma (one frame late) and tau, per cent.
const GROUP_TARGETS: [f64; 5] = [7.0, 10.0, 25.0, 20.0, 20.0];

/// Target of the estimated surface relative to the slosh, and of the forecast 250 ms ahead under a planned motion, per cent.
const SURFACE_TARGETS: [f64; 2] = [4.0, 8.0];

/// Share of the numbers that 90 % intervals should contain, per cent.
const COVERAGE: [f64; 2] = [85.0, 95.0];

/// Figures of a model.
#[derive(Clone, Debug)]
pub struct Judged {
    /// Errors, coverage and laws, against their targets.
    pub checks: Vec<Check>,
    /// Seconds and height of the highest point over the fill, mm: the true one and the estimated one, of the first recording.
    pub crests: [Vec<(f64, f64)>; 2],
}

/// Judges `blob` on `recordings`; `seed` draws the camera's noise.
///
/// # Errors
/// [`RelearnError`], when the blob is refused or a glass cannot be seen.
pub fn judge(blob: &[u8], recordings: &[Recording], seed: u64) -> Result<Judged, RelearnError> {
    let blob = AlignedBytes::copy(blob);
    let model = Model::load(&blob)?;
    let mut trials = Vec::new();
    for (k, recording) in (0..).zip(recordings) {
        let scene = SceneSettings {
            disparity_rms_px: DISPARITY_RMS_PX,
            seed: seed + 2000 + k,
            ..SceneSettings::of(&recording.glass)
        };
        trials.push(trial(&model, recording, &sightings(recording, scene)?));
    }
    let crests = trials.first().map_or_else(Default::default, |first| {
        let at = |estimated: bool| {
            let error = |height_error_m: f64| if estimated { height_error_m } else { 0.0 };
            first.peaks.iter().map(|p| (p.time_s, 1e3 * (p.height_m + error(p.height_error_m)))).collect()
        };
        [at(false), at(true)]
    });
    Ok(Judged { checks: checks(&model, &trials), crests })
}

/// Root mean square of `of` over `trials`.
fn rms(trials: &[Trial], of: impl Fn(&Trial) -> f64) -> f64 {
    (trials.iter().map(|trial| of(trial).powi(2)).sum::<f64>() / trials.len() as f64).sqrt()
}

/// Mean of `of` over `trials`.
fn mean(trials: &[Trial], of: impl Fn(&Trial) -> f64) -> f64 {
    trials.iter().map(of).sum::<f64>() / trials.len() as f64
}

/// All figures of `trials`; those of groups that the model does not know are absent.
fn checks(model: &Model<'_>, trials: &[Trial]) -> Vec<Check> {
    let known = model.header.known();
    let mut checks = Vec::new();
    let names = ["held_q", "held_v", "held_e", "held_sigma_frame_late", "held_tau"];
    for (index, (group, name)) in FieldGroup::ALL.into_iter().zip(names).enumerate() {
        if known.contains(group) {
            let error = rms(trials, |trial| match group {
                FieldGroup::NormalStress => trial.score.late_sigma,
                _ => trial.score.field[index],
            });
            checks.push(Check::at_most(name, 100.0 * error, "%", GROUP_TARGETS[index]));
        }
    }
    if known.contains(FieldGroup::NormalStress) {
        let now = rms(trials, |trial| trial.score.field[FieldGroup::NormalStress as usize]);
        checks.push(Check::informational("held_sigma", 100.0 * now, "%"));
    }
    let [surface, planned] = SURFACE_TARGETS;
    let of_surface = rms(trials, |trial| trial.score.estimate.slosh_rel());
    checks.push(Check::at_most("held_surface", 100.0 * of_surface, "%", surface));
    let of_planned = rms(trials, |trial| trial.planned.forecast[0]);
    checks.push(Check::at_most("held_planned_250ms", 100.0 * of_planned, "%", planned));
    let [least, most] = COVERAGE;
    let mut coverage = |name: String, share: f64| {
        checks.push(Check::within(name, 100.0 * share, "%", least, most));
    };
    coverage("coverage_surface".into(), mean(trials, |trial| trial.score.held.share()));
    coverage("coverage_planned_250ms".into(), mean(trials, |trial| trial.planned.held[0].share()));
    for (index, (group, name)) in FieldGroup::ALL.into_iter().zip(["q", "v", "e", "sigma", "tau"]).enumerate()
    {
        if known.contains(group) {
            coverage(format!("coverage_{name}"), mean(trials, |trial| trial.score.field_held[index].share()));
        }
    }
    let falls: usize = trials.iter().map(|trial| trial.entropy_falls).sum();
    checks.push(Check::exactly("entropy_falls", falls as f64, "1", 0.0));
    let shown: usize = trials.iter().map(|trial| trial.unknown_shown.len()).sum();
    checks.push(Check::exactly("unknown_groups_shown", shown as f64, "1", 0.0));
    checks.push(Check::informational("held_out_recordings", trials.len() as f64, "1"));
    checks
}
