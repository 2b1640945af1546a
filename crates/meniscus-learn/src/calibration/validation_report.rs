//! The figures of a trained model on the validation recordings, baselines beside them.

use crate::calibration::learnt_model::LearntModel;
use crate::data::errors::{GroupErrors, percent, persistence};
use crate::data::groups::TRUNK;
use crate::data::trajectory::Track;
use crate::networks::encoded::EncodedRecordings;
use crate::operators::open_loop::HORIZON;
use meniscus::latent::generic::Latent;
use meniscus_report::checks::Check;

/// Asked of a part: nothing.
const OPEN: [Option<f64>; 5] = [None; 5];

/// The figures of every part; those of the estimate are the blob's ([`crate::calibration::intervals`]).
pub(crate) fn checks(model: &LearntModel, held: &EncodedRecordings, tracks: &[Track]) -> Vec<Check> {
    let frame = &model.frame;
    let over = |latents: &dyn Fn(usize) -> Vec<Latent>, ports: &dyn Fn(usize) -> Vec<f64>| {
        let mut errors = GroupErrors::default();
        for (k, sequence) in held.sequences.iter().enumerate() {
            errors.add(frame, sequence, 0, &model.autoencoder.decode(&latents(k), frame), &ports(k));
        }
        errors
    };
    let (true_port, read_port) =
        (|k: usize| held.sequences[k].port.clone(), |k: usize| tracks[k].port.clone());
    let rolled = |roll_out: &dyn Fn(Latent, &[f64]) -> Vec<Latent>| {
        let mut errors = GroupErrors::default();
        for (sequence, path) in held.sequences.iter().zip(&held.paths) {
            for from in (0..sequence.frames().saturating_sub(HORIZON / 2)).step_by(HORIZON / 2) {
                let to = (from + 1 + HORIZON).min(sequence.frames());
                let latents = roll_out(path.x[from], &path.u[from + 1..to]);
                let coefficients = model.autoencoder.decode(&latents, frame);
                errors.add(frame, sequence, from + 1, &coefficients, &sequence.port[from + 1..to]);
            }
        }
        errors
    };
    let mut checks = vec![
        percent(String::from("flat: surface slosh-rel"), 1.0, None),
        percent(
            String::from("persistence, one frame: surface slosh-rel"),
            persistence(&held.sequences),
            None,
        ),
    ];
    let linear = rolled(&|x, u| model.linear.roll_out(x, u));
    checks.extend(linear.checks("linear with motion, 2 s roll-out", OPEN));
    checks.extend(over(&|k| held.latents[k].clone(), &true_port).checks("decoder alone", OPEN));
    checks.extend(over(&|k| tracks[k].y.clone(), &read_port).checks("encoder, camera noise", OPEN));
    checks.extend(
        rolled(&|x, u| model.dynamics.roll_out(x, u)).checks("GENERIC with motion, 2 s roll-out", OPEN),
    );
    for (group, basis) in TRUNK.iter().zip(&frame.bases) {
        let name = format!("POD: {group} left out of {} modes", basis.rank());
        checks.push(percent(name, basis.left_out, None));
    }
    let [work, heat] = work_and_heat(model, held);
    checks.push(percent(String::from("work of a roll-out from rest against the books"), work, None));
    checks.push(percent(String::from("heat of a roll-out from rest against the books"), heat, None));
    checks.push(percent(
        String::from("energy of the latent state against the books"),
        books(model, held),
        None,
    ));
    checks
}

/// Relative L2 error of H(x) against kinetic plus potential energy.
fn books(model: &LearntModel, held: &EncodedRecordings) -> f64 {
    let pairs = held.paths.iter().flat_map(|p| p.x.iter().zip(&p.energy));
    let (miss, size) = pairs.fold((0.0, 0.0), |(miss, size), (x, &e)| {
        (miss + (model.dynamics.energy(x) - e).powi(2), size + e * e)
    });
    (miss / size.max(f64::MIN_POSITIVE)).sqrt()
}

/// Relative errors of the work and the heat of whole recordings, rolled out from rest with known motion.
fn work_and_heat(model: &LearntModel, held: &EncodedRecordings) -> [f64; 2] {
    let (mut said, mut due) = ([0.0; 2], [0.0; 2]);
    for (sequence, path) in held.sequences.iter().zip(&held.paths) {
        for turn in model.dynamics.turns(Latent::zeros(), &path.u) {
            said[0] += model.frame.energy_scale_j * turn.work;
            said[1] += model.frame.energy_scale_j * turn.heat;
        }
        due[0] += sequence.work_j.last().copied().unwrap_or(0.0);
        due[1] += sequence.heat_j.last().copied().unwrap_or(0.0);
    }
    [0, 1].map(|k| (said[k] - due[k]).abs() / due[k].abs().max(f64::MIN_POSITIVE))
}
