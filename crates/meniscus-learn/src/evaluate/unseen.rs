//! A model on one recording of its own liquid that nothing was chosen by.

use super::{EvaluateError, Trial, look, percent, sources, trial};
use meniscus::blob::{FieldGroup, Model};
use meniscus_data::recording::Recording;
use meniscus_platform::files::AlignedBytes;
use meniscus_report::checks::Check;
use meniscus_score::field_error::GroupError;

/// Largest slosh-relative error of the source liquid, its surface and its groups q, v, e, sigma, tau, %.
pub(super) const TARGET: (f64, [f64; 5]) = (8.0, [6.0, 7.0, 5.0, 9.0, 8.0]);

/// The same without any knowledge of the motion: surface, v.
pub(super) const BLIND: [f64; 2] = [15.0, 20.0];

/// Mean and largest error of the height, %.
const HEIGHT: [f64; 2] = [0.25, 1.5];

/// Errors of the surface and of the groups that the model knows, under the name of `liquid`.
pub(super) fn errors(liquid: &str, trial: &Trial) -> Vec<Check> {
    let slosh = percent(trial.score.estimate.slosh_rel());
    let mut checks = vec![Check::at_most(format!("{liquid}_slosh_rel"), slosh, "%", TARGET.0)];
    for GroupError { group, name, error, .. } in trial.score.known_field() {
        let target = TARGET.1[group as usize];
        checks.push(Check::at_most(format!("{liquid}_field_{name}"), percent(error), "%", target));
    }
    if trial.score.known.contains(FieldGroup::NormalStress) {
        // A frame later the camera has measured the acceleration that sigma follows; beside the target of the present.
        let late = percent(trial.score.late_sigma);
        checks.push(Check::informational(format!("{liquid}_field_sigma_frame_late"), late, "%"));
    }
    checks
}

/// Figures of `blob` on `recording` through the simulated camera (depth noise 2 mm, drawn from `seed`), with the
/// motion tracked by the camera and, as `motion_none`, without any.
///
/// # Errors
/// [`EvaluateError`], when the blob is refused or the glass cannot be looked at.
pub fn unseen(blob: &[u8], recording: &Recording, seed: u64) -> Result<Vec<Check>, EvaluateError> {
    let aligned = AlignedBytes::copy(blob);
    let model = Model::load(&aligned)?;
    let seen = look(recording, seed)?;
    let trial = trial(&model, recording, &seen);
    let liquid = recording.provenance.liquid.as_str();
    let surface = &trial.score.estimate;
    let mut checks = errors(liquid, &trial);
    checks.push(Check::at_most(format!("{liquid}_mean"), percent(surface.mean()), "%", HEIGHT[0]));
    checks.push(Check::at_most(format!("{liquid}_max"), percent(surface.max), "%", HEIGHT[1]));
    for source in sources(&model, recording, &seen, seed) {
        if source.name == "none" {
            let slosh = percent(source.score.estimate.slosh_rel());
            checks.push(Check::at_most("motion_none_slosh_rel", slosh, "%", BLIND[0]));
            let v = source.score.known_field().find(|one| one.group == FieldGroup::Velocity);
            let v = v.map(|v| Check::at_most("motion_none_field_v", percent(v.error), "%", BLIND[1]));
            checks.extend(v);
        }
    }
    checks.push(Check::within("interval_coverage", percent(trial.score.held.share()), "%", 85.0, 95.0));
    checks.push(Check::exactly(format!("{liquid}_entropy_falls"), trial.entropy_falls as f64, "1", 0.0));
    checks.push(Check::at_most(format!("{liquid}_energy_drift_step"), trial.energy_drift, "H", 1e-6));
    Ok(checks)
}
