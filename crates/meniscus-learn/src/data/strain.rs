//! Shear stress as the linear image of the velocity.
//!
//! ```text
//! tau = eta(rate) (grad v + grad v^T)          generalised Newtonian; of a constant eta linear in v
//! G = <tau c^T> <c c^T>^-1                      by least squares over the snapshots, c the coefficients of v
//! ```
//! G holds the gradient at the tracers, their stretching by the surface and the stress of the simulator. Its columns, made
//! orthonormal to the modes of tau that are there already, extend the basis.

use crate::data::pod::Basis;
use nalgebra::{DMatrix, DVector};

/// Ridge on the coefficients of the velocity, relative to their mean square.
const RIDGE: f64 = 1e-6;

/// Smallest length of a direction that is new, relative to its length before what is known was taken out.
const NEW_SHARE: f32 = 0.05;

/// G, one column a mode of the velocity, from snapshots of tau and of v with the modes of v.
pub(crate) fn image(tau: &DMatrix<f32>, v: &DMatrix<f32>, modes: &Basis) -> DMatrix<f32> {
    let coefficients = modes.modes.tr_mul(v).map(f64::from);
    let mut square = &coefficients * coefficients.transpose();
    let ridge = RIDGE * square.trace() / square.nrows() as f64;
    (0..square.nrows()).for_each(|k| square[(k, k)] += ridge);
    let Some(factor) = square.cholesky() else { return DMatrix::zeros(tau.nrows(), coefficients.nrows()) };
    // G^T = <c c^T>^-1 c tau^T, so that tau is weighed by <c c^T>^-1 c, one row a mode.
    let weights = factor.solve(&coefficients).map(|w| w as f32);
    tau * weights.transpose()
}

/// `basis` of tau with the directions of `image` that it lacks, the strongest in the snapshots first, up to `most` modes.
pub(crate) fn extended(basis: &Basis, image: &DMatrix<f32>, tau: &DMatrix<f32>, most: usize) -> Basis {
    let mut modes: Vec<DVector<f32>> = basis.modes.column_iter().map(|mode| mode.into_owned()).collect();
    for direction in image.column_iter() {
        let mut left = direction.into_owned();
        let before = left.norm();
        // Twice: once leaves rounding of the size of the small remainder.
        for _ in 0..2 {
            for mode in &modes {
                let along = mode.dot(&left);
                left.axpy(-along, mode, 1.0);
            }
        }
        let length = left.norm();
        if modes.len() < most && length > NEW_SHARE * before && length > 0.0 {
            modes.push(left / length);
        }
    }
    let modes = DMatrix::from_columns(&modes);
    let kept = modes.tr_mul(tau).norm_squared();
    let left_out = (1.0 - f64::from(kept) / f64::from(tau.norm_squared())).max(0.0).sqrt();
    Basis { modes, left_out }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::pod::Truncation;
    use crate::data::snapshots::{fluctuation, rest_of};
    use meniscus_data::recording::{Recording, STATE, group_range};
    use std::path::Path;

    /// tau = A v plus a part of its own: the image is A on the modes, and the extended basis holds both.
    #[test]
    fn image_of_a_linear_law_is_that_law() {
        let wave = |a: usize, b: usize, n: usize| (0.13 * (a + 1) as f32 * (b + 2 * n + 1) as f32).sin();
        let law = DMatrix::from_fn(30, 20, |i, j| wave(i, j, 3));
        let v = DMatrix::from_fn(20, 40, |i, t| wave(i, t, 1));
        let own = DMatrix::from_fn(30, 40, |i, t| 1e-3 * wave(i, 5 * t, 7));
        let tau = &law * &v + &own;
        let modes = Basis::new(&v, Truncation { most: 20, tolerance: 1e-4 });
        let image = image(&tau, &v, &modes);
        let due = &law * &modes.modes;
        assert!((&image - &due).norm() < 0.02 * due.norm(), "{} of {}", (&image - &due).norm(), due.norm());
        let short = Basis::new(&tau, Truncation { most: 2, tolerance: 0.0 });
        let long = extended(&short, &image, &tau, 30);
        let square = long.modes.tr_mul(&long.modes);
        assert!((&square - DMatrix::identity(square.nrows(), square.ncols())).norm() < 1e-4, "orthonormal");
        assert!(long.rank() > short.rank() && long.left_out < 0.02, "{} left out", long.left_out);
    }

    /// Snapshots of a group, every `stride`-th frame.
    fn snapshots(recordings: &[Recording], group: usize, stride: usize) -> DMatrix<f32> {
        let mut columns = Vec::new();
        let mut field = vec![0.0; STATE];
        for recording in recordings {
            let rest = rest_of(recording);
            for frame in (20..recording.frames()).step_by(stride) {
                fluctuation(recording, frame, &rest, &mut field);
                columns.push(DVector::from_column_slice(&field[group_range(group)]));
            }
        }
        DMatrix::from_columns(&columns)
    }

    /// What a basis leaves out of held-out tau: more modes, modes by the velocity, and the velocity alone. Measured on the
    /// recordings of a folder of `meniscus learn`: MENISCUS_LEARNED=DIR cargo test -p meniscus-learn strain -- --ignored --nocapture
    #[test]
    #[ignore = "a measurement on recordings that take minutes to make"]
    fn what_velocity_modes_bring_to_tau() {
        let folder =
            std::env::var("MENISCUS_LEARNED").expect("MENISCUS_LEARNED names a folder of `meniscus learn`");
        let load = |prefix: &str| -> Vec<Recording> {
            let entries = Path::new(&folder).join("recordings").read_dir().expect("recordings");
            let mut files: Vec<_> = entries.map(|entry| entry.expect("an entry").path()).collect();
            files.retain(|f| f.file_name().is_some_and(|name| name.to_string_lossy().starts_with(prefix)));
            files.sort();
            files.iter().map(|file| Recording::load(file).expect("a recording")).collect()
        };
        let (training, held) = (load("train-"), load("held-"));
        let stride = (training.len() * 220).div_ceil(500).max(1);
        let [v, tau] = [1, 4].map(|group| snapshots(&training, group, stride));
        let [v_held, tau_held] = [1, 4].map(|group| snapshots(&held, group, 4));
        let left = |basis: &Basis| {
            let kept = basis.modes.tr_mul(&tau_held).norm_squared();
            100.0 * (1.0 - f64::from(kept) / f64::from(tau_held.norm_squared())).sqrt()
        };
        let pod = |most: usize| Basis::new(&tau, Truncation { most, tolerance: 0.0 });
        for most in [12, 24, 36, 48, 72, 96] {
            println!("{most} modes of tau leave out {:.1} % of held-out tau", left(&pod(most)));
        }
        for of_velocity in [24, 48] {
            let modes = Basis::new(&v, Truncation { most: of_velocity, tolerance: 0.0 });
            let image = image(&tau, &v, &modes);
            let said = &image * modes.modes.tr_mul(&v_held);
            let alone = 100.0 * (said - &tau_held).norm() / tau_held.norm();
            println!("true velocity on {of_velocity} modes: tau has an error of {alone:.1} %");
            let long = extended(&pod(24), &image, &tau, 200);
            println!(
                "24 modes of tau and the images of {of_velocity} of v ({} in all) leave out {:.1} %",
                long.rank(),
                left(&long)
            );
        }
    }
}
