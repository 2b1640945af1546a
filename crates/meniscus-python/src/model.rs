//! Weight blobs: facts, validity by field group, tensors.

use crate::errors::{check_output, refused, system};
use meniscus::blob::{LoadError, Model as Weights};
use meniscus_data::blob_file::read::parts;
use meniscus_data::recording::GROUP_NAMES;
use meniscus_data::validity::Validity;
use meniscus_platform::files::{AlignedBytes, write_whole};
use numpy::ndarray::Array2;
use numpy::{PyArray2, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use self_cell::self_cell;
use std::path::PathBuf;

self_cell!(
    /// A blob and the model that reads its weights in place.
    struct Loaded {
        owner: AlignedBytes,
        #[covariant]
        dependent: Weights,
    }
);

/// A weight blob: the model of one liquid in one glass. Every check of the program has passed.
///
/// Args:
///     path: A blob of `meniscus train`, `correct` or `insert`; by default the glycerine model inside the package.
///
/// Raises:
///     OSError: The file cannot be read.
///     MeniscusError: It is no blob, is damaged, or does not fit this version.
///
/// Example:
///     >>> from meniscus_liquid import Model
///     >>> Model().liquid
///     'glycerine'
#[pyclass(frozen, module = "meniscus_liquid")]
pub(crate) struct Model(Loaded);

impl Model {
    /// Returns the model of the blob in `bytes`.
    pub(crate) fn of(bytes: AlignedBytes) -> PyResult<Self> {
        Self::checked(bytes).map_err(refused)
    }

    fn checked(bytes: AlignedBytes) -> Result<Self, LoadError> {
        Loaded::try_new(bytes, |bytes| Weights::load(bytes)).map(Self)
    }

    pub(crate) fn weights(&self) -> &Weights<'_> {
        self.0.borrow_dependent()
    }

    pub(crate) fn blob(&self) -> &AlignedBytes {
        self.0.borrow_owner()
    }
}

#[pymethods]
impl Model {
    #[new]
    #[pyo3(signature = (path=None))]
    fn new(path: Option<PathBuf>) -> PyResult<Self> {
        match path {
            None => Self::of(AlignedBytes::copy(meniscus_shipped::MODEL)),
            Some(path) => {
                let bytes = AlignedBytes::read(&path).map_err(system)?;
                Self::checked(bytes).map_err(|error| refused(format!("{}: {error}", path.display())))
            }
        }
    }

    /// Returns the model of the blob in `data`, as `bytes(model)` gives it.
    #[staticmethod]
    fn from_bytes(data: &[u8]) -> PyResult<Self> {
        Self::of(AlignedBytes::copy(data))
    }

    fn __bytes__<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, self.blob())
    }

    /// Writes the blob to `path`, whole or not at all.
    #[pyo3(signature = (path, *, overwrite=false))]
    fn save(&self, path: PathBuf, overwrite: bool) -> PyResult<()> {
        check_output(&path, overwrite)?;
        write_whole(&path, self.blob()).map_err(system)
    }

    /// Liquid that the model was trained on, or corrected to.
    #[getter]
    fn liquid(&self) -> String {
        self.weights().header.liquid.to_string()
    }

    /// Commands, seeds and revision that made the model.
    #[getter]
    fn provenance(&self) -> String {
        self.weights().header.provenance.to_string()
    }

    /// Version: whatever makes a model from another one raises it.
    #[getter]
    fn version(&self) -> u64 {
        self.weights().header.model_version
    }

    /// Inner radius of its glass, m.
    #[getter]
    fn radius_m(&self) -> f64 {
        self.weights().header.radius_m
    }

    /// Height of the liquid at rest, m.
    #[getter]
    fn fill_m(&self) -> f64 {
        self.weights().header.fill_m
    }

    /// Height of the rim, m.
    #[getter]
    fn rim_m(&self) -> f64 {
        self.weights().header.rim_m
    }

    /// Time step of a turn, s.
    #[getter]
    fn dt_s(&self) -> f64 {
        self.weights().header.dt_s
    }

    /// Field groups whose errors are known for the liquid, with the embedded effects taken into account.
    #[getter]
    fn known(&self) -> Vec<&'static str> {
        Validity::of(&self.weights().header).names()
    }

    /// Cause and remedy for the groups that are not known; `None` where all are.
    #[getter]
    fn validity(&self) -> Option<String> {
        Validity::of(&self.weights().header).sentence
    }

    /// Relative error of the surface on the recordings that it was validated with, as trained: slosh-relative error, 1.
    #[getter]
    fn validation_slosh_rel(&self) -> f32 {
        self.weights().header.validation_slosh_rel
    }

    /// Embedded effects by name, each a list of the values that the blob holds.
    #[getter]
    fn effects<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for effect in self.weights().header.embedded.iter().flat_map(|embedded| &embedded.effects) {
            dict.set_item(effect.name.as_str(), effect.values.to_vec())?;
        }
        Ok(dict)
    }

    /// Names of the field groups in file order.
    #[classattr]
    const GROUPS: [&'static str; 5] = GROUP_NAMES;

    /// Returns every tensor by its name, [rows, columns], float32, unpacked from the type that it is stored in.
    fn tensors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (_, parts) = parts(self.blob()).map_err(refused)?;
        let dict = PyDict::new(py);
        for part in parts {
            let array = Array2::from_shape_vec((part.rows, part.columns), part.values).map_err(refused)?;
            let array: Bound<'_, PyArray2<f32>> = array.to_pyarray(py);
            dict.set_item(format!("{:?}", part.tensor), array)?;
        }
        Ok(dict)
    }

    fn __repr__(&self) -> String {
        let header = &self.weights().header;
        format!(
            "<Model of {}, version {}, known: {}>",
            header.liquid,
            header.model_version,
            self.known().join(", ")
        )
    }
}
