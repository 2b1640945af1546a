//! Estimates: of one turn, of many, and of turns to come.

use crate::errors::{check_output, refused};
use crate::recording::stored;
use crate::views::view;
use meniscus::latent::generic::LATENTS;
use meniscus::runtime::{Estimate as Turned, Forecast as Ahead, Mode};
use meniscus::surface::POINTS;
use meniscus::uncertainty::latent_covariance::COVARIANCE_ENTRIES;
use meniscus_data::recording::{EstimateRecording, GROUP_COMPONENTS, GROUP_NAMES, TRACERS, group_names};
use numpy::ndarray::{Array3, ArrayView1, ArrayView2};
use numpy::{PyArray1, PyArray2, PyArray3, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// Names of the modes, by their number in files.
const MODES: [&str; 4] = ["filling", "tracking", "coasting", "halted"];

fn number(mode: Mode) -> u8 {
    match mode {
        Mode::Filling => 0,
        Mode::Tracking => 1,
        Mode::Coasting => 2,
        Mode::Halted => 3,
    }
}

/// Estimate of one turn. Half-widths hold nine times of ten (docs/evaluation). What the model does not know is NaN.
#[pyclass(frozen, module = "meniscus_liquid")]
pub(crate) struct Estimate {
    turned: Turned,
    field: Vec<f32>,
    groups: Vec<usize>,
}

impl Estimate {
    pub(crate) fn of(turned: Turned, field: Vec<f32>, groups: &[usize]) -> Self {
        Self { turned, field, groups: groups.to_vec() }
    }

    /// Returns the group called `name`, 2134 x components.
    fn group(&self, name: &str) -> PyResult<ArrayView2<'_, f32>> {
        let mut start = 0;
        for group in &self.groups {
            let components = GROUP_COMPONENTS[*group];
            if GROUP_NAMES[*group] == name {
                let numbers = self.field.get(start..start + TRACERS * components).ok_or_else(|| {
                    refused(format!(
                        "this turn has no field: its mode is {}",
                        MODES[usize::from(number(self.turned.mode))]
                    ))
                })?;
                return ArrayView2::from_shape((TRACERS, components), numbers).map_err(refused);
            }
            start += TRACERS * components;
        }
        let decoded: Vec<&str> = self.groups.iter().map(|group| GROUP_NAMES[*group]).collect();
        Err(refused(format!(
            "the estimator does not decode the field '{name}': it decodes {}",
            decoded.join(", ")
        )))
    }
}

#[pymethods]
impl Estimate {
    /// Validity: `filling` (too few frames yet), `tracking`, `coasting` (no measurement this turn) or `halted`.
    #[getter]
    fn mode(&self) -> &'static str {
        MODES[usize::from(number(self.turned.mode))]
    }

    /// Reduced state, [13].
    #[getter]
    fn latent<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        view(slf, |this| Ok(ArrayView1::from(&this.turned.latent)))
    }

    /// Error covariance of the reduced state, [13, 13].
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let at = |(row, column)| self.turned.covariance.at(row, column);
        Ok(numpy::ndarray::Array2::from_shape_fn((LATENTS, LATENTS), at).to_pyarray(py))
    }

    /// Heights of the surface above the inner bottom, m, [21].
    #[getter]
    fn surface_m<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<f32>>> {
        view(slf, |this| Ok(ArrayView1::from(&this.turned.surface_m)))
    }

    /// Half-widths of the heights, m, [21].
    #[getter]
    fn surface_half_m<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<f32>>> {
        view(slf, |this| Ok(ArrayView1::from(&this.turned.interval.surface_m)))
    }

    /// Half-width of one number of each field group, SI units.
    #[getter]
    fn group_half<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (name, half) in GROUP_NAMES.iter().zip(self.turned.interval.field) {
            dict.set_item(name, half)?;
        }
        Ok(dict)
    }

    /// Acceleration of the glass that entered the step, m/s2.
    #[getter]
    fn acceleration_m_s2(&self) -> f32 {
        self.turned.acceleration_m_s2
    }

    /// Slosh energy, J.
    #[getter]
    fn slosh_j(&self) -> f64 {
        self.turned.slosh_j
    }

    /// Heat since the start, J.
    #[getter]
    fn heat_j(&self) -> f64 {
        self.turned.heat_j
    }

    /// Change of the slosh energy by the measurement, J.
    #[getter]
    fn corrected_j(&self) -> f64 {
        self.turned.corrected_j
    }

    /// Books of the predicting step in units of the energy H: work of the port, heat, and the residual of the balance.
    #[getter]
    fn audit<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (dict, audit) = (PyDict::new(py), &self.turned.audit);
        dict.set_item("work", audit.work)?;
        dict.set_item("heat", audit.heat)?;
        dict.set_item("residual", audit.energy_residual)?;
        Ok(dict)
    }

    /// Names of the fields that this turn has; none before the start and in a halt.
    #[getter]
    fn fields(&self) -> Vec<&'static str> {
        if self.field.is_empty() {
            Vec::new()
        } else {
            self.groups.iter().map(|group| GROUP_NAMES[*group]).collect()
        }
    }

    /// Returns one field on the tracers, [2134, components], SI units, as `Recording.field` has it.
    fn field<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyArray2<f32>>> {
        view(slf, |this| this.group(name))
    }

    fn __repr__(&self) -> String {
        format!("<Estimate, {}, slosh {:.3e} J>", self.mode(), self.turned.slosh_j)
    }
}

