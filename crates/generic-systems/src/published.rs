//! A published structure-preserving net, replayed from its weights.
//!
//! ```text
//! (A, B) = net(z),  DE = A z,  DS = B z,  z' = z + dt (L DE + M DS),   z = (state - mean) / std
//! ```
//! (Hernandez et al., J. Comput. Phys. 426 (2021) 109950.) The npz file holds W0, W1, .. and b0, b1, .. as PyTorch
//! stores them, ReLU between the layers, `mean`, `std`, `L`, `M` and `dt`; A comes before B, row by row.

use super::archive::{Archive, DatasetError};
use nalgebra::{DMatrix, DVector};
use std::path::Path;

/// A published net.
#[derive(Clone, Debug)]
pub struct Published {
    layers: Vec<(DMatrix<f64>, DVector<f64>)>,
    mean: DVector<f64>,
    std: DVector<f64>,
    /// L, in the net's scaled coordinates.
    pub(super) skew: DMatrix<f64>,
    /// M, in the net's scaled coordinates.
    pub(super) friction: DMatrix<f64>,
    /// dt, s.
    pub(super) dt_s: f64,
}

/// Output of the net at one state.
#[derive(Clone, Debug)]
pub struct Said {
    /// DE.
    pub energy: DVector<f64>,
    /// DS.
    pub entropy: DVector<f64>,
    /// The state after the step.
    pub next: DVector<f64>,
}

impl Published {
    /// Reads the weights in `path`.
    ///
    /// # Errors
    /// [`DatasetError`], which names the array and what is wrong with it.
    pub fn read(path: &Path) -> Result<Self, DatasetError> {
        let mut archive = Archive::open(path)?;
        let mean = DVector::from_vec(archive.get("mean")?.0);
        let (n, mut inputs) = (mean.len(), mean.len());
        let mut layers = Vec::new();
        loop {
            let name = format!("W{}", layers.len());
            let Some((values, shape)) = archive.find(&name)? else { break };
            let [outputs, columns] = shape[..] else {
                return Err(archive.refuse(&name, format!("shape {shape:?}, where [outputs, inputs] is due")));
            };
            if columns != inputs {
                return Err(archive.refuse(&name, format!("{columns} inputs where {inputs} come")));
            }
            let bias = archive.get(&format!("b{}", layers.len()))?.0;
            if bias.len() != outputs {
                return Err(archive.refuse(&name, format!("{outputs} outputs, but {} biases", bias.len())));
            }
            layers.push((DMatrix::from_row_iterator(outputs, columns, values), DVector::from_vec(bias)));
            inputs = outputs;
        }
        if inputs != 2 * n * n {
            let why = format!("the last layer gives {inputs} numbers, where A and B have {}", 2 * n * n);
            return Err(archive.refuse("W0, W1, ..", why));
        }
        let std = DVector::from_vec(archive.get("std")?.0);
        if std.len() != n || std.iter().any(|&s| s <= 0.0) {
            return Err(archive.refuse("std", format!("{n} positive numbers are due")));
        }
        let mut square = |name: &str| -> Result<DMatrix<f64>, DatasetError> {
            let found = archive.matrix(name, n, n)?;
            found.ok_or_else(|| DatasetError::Missing(path.into(), name.into()))
        };
        let (skew, friction) = (square("L")?, square("M")?);
        Ok(Self { layers, mean, std, skew, friction, dt_s: archive.number("dt")? })
    }

    /// Variables of a state.
    #[must_use]
    pub fn variables(&self) -> usize {
        self.mean.len()
    }

    /// Output of the net at the scaled state `z`.
    #[must_use]
    pub fn say(&self, z: &DVector<f64>) -> Said {
        let (n, last) = (z.len(), self.layers.len() - 1);
        let out = self.layers.iter().enumerate().fold(z.clone(), |x, (k, (w, b))| {
            let y = w * x + b;
            if k < last { y.map(|a| a.max(0.0)) } else { y }
        });
        let square = |from: usize| DMatrix::from_row_slice(n, n, &out.as_slice()[from..from + n * n]);
        let (energy, entropy) = (square(0) * z, square(n * n) * z);
        let next = z + (&self.skew * &energy + &self.friction * &entropy) * self.dt_s;
        Said { energy, entropy, next }
    }

    /// A state in the net's coordinates.
    pub(super) fn inward(&self, state: &DVector<f64>) -> DVector<f64> {
        (state - &self.mean).component_div(&self.std)
    }

    /// The way back.
    pub(super) fn outward(&self, z: &DVector<f64>) -> DVector<f64> {
        z.component_mul(&self.std) + &self.mean
    }
}

impl Published {
    /// `count` states from `state` on, that one first, in its units.
    #[must_use]
    pub fn roll_out(&self, state: &DVector<f64>, count: usize) -> Vec<DVector<f64>> {
        let ahead = std::iter::successors(Some(self.inward(state)), |z| Some(self.say(z).next));
        ahead.take(count).map(|z| self.outward(&z)).collect()
    }
}
