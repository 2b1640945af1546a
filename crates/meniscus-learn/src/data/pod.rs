//! Truncated proper orthogonal decomposition of each field group, by the method of snapshots
//! (Sirovich 1987): the T x T matrix of inner products instead of the 6402 x 6402 covariance.

use nalgebra::{DMatrix, SymmetricEigen};

/// Largest number of modes of a group, and the error at which fewer are enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Truncation {
    /// Most modes kept.
    pub(crate) most: usize,
    /// Relative L2 error that is good enough.
    pub(crate) tolerance: f64,
}

/// An orthonormal basis of one group.
#[derive(Clone, Debug)]
pub(crate) struct Basis {
    /// `width` x `rank`, column-major: one mode after the other.
    pub(crate) modes: DMatrix<f32>,
    /// Relative L2 error of the truncation over the snapshots.
    pub(crate) left_out: f64,
}

impl Basis {
    /// Basis of `snapshots` (one column each, fluctuations about the rest state).
    ///
    /// With S = X V sqrt(l)^-1 and X^T X V = V l, the columns of S are orthonormal, and the first k
    /// leave out sqrt(sum_{i > k} l_i / sum l_i) of the norm.
    #[must_use]
    pub(crate) fn new(snapshots: &DMatrix<f32>, truncation: Truncation) -> Self {
        let exact = snapshots.map(f64::from);
        let eigen = SymmetricEigen::new(exact.transpose() * exact);
        let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        let energy: Vec<f64> = order.iter().map(|&i| eigen.eigenvalues[i].max(0.0)).collect();
        let total: f64 = energy.iter().sum();
        // Modes below single-precision noise have no direction of their own.
        let meaningful = energy.iter().take_while(|&&l| l > 1e-11 * total).count();
        let left =
            |rank: usize| (energy.iter().skip(rank).sum::<f64>() / total.max(f64::MIN_POSITIVE)).sqrt();
        let enough = (1..=meaningful).find(|&rank| left(rank) <= truncation.tolerance).unwrap_or(meaningful);
        let rank = enough.min(truncation.most);
        let weights = DMatrix::from_fn(snapshots.ncols(), rank, |row, mode| {
            (eigen.eigenvectors[(row, order[mode])] / energy[mode].sqrt()) as f32
        });
        Self { modes: snapshots * weights, left_out: left(rank) }
    }

    /// Number of modes.
    #[must_use]
    pub(crate) fn rank(&self) -> usize {
        self.modes.ncols()
    }

    /// Coefficients of `field`, appended to `out`: c = S^T f.
    pub(crate) fn project(&self, field: &[f32], out: &mut Vec<f32>) {
        for mode in self.modes.column_iter() {
            out.push(mode.iter().zip(field).map(|(m, f)| m * f).sum());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three modes of known strength: what is left out is known in closed form.
    #[test]
    fn error_left_out_is_the_tail_of_the_spectrum() {
        let (width, count) = (50, 40);
        let strength = [10.0, 1.0, 0.1];
        let snapshots = DMatrix::from_fn(width, count, |i, t| {
            let space = |k: usize| (std::f64::consts::TAU * (k + 1) as f64 * i as f64 / width as f64).sin();
            let time = |k: usize| (std::f64::consts::TAU * (k + 1) as f64 * t as f64 / count as f64).cos();
            (0..3).map(|k| strength[k] * space(k) * time(k)).sum::<f64>() as f32
        });
        let basis = Basis::new(&snapshots, Truncation { most: 2, tolerance: 0.0 });
        assert_eq!(basis.rank(), 2);
        let expected = (0.01_f64 / (100.0 + 1.0 + 0.01)).sqrt();
        assert!((basis.left_out - expected).abs() < 1e-4 * expected.max(1e-2), "{}", basis.left_out);

        // The same error, measured by projecting and rebuilding.
        let mut wrong = 0.0;
        for column in snapshots.column_iter() {
            let mut c = Vec::new();
            basis.project(column.as_slice(), &mut c);
            let rebuilt = &basis.modes * nalgebra::DVector::from_vec(c);
            wrong += (column - rebuilt).norm_squared();
        }
        let measured = (f64::from(wrong) / f64::from(snapshots.norm_squared())).sqrt();
        assert!((measured - expected).abs() < 1e-4, "{measured} against {expected}");
    }

    #[test]
    fn rank_stops_where_the_tolerance_is_met() {
        let snapshots = DMatrix::from_fn(20, 10, |i, t| if i == t { 0.5_f32.powi(t as i32) } else { 0.0 });
        let basis = Basis::new(&snapshots, Truncation { most: 10, tolerance: 0.3 });
        // sum_{i >= k} 4^-i / sum 4^-i = 4^-k <= 0.09 first at k = 2.
        assert_eq!(basis.rank(), 2);
    }
}
