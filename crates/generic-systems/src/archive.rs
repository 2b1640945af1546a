//! Named arrays of an npz file as matrices and numbers, with errors that name the array.

use nalgebra::DMatrix;
use npyz::npz::NpzArchive;
use npyz::{DType, NpyFile, Order, TypeChar};
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
