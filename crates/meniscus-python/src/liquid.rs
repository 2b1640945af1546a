//! Liquids and effects by name.

use crate::errors::refused;
use meniscus::reduced::effects::{LIBRARY, Simulator};
use meniscus_data::liquids::{Liquid as Known, known};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A liquid at 20 degrees Celsius unless its file says otherwise.
///
/// Args:
///     name: One of `liquids()`, or the path of a liquid file (TOML).
///
/// Example:
///     >>> from meniscus_liquid import Liquid
///     >>> Liquid("glycerine").density_kg_m3
///     1261.0
#[pyclass(frozen, eq, module = "meniscus_liquid")]
#[derive(Clone, PartialEq)]
pub(crate) struct Liquid(pub(crate) Known);

#[pymethods]
impl Liquid {
    #[new]
    fn new(name: &str) -> PyResult<Self> {
        Known::load(name).map(Self).map_err(refused)
    }

    /// Returns the liquid that the TOML `text` describes; `origin` names it in errors.
    #[staticmethod]
    #[pyo3(signature = (text, origin="text"))]
    fn parse(text: &str, origin: &str) -> PyResult<Self> {
        Known::parse(origin, text).map(Self).map_err(refused)
    }

    /// Name as in its file.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// Density, kg/m3.
    #[getter]
    fn density_kg_m3(&self) -> f64 {
        self.0.density_kg_m3
    }

    /// Consistency k of the Herschel-Bulkley law, Pa s^n; the viscosity of a Newtonian liquid, Pa s.
    #[getter]
    fn consistency_pa_sn(&self) -> f64 {
        self.0.rheology.consistency
    }

    /// Flow index n.
    #[getter]
    fn index(&self) -> f64 {
        self.0.rheology.index
    }

    /// Yield stress, Pa.
    #[getter]
    fn yield_stress_pa(&self) -> f64 {
        self.0.rheology.yield_stress
    }

    /// Effects that belong to the liquid, by name, SI units.
    #[getter]
    fn effects<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        on(py, &self.0.effects)
    }

    /// Returns the viscosity at the shear rate `rate_1_s`, Pa s.
    fn viscosity_pa_s(&self, rate_1_s: f64) -> f64 {
        self.0.rheology.viscosity(rate_1_s)
    }

    fn __repr__(&self) -> String {
        format!("Liquid({:?})", self.0.name)
    }
}

/// Returns the names of the liquids that the program knows.
#[pyfunction]
pub(crate) fn liquids() -> Vec<&'static str> {
    known().collect()
}

/// Returns the parameters of `effects` that are on, by their spelling.
pub(crate) fn on<'py>(
    py: Python<'py>,
    effects: &meniscus_data::effects::Effects,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (parameter, value) in effects.on() {
        dict.set_item(parameter.spelling, value)?;
    }
    Ok(dict)
}

/// Returns the effects that the program knows, one dictionary a parameter: `name` (as functions take it), `effect`, `class`,
/// `unit` and `range` of the SI value, `meaning`, `about`, and whether it is `simulated`.
#[pyfunction]
pub(crate) fn effects(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    let mut out = Vec::new();
    for effect in LIBRARY.iter() {
        let taken = match effect.simulator {
            Simulator::Law(law) => law.parameters(),
            Simulator::Absent(_) => 0,
        };
        for (n, parameter) in effect.parameters.iter().enumerate() {
            let dict = PyDict::new(py);
            dict.set_item("name", parameter.spelling)?;
            dict.set_item("effect", effect.name)?;
            dict.set_item("class", effect.class.words())?;
            dict.set_item("unit", parameter.unit)?;
            dict.set_item("range", parameter.admissible)?;
            dict.set_item("meaning", parameter.meaning)?;
            dict.set_item("about", effect.about)?;
            dict.set_item("simulated", n < taken)?;
            out.push(dict);
        }
    }
    Ok(out)
}
