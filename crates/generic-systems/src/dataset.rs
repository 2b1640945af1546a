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

use super::form::Kinds;
use nalgebra::{DMatrix, DVector};
use npyz::npz::NpzArchive;
use npyz::{DType, NpyFile, Order, TypeChar};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// Why a file of trajectories or of weights is refused.
#[derive(Debug)]
pub enum DatasetError {
    /// The file cannot be read as npz.
    File(PathBuf, std::io::Error),
    /// An array is not there.
    Missing(PathBuf, String),
    /// An array is not what it should be: which, and what is wrong.
    Array(PathBuf, String, String),
    /// There is too little to learn from: what there is.
    Few(PathBuf, String),
}

impl std::fmt::Display for DatasetError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File(path, why) => write!(f, "{} is no npz file that can be read: {why}", path.display()),
            Self::Missing(path, array) => write!(
                f,
                "{} has no array '{array}': `meniscus generic --help` lists what it must hold",
                path.display()
            ),
            Self::Array(path, array, why) => write!(f, "{}, array '{array}': {why}", path.display()),
            Self::Few(path, what) => write!(f, "{} holds too little to learn from: {what}", path.display()),
        }
    }
}

impl std::error::Error for DatasetError {}

/// An npz file that is being read.
pub(super) struct Archive {
    path: PathBuf,
    file: NpzArchive<BufReader<File>>,
}

/// The numbers of an array, the last index running fastest, and its shape.
pub(super) type Array = (Vec<f64>, Vec<usize>);

impl Archive {
    pub(super) fn open(path: &Path) -> Result<Self, DatasetError> {
        let file = NpzArchive::open(path).map_err(|why| DatasetError::File(path.into(), why))?;
        Ok(Self { path: path.into(), file })
    }

    /// Refuses array `name`.
    pub(super) fn refuse(&self, name: &str, why: String) -> DatasetError {
        DatasetError::Array(self.path.clone(), name.into(), why)
    }

    /// The array `name`, where there is one.
    pub(super) fn find(&mut self, name: &str) -> Result<Option<Array>, DatasetError> {
        let fault = |why| DatasetError::File(self.path.clone(), why);
        let Some(array) = self.file.by_name(name).map_err(fault)? else { return Ok(None) };
        let shape: Vec<usize> = array.shape().iter().map(|&n| n as usize).collect();
        let columns_first = array.order() == Order::Fortran;
        let read = numbers(array).map_err(|why| DatasetError::Array(self.path.clone(), name.into(), why))?;
        if let Some(at) = read.iter().position(|x| !x.is_finite()) {
            let why = format!("number {at} is {}", read[at]);
            return Err(DatasetError::Array(self.path.clone(), name.into(), why));
        }
        Ok(Some((if columns_first { last_fastest(&read, &shape) } else { read }, shape)))
    }

    /// The array `name`.
    pub(super) fn get(&mut self, name: &str) -> Result<Array, DatasetError> {
        self.find(name)?.ok_or_else(|| DatasetError::Missing(self.path.clone(), name.into()))
    }

    /// The one number of `name`.
    pub(super) fn number(&mut self, name: &str) -> Result<f64, DatasetError> {
        match self.get(name)?.0.as_slice() {
            [one] => Ok(*one),
            more => Err(self.refuse(name, format!("{} numbers where one is due", more.len()))),
        }
    }

    /// The array `name` as a matrix of `rows` x `columns`, where there is one.
    pub(super) fn matrix(
        &mut self,
        name: &str,
        rows: usize,
        columns: usize,
    ) -> Result<Option<DMatrix<f64>>, DatasetError> {
        let Some((values, shape)) = self.find(name)? else { return Ok(None) };
        if shape != [rows, columns] {
            return Err(self.refuse(name, format!("shape {shape:?} where [{rows}, {columns}] is due")));
        }
        Ok(Some(DMatrix::from_row_iterator(rows, columns, values)))
    }
}

/// `values` of an array whose first index runs fastest, as numpy lays out what was transposed, with the last fastest.
fn last_fastest(values: &[f64], shape: &[usize]) -> Vec<f64> {
    let place = |mut at: usize| {
        let strides = shape.iter().scan(1, |stride, n| Some(std::mem::replace(stride, *stride * n)));
        let strides: Vec<usize> = strides.collect();
        let digits = shape.iter().zip(&strides).rev().map(|(n, stride)| {
            let digit = at % n;
            at /= n;
            digit * stride
        });
        digits.sum::<usize>()
    };
    (0..values.len()).map(|at| values[place(at)]).collect()
}

/// The numbers of an array of floats or signed integers.
fn numbers<R: std::io::Read>(array: NpyFile<R>) -> Result<Vec<f64>, String> {
    let kind = match array.dtype() {
        DType::Plain(kind) => (kind.type_char(), kind.size_field()),
        other => return Err(format!("of type {}, where numbers are due", other.descr())),
    };
    let read = match kind {
        (TypeChar::Float, 8) => array.into_vec::<f64>(),
        (TypeChar::Float, 4) => array.into_vec::<f32>().map(|all| all.into_iter().map(f64::from).collect()),
        (TypeChar::Int, 8) => array.into_vec::<i64>().map(|all| all.into_iter().map(|n| n as f64).collect()),
        (TypeChar::Int, 4) => array.into_vec::<i32>().map(|all| all.into_iter().map(f64::from).collect()),
        _ => return Err("of a type other than float32, float64, int32 and int64".into()),
    };
    read.map_err(|why| why.to_string())
}

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

/// Where the numbers of a state begin and in what they are counted: x = (z - mean) / scale.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    pub(super) mean: DVector<f64>,
    /// Standard deviation, shared by what is of one kind; 1 where nothing varies.
    pub(super) scale: DVector<f64>,
    /// Whether a variable changes along any trajectory.
    pub(super) moving: Vec<bool>,
}

impl Frame {
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
