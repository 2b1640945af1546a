//! Trivial answers that a trained net has to beat, judged as the nets are.

use nalgebra::{DMatrix, DVector};

/// Relative error of roll-outs: the root mean square over the variables of |z - said| / |z - mean of z|.
pub(crate) fn relative_error(truth: &[&[DVector<f64>]], said: &[Vec<DVector<f64>>]) -> f64 {
    let all: Vec<&DVector<f64>> = truth.iter().copied().flatten().collect();
    let square = |z: DVector<f64>| z.component_mul(&z);
    let mean = all.iter().fold(all[0] * 0.0, |sum, z| sum + *z) / all.len() as f64;
    let spread = all.iter().fold(&mean * 0.0, |sum, z| sum + square(*z - &mean));
    let error = all.iter().zip(said.iter().flatten()).fold(&mean * 0.0, |sum, (z, y)| sum + square(*z - y));
    error.component_div(&spread).mean().sqrt()
}

/// The linear model z' = A z + b with the least squares over all steps of `paths`.
pub(crate) struct Linear(DMatrix<f64>);

impl Linear {
    pub(crate) fn fit<'a>(paths: impl Iterator<Item = &'a [DVector<f64>]>) -> Self {
        let steps: Vec<&[DVector<f64>]> = paths.flat_map(|path| path.windows(2)).collect();
        let n = steps[0][0].len();
        let before = DMatrix::from_fn(steps.len(), n + 1, |k, i| if i < n { steps[k][0][i] } else { 1.0 });
        let after = DMatrix::from_fn(steps.len(), n, |k, i| steps[k][1][i]);
        Self(before.svd(true, true).solve(&after, 1e-12).expect("a solution").transpose())
    }

    pub(crate) fn roll_out(&self, first: &DVector<f64>, count: usize) -> Vec<DVector<f64>> {
        let next = |z: &DVector<f64>| &self.0 * z.clone().push(1.0);
        std::iter::successors(Some(first.clone()), |z| Some(next(z))).take(count).collect()
    }
}