/// The surface some turns from now.
#[pyclass(frozen, module = "meniscus_liquid")]
pub(crate) struct Forecast(pub(crate) Ahead);

#[pymethods]
impl Forecast {
    /// Heights above the inner bottom, m, [21].
    #[getter]
    fn surface_m<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<f32>>> {
        view(slf, |this| Ok(ArrayView1::from(&this.0.surface_m)))
    }

    /// Half-widths that hold nine times of ten, m, [21].
    #[getter]
    fn half_width_m<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<f32>>> {
        view(slf, |this| Ok(ArrayView1::from(&this.0.half_width_m)))
    }
}

/// Estimates of many turns as arrays; N is the number of turns. `meniscus run --estimates FILE` writes such a file.
///
/// Example:
///     >>> from meniscus_liquid import Estimator, Recording
///     >>> estimates = Estimator().track(Recording.shipped().profiles()[:60])
///     >>> estimates.latent.shape, estimates.covariance().shape
///     ((60, 13), (60, 13, 13))
#[pyclass(frozen, module = "meniscus_liquid")]
pub(crate) struct Estimates(pub(crate) EstimateRecording);

/// Returns `all` as turns x `columns`.
fn rows<T>(all: &[T], columns: usize) -> PyResult<ArrayView2<'_, T>> {
    ArrayView2::from_shape((all.len() / columns, columns), all).map_err(refused)
}

#[pymethods]
impl Estimates {
    /// Reads the estimates at `path`; every type and shape is checked.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        EstimateRecording::load(&path).map(Self).map_err(stored)
    }

    /// Writes the estimates to `path`, whole or not at all.
    #[pyo3(signature = (path, *, overwrite=false))]
    fn save(&self, path: PathBuf, overwrite: bool) -> PyResult<()> {
        check_output(&path, overwrite)?;
        self.0.save(&path).map_err(stored)
    }

    fn __len__(&self) -> usize {
        self.0.turns()
    }

    /// Command of the run.
    #[getter]
    fn command(&self) -> &str {
        &self.0.command
    }

    /// Version of the model.
    #[getter]
    fn model_version(&self) -> u64 {
        self.0.model_version
    }

    /// Field groups that the model is valid for.
    #[getter]
    fn known(&self) -> Vec<&'static str> {
        group_names(self.0.known)
    }

    /// Mode of each turn: `filling`, `tracking`, `coasting` or `halted`.
    #[getter]
    fn mode(&self) -> Vec<&'static str> {
        self.0.mode.iter().map(|mode| MODES.get(usize::from(*mode)).copied().unwrap_or("unknown")).collect()
    }

    /// Instant of each turn on the camera's clock, microseconds, [N].
    #[getter]
    fn camera_us<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<u64>>> {
        view(slf, |this| Ok(ArrayView1::from(&this.0.camera_us)))
    }

    /// Frame counter of the camera, -1 where the frame was lost, [N].
    #[getter]
    fn sequence<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<i64>>> {
        view(slf, |this| Ok(ArrayView1::from(&this.0.sequence)))
    }

    /// Reduced state, [N, 13].
    #[getter]
    fn latent<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        view(slf, |this| rows(&this.0.latent, LATENTS))
    }

    /// Returns the error covariance of the reduced state, [N, 13, 13], unpacked from its lower triangle.
    fn covariance<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray3<f32>> {
        let packed = |row: usize, column: usize| row * (row + 1) / 2 + column;
        let at = |(turn, row, column): (usize, usize, usize)| {
            self.0.covariance[turn * COVARIANCE_ENTRIES + packed(row.max(column), row.min(column))]
        };
        Array3::from_shape_fn((self.0.turns(), LATENTS, LATENTS), at).to_pyarray(py)
    }

    /// Heights of the surface, m, [N, 21].
    #[getter]
    fn surface_m<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        view(slf, |this| rows(&this.0.surface_m, POINTS))
    }

    /// Half-widths of the heights that hold nine times of ten, m, [N, 21].
    #[getter]
    fn surface_half_m<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        view(slf, |this| rows(&this.0.surface_half_m, POINTS))
    }

    /// Half-width of one number of q, v, e, sigma and tau, SI units, [N, 5].
    #[getter]
    fn group_half<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        view(slf, |this| rows(&this.0.group_half, 5))
    }

    /// Acceleration of the glass that entered the step, m/s2, [N].
    #[getter]
    fn acceleration_m_s2<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<f32>>> {
        view(slf, |this| Ok(ArrayView1::from(&this.0.acceleration_m_s2)))
    }

    /// Slosh energy, heat, and energy of the correction, J, [N, 3].
    #[getter]
    fn energy_j<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        view(slf, |this| rows(&this.0.energy_j, 3))
    }

    /// Work, heat and residual of the predicting step in units of the energy H, [N, 3].
    #[getter]
    fn audit<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        view(slf, |this| rows(&this.0.audit, 3))
    }
}
