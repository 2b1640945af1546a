//! The internal energy as a group of its own: the shipped model carries it by the balance, the paper's nets decode it.

use super::net::{Net, Rows};
use crate::data::pod::{Basis, Truncation};
use crate::data::snapshots::{fluctuation, pick, rest_of};
use crate::hyperparameters::PodParameters;
use meniscus_data::recording::{Recording, STATE, group_range};
use nalgebra::DMatrix;

/// A basis of the change of the internal energy since rest, and the scale of its coefficients.
pub(super) struct Energy {
    basis: Basis,
    scale: f32,
}

impl Energy {
    /// From the frames in which the liquid moves.
    pub(super) fn new(training: &[Recording], parameters: &PodParameters) -> Self {
        let picked = pick(training, parameters);
        let rests: Vec<Vec<f32>> = training.iter().map(rest_of).collect();
        let mut snapshots = DMatrix::zeros(group_range(2).len(), picked.len());
        let mut field = vec![0.0; STATE];
        for (column, &(r, n)) in picked.iter().enumerate() {
            fluctuation(&training[r], n, &rests[r], &mut field);
            snapshots.column_mut(column).copy_from_slice(&field[group_range(2)]);
        }
        let basis = Basis::new(&snapshots, Truncation { most: 24, tolerance: 1e-3 });
        let mut energy = Self { basis, scale: 1.0 };
        let rows = energy.rows(training);
        let square: f64 = rows.values.iter().map(|c| f64::from(*c).powi(2)).sum();
        energy.scale = (square / rows.count().max(1) as f64).sqrt().max(1e-12) as f32;
        energy
    }

    /// Coefficients over the scale, row by row.
    pub(super) fn rows(&self, recordings: &[Recording]) -> Rows {
        let (mut values, mut field) = (Vec::new(), vec![0.0; STATE]);
        for recording in recordings {
            let rest = rest_of(recording);
            for n in 0..recording.frames() {
                fluctuation(recording, n, &rest, &mut field);
                self.basis.project(&field[group_range(2)], &mut values);
            }
        }
        values.iter_mut().for_each(|c| *c /= self.scale);
        Rows { values, width: self.basis.rank().max(1) }
    }

    /// Relative L2 error of what `net` makes of `recordings`, with what the basis leaves out.
    pub(super) fn error(&self, net: &Net, recordings: &[Recording]) -> f64 {
        let (mut miss, mut size) = (0.0, 0.0);
        for recording in recordings {
            let rows = self.rows(std::slice::from_ref(recording));
            let [again, _] = net.run(&rows);
            let (rest, mut field) = (rest_of(recording), vec![0.0; STATE]);
            let pairs = again.chunks_exact(rows.width).zip(rows.values.chunks_exact(rows.width));
            for (n, (said, truth)) in pairs.enumerate() {
                fluctuation(recording, n, &rest, &mut field);
                // The basis is orthonormal: |f - S c|^2 = |c_f - c|^2 + |f|^2 - |c_f|^2.
                let norm2: f64 = field[group_range(2)].iter().map(|e| f64::from(*e).powi(2)).sum();
                let scale2 = f64::from(self.scale).powi(2);
                let inside: f64 = said.iter().zip(truth).map(|(s, t)| f64::from(s - t).powi(2)).sum();
                let kept: f64 = truth.iter().map(|t| f64::from(*t).powi(2)).sum();
                miss += scale2 * inside + (norm2 - scale2 * kept).max(0.0);
                size += norm2;
            }
        }
        (miss / size.max(f64::MIN_POSITIVE)).sqrt()
    }
}
