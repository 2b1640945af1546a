//! Motions of the glass.

use crate::arguments::Numbers;
use crate::errors::refused;
use meniscus_data::motion::Motion as Course;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

/// A motion of the glass from rest to rest, exact at any time.
///
/// Args:
///     spelling: `KIND:SEED` as `strokes:7`, `KIND:SEEDxSCALE`, or the path of a CSV file (docs/formats.md).
///     seconds: Length of the recording that it is for, s; the last fifth, at most 1 s, is free decay.
///
/// Example:
///     >>> import numpy as np
///     >>> from meniscus_liquid import Motion
///     >>> motion = Motion("strokes:7", seconds=4.0)
///     >>> motion.position_m(np.array([0.0, 0.1])).tolist()
///     [0.0, 0.0]
#[pyclass(frozen, eq, module = "meniscus_liquid")]
#[derive(Clone, PartialEq)]
pub(crate) struct Motion {
    pub(crate) course: Course,
    /// Whether the spelling makes the motion again.
    pub(crate) spelled: bool,
}

#[pymethods]
impl Motion {
    #[new]
    #[pyo3(signature = (spelling, seconds=6.0))]
    fn new(spelling: &str, seconds: f64) -> PyResult<Self> {
        Ok(Self { course: Course::parse(spelling, seconds).map_err(refused)?, spelled: true })
    }

    /// Returns the motion along x through samples of time (s, rising) and position (m), joined by a cubic spline.
    #[staticmethod]
    fn sampled(time_s: Numbers<'_>, position_m: Numbers<'_>) -> PyResult<Self> {
        let (time, position) = (time_s.as_array(), position_m.as_array());
        if time.len() != position.len() {
            return Err(refused(format!("{} times for {} positions", time.len(), position.len())));
        }
        if let Some(bad) = time.iter().chain(position).find(|value| !value.is_finite()) {
            return Err(refused(format!(
                "a motion has the sample {bad}: times and positions must be finite"
            )));
        }
        let samples: Vec<(f64, f64)> = time.iter().copied().zip(position.iter().copied()).collect();
        let course = Course::sampled(&samples)
            .ok_or_else(|| refused("a sampled motion needs two samples or more, at times that rise"))?;
        Ok(Self { course, spelled: false })
    }

    /// The motion as the command line spells it; `samples` for a sampled one.
    #[getter]
    fn spelling(&self) -> &str {
        &self.course.spelling
    }

    /// Time from which the glass rests, s.
    #[getter]
    fn end_s(&self) -> f64 {
        self.course.end_s()
    }

    /// Returns the position along x at each time, m; shape of `time_s`.
    fn position_m<'py>(&self, time_s: Numbers<'py>) -> Bound<'py, PyArray1<f64>> {
        at(&time_s, |t| self.course.position(t))
    }

    /// Returns the acceleration along x at each time, m/s2; shape of `time_s`.
    fn acceleration_m_s2<'py>(&self, time_s: Numbers<'py>) -> Bound<'py, PyArray1<f64>> {
        at(&time_s, |t| self.course.acceleration(t))
    }

    fn __repr__(&self) -> String {
        format!("Motion({:?})", self.course.spelling)
    }
}

/// Returns `value` at each of `times`.
fn at<'py>(times: &PyReadonlyArray1<'py, f64>, value: impl Fn(f64) -> f64) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_iter(times.py(), times.as_array().iter().map(|&t| value(t)))
}
