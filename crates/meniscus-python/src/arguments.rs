//! Arguments that several functions take: effects, a model, JSON out.

use crate::errors::refused;
use meniscus_data::effects::Effects;
use numpy::{AllowTypeChange, PyArrayLike1, PyArrayLike2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value;

/// Numbers in a row: any array or sequence that numpy makes float64 of.
pub(crate) type Numbers<'py> = PyArrayLike1<'py, f64, AllowTypeChange>;

/// Numbers in rows and columns, likewise.
pub(crate) type Table<'py> = PyArrayLike2<'py, f64, AllowTypeChange>;

/// Effects as Python spells them: `{"surface_tension": 0.063, "contact_line": (0.02, 0.0005)}`, SI units.
pub(crate) fn effects(
    spelled: Option<&Bound<'_, PyDict>>,
    onto: Effects,
) -> PyResult<(Effects, Vec<String>)> {
    let (mut effects, mut texts) = (onto, Vec::new());
    for (name, value) in spelled.into_iter().flatten() {
        let name: String = name.extract()?;
        let values: Vec<f64> = match value.extract::<f64>() {
            Ok(one) => vec![one],
            Err(_) => value.extract().map_err(|_| {
                refused(format!(
                    "effect {name}: its value must be a number or a sequence of numbers, SI units"
                ))
            })?,
        };
        let values: Vec<String> = values.iter().map(f64::to_string).collect();
        let text = format!("{name}={}", values.join(","));
        effects.parse(&text).map_err(refused)?;
        texts.push(text);
    }
    Ok((effects, texts))
}

/// Returns a JSON value as Python's own objects.
pub(crate) fn to_python<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (value.to_string(),))
}
