//! Scene files: a glass, a liquid, its effects and a motion.

use crate::errors::refused;
use crate::glass::Glass;
use crate::liquid::on;
use meniscus_data::scene_file::Experiment;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};

/// A scene: glass, liquid, motion, spacing and effects of a simulation. What the file leaves out is `None`.
///
/// Args:
///     path: Scene file (TOML), as `meniscus simulate --scene` takes it.
///
/// Example:
///     >>> from meniscus_liquid import Scene
///     >>> Scene.parse("liquid = 'honey'\n[effects]\nsurface_tension = 0.055").effects
///     {'surface_tension': 0.055}
#[pyclass(frozen, module = "meniscus_liquid")]
#[derive(Clone)]
pub(crate) struct Scene {
    pub(crate) experiment: Experiment,
    pub(crate) path: Option<PathBuf>,
}

#[pymethods]
impl Scene {
    #[new]
    fn new(path: PathBuf) -> PyResult<Self> {
        Ok(Self { experiment: Experiment::load(&path).map_err(refused)?, path: Some(path) })
    }

    /// Returns the scene that the TOML `text` describes; `origin` names it in errors.
    #[staticmethod]
    #[pyo3(signature = (text, origin="text"))]
    fn parse(text: &str, origin: &str) -> PyResult<Self> {
        Ok(Self { experiment: Experiment::parse(Path::new(origin), text).map_err(refused)?, path: None })
    }

    /// The glass.
    #[getter]
    fn glass(&self) -> Option<Glass> {
        self.experiment.glass.map(Glass)
    }

    /// The liquid, by name or path.
    #[getter]
    fn liquid(&self) -> Option<&str> {
        self.experiment.liquid.as_deref()
    }

    /// The motion, as the command line spells it.
    #[getter]
    fn motion(&self) -> Option<&str> {
        self.experiment.motion.as_deref()
    }

    /// Spacing of the particles, mm.
    #[getter]
    fn spacing_mm(&self) -> Option<f64> {
        self.experiment.spacing_mm
    }

    /// Effects that are on, by name, SI units.
    #[getter]
    fn effects<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        on(py, &self.experiment.effects)
    }

    fn __repr__(&self) -> String {
        self.path.as_ref().map_or("Scene.parse(...)".into(), |path| format!("Scene({path:?})"))
    }
}
