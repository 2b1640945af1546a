//! Trajectories of a closed system, from an npz file as numpy writes it.
//!
//! | array | shape | |
//! |---|---|---|
//! | `Z` | `[trajectory, variable, step]` | states, float32 or float64, in any units |
//! | `dt` | one number | time between two steps, s |
//! | `train_idx`, `test_idx` | integers | which trajectories are learnt from and judged by; without them a fifth is drawn for judging |
//! | `L` | `[variable, variable]`, skew | the reversible operator where it is known; without it, it is learnt |
//! | `M` | `[variable, variable]` | its rows that are not zero are the variables with friction; without it, all |
//! | `t` | `[.., step]` | times; steps of `Z` beyond their count are not used |
//!
//! All but `Z` and `dt` may be absent. A variable that never changes along a trajectory is taken for a parameter.

use super::archive::{Archive, DatasetError};
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use std::path::Path;

/// The trajectories of one system.
#[derive(Clone, Debug)]
pub struct Dataset {
    /// The file's name without its ending.
    pub name: String,
    /// Time between two steps, s.
    pub dt_s: f64,
    /// `paths[trajectory][step]`.
    pub paths: Vec<Vec<DVector<f64>>>,
    /// Trajectories that are learnt from.
    pub training: Vec<usize>,
    /// Trajectories that judge.
    pub test: Vec<usize>,
    /// L, where it is known.
    pub skew: Option<DMatrix<f64>>,
    /// M, where it is known.
    pub friction: Option<DMatrix<f64>>,
}

impl Dataset {
    /// Reads `path`; where the file does not say which trajectories judge, a fifth of them is drawn from `seed`.
    ///
    /// # Errors
    /// [`DatasetError`], which names the array and what is wrong with it.
    pub fn read(path: &Path, seed: u64) -> Result<Self, DatasetError> {
        let mut archive = Archive::open(path)?;
        let (z, shape) = archive.get("Z")?;
        let [count, variables, recorded] = shape[..] else {
            return Err(
                archive.refuse("Z", format!("shape {shape:?}, where [trajectory, variable, step] is due"))
            );
        };
        let timed = archive.find("t")?.and_then(|(_, shape)| shape.last().copied());
        let steps = timed.unwrap_or(recorded).min(recorded);
        let dt_s = archive.number("dt")?;
        if dt_s <= 0.0 {
            return Err(archive.refuse("dt", format!("{dt_s} s between two steps")));
        }
        let state = |path: usize, step: usize| {
            DVector::from_fn(variables, |i, _| z[(path * variables + i) * recorded + step])
        };
        let paths: Vec<Vec<_>> =
            (0..count).map(|path| (0..steps).map(|step| state(path, step)).collect()).collect();
        let mut listed = |name: &str| -> Result<Option<Vec<usize>>, DatasetError> {
            let Some((values, _)) = archive.find(name)? else { return Ok(None) };
            match values.iter().find(|&&k| k < 0.0 || k >= count as f64) {
                Some(k) => Err(archive.refuse(name, format!("trajectory {k} of {count}"))),
                None => Ok(Some(values.into_iter().map(|k| k as usize).collect())),
            }
        };
        let (mut training, mut test) = match (listed("train_idx")?, listed("test_idx")?) {
            (Some(training), Some(test)) => (training, test),
            _ => drawn(count, seed),
        };
        training.sort_unstable();
        test.sort_unstable();
        if let Some(both) = test.iter().find(|k| training.contains(k)) {
            return Err(archive.refuse("test_idx", format!("trajectory {both} is also learnt from")));
        }
        if training.len() < 3 || test.is_empty() || steps < 10 {
            let what = format!(
                "{} trajectories to learn from, {} to judge by, {steps} steps; three, one and ten are the least",
                training.len(),
                test.len()
            );
            return Err(DatasetError::Few(path.into(), what));
        }
        let skew = archive.matrix("L", variables, variables)?;
        if let Some(l) = skew.as_ref().filter(|l| (*l + l.transpose()).amax() > 1e-9 * l.amax()) {
            let worst = (l + l.transpose()).amax();
            return Err(archive.refuse("L", format!("not skew: L + L^T reaches {worst}")));
        }
        let friction = archive.matrix("M", variables, variables)?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { name, dt_s, paths, training, test, skew, friction })
    }

    /// Variables of a state.
    #[must_use]
    pub fn variables(&self) -> usize {
        self.paths.first().and_then(|path| path.first()).map_or(0, DVector::len)
    }
}

/// A fifth of `count` trajectories for judging, the others for learning.
fn drawn(count: usize, seed: u64) -> (Vec<usize>, Vec<usize>) {
    let mut all: Vec<usize> = (0..count).collect();
    all.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    let test = all.split_off(count - count / 5);
    (all, test)
}
