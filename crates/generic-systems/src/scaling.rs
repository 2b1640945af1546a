//! Scaling of states: origin and unit of every variable, from the trajectories that are learnt from.

use super::dataset::Dataset;
use super::kinds::Kinds;
use nalgebra::DVector;

/// Origin and unit of every variable: x = (z - mean) / scale.
#[derive(Clone, Debug)]
pub(super) struct Scaling {
    pub(super) mean: DVector<f64>,
    /// Standard deviation, shared by what is of one kind; 1 where nothing varies.
    pub(super) scale: DVector<f64>,
    /// Whether a variable changes along any trajectory.
    pub(super) moving: Vec<bool>,
}

impl Scaling {
    /// Of the trajectories that `data` is learnt from. Points share one scale, momenta one, entropies one; points and
    /// momenta are counted from where they are, so that directions and distances stay what they are.
    pub(super) fn of(data: &Dataset, kinds: &Kinds) -> Self {
        let paths = || data.training.iter().map(|&k| &data.paths[k]);
        let count = paths().map(Vec::len).sum::<usize>() as f64;
        let zero = DVector::zeros(data.variables());
        let mut mean = paths().flatten().fold(zero.clone(), |sum, z| sum + z) / count;
        for &i in kinds.points.iter().chain(&kinds.momenta).flatten() {
            mean[i] = 0.0;
        }
        let mut square = paths().flatten().fold(zero, |sum, z| sum + (z - &mean).map(|d| d * d)) / count;
        for group in [kinds.points.concat(), kinds.momenta.concat(), kinds.entropies.clone()] {
            let shared = group.iter().map(|&i| square[i]).sum::<f64>() / group.len().max(1) as f64;
            group.iter().for_each(|&i| square[i] = shared);
        }
        let scale = square.map(|s| if s > 0.0 { s.sqrt() } else { 1.0 });
        let moving = (0..data.variables())
            .map(|i| paths().any(|path| path.iter().any(|z| (z[i] - path[0][i]).abs() > 1e-9 * scale[i])))
            .collect();
        Self { mean, scale, moving }
    }

    pub(super) fn inward(&self, z: &DVector<f64>) -> DVector<f64> {
        (z - &self.mean).component_div(&self.scale)
    }

    pub(super) fn outward(&self, x: &DVector<f64>) -> DVector<f64> {
        x.component_mul(&self.scale) + &self.mean
    }
}
