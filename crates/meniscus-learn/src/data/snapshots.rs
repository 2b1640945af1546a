//! Rest, snapshots and bases of whole recordings.

use crate::data::groups::{IN_STATE, SURFACE};
use crate::data::pod::{Basis, Truncation};
use crate::hyperparameters::PodParameters;
use meniscus::latent::decoder::GROUP_COMPONENTS;
use meniscus::surface::POINTS;
use meniscus_data::recording::{Recording, STATE, TRACERS, group_range};
use nalgebra::DMatrix;

/// The first frame of a recording, where nothing has moved.
pub(crate) fn rest_of(recording: &Recording) -> Vec<f32> {
    let mut rest = vec![0.0; STATE];
    recording.state(0, &mut rest);
    rest
}

/// Writes the difference of one frame from rest into `out`.
pub(crate) fn fluctuation(recording: &Recording, frame: usize, rest: &[f32], out: &mut [f32]) {
    recording.state(frame, out);
    out.iter_mut().zip(rest).for_each(|(f, r)| *f -= r);
}

/// Mean of the first frames: state and profile.
pub(crate) fn mean_rest(training: &[Recording]) -> (Vec<f32>, Vec<f32>) {
    let share = 1.0 / training.len() as f32;
    let (mut state, mut profile) = (vec![0.0; STATE], vec![0.0; POINTS]);
    for recording in training {
        state.iter_mut().zip(rest_of(recording)).for_each(|(m, r)| *m += share * r);
        profile.iter_mut().zip(recording.profile(0)).for_each(|(m, r)| *m += share * r);
    }
    (state, profile)
}

/// Evenly spread frames in which the liquid moves, as (recording, frame).
pub(crate) fn pick(training: &[Recording], parameters: &PodParameters) -> Vec<(usize, usize)> {
    let total = |r: &Recording, n: usize| r.energy[n].kinetic + r.energy[n].potential;
    let all = || training.iter().enumerate().flat_map(|(i, r)| (0..r.frames()).map(move |n| (i, n)));
    let most = all().map(|(i, n)| total(&training[i], n)).fold(0.0, f64::max);
    let moving: Vec<_> =
        all().filter(|&(i, n)| total(&training[i], n) > parameters.moving_energy_share * most).collect();
    let stride = moving.len().div_ceil(parameters.max_snapshots).max(1);
    moving.into_iter().step_by(stride).collect()
}

/// One basis for each trunk group from the picked frames.
pub(crate) fn decompose(
    training: &[Recording],
    picked: &[(usize, usize)],
    parameters: &PodParameters,
) -> Vec<Basis> {
    let mut snapshots: Vec<DMatrix<f32>> =
        IN_STATE.iter().map(|&g| DMatrix::zeros(GROUP_COMPONENTS[g] * TRACERS, picked.len())).collect();
    snapshots.push(DMatrix::zeros(POINTS, picked.len()));
    let rests: Vec<Vec<f32>> = training.iter().map(rest_of).collect();
    let mut field = vec![0.0; STATE];
    for (column, &(r, n)) in picked.iter().enumerate() {
        fluctuation(&training[r], n, &rests[r], &mut field);
        for (matrix, &g) in snapshots.iter_mut().zip(&IN_STATE) {
            matrix.column_mut(column).copy_from_slice(&field[group_range(g)]);
        }
        let surface = training[r].profile(n).iter().zip(training[r].profile(0)).map(|(z, z0)| z - z0);
        snapshots[SURFACE].column_mut(column).iter_mut().zip(surface).for_each(|(s, z)| *s = z);
    }
    let tolerance = parameters.tolerance;
    let pairs = snapshots.iter().zip(parameters.max_modes);
    pairs.map(|(matrix, most)| Basis::new(matrix, Truncation { most, tolerance })).collect()
}
