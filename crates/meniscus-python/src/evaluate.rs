//! Evaluation: a model on liquids that it does not know, before and after correction.

use crate::arguments::to_python;
use crate::errors::{refused, system};
use crate::interrupt::{Job, Stopped, attended};
use crate::model::Model;
use meniscus_learn::TrainError;
use meniscus_learn::evaluate::{COURSES, EvaluateError, Study, Watch, checks, report, study};
use meniscus_platform::files::{AlignedBytes, check_writable};
use meniscus_report::Report;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// A model on other liquids, before and after correction.
#[pyclass(frozen, module = "meniscus_liquid")]
pub(crate) struct Evaluation {
    study: Study,
    report: Report,
}

#[pymethods]
impl Evaluation {
    /// Figures: one dictionary each with `name`, `value`, `unit`, `target` and `ok`, as of `meniscus evaluate --json`.
    #[getter]
    fn checks<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.report.json())?.get_item("checks")
    }

    /// Corrected models by liquid.
    #[getter]
    fn models<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let models = PyDict::new(py);
        for result in &self.study.results {
            let blob = AlignedBytes::copy(&result.corrected.blob);
            models.set_item(result.course.name, Py::new(py, Model::of(blob)?)?)?;
        }
        Ok(models)
    }

    /// The report as Markdown.
    #[getter]
    fn markdown(&self) -> String {
        self.report.markdown()
    }

    /// The report as a page of HTML.
    #[getter]
    fn html(&self) -> String {
        self.report.html()
    }
}

/// Hands the tasks of a study on.
struct JobWatch<'a>(&'a Job);

impl Watch for JobWatch<'_> {
    fn tell(&mut self, what: &str, done: f64) {
        self.0.tell(what, done);
    }

    fn quiet(&self) -> bool {
        true
    }
}

/// Evaluates a model on other liquids, before and after correction, as `meniscus evaluate` does, to the bit. It takes minutes.
///
/// Args:
///     model: The model; by default the one in the package.
///     recordings: Folder of the recordings, LIQUID/KIND-SEED.safetensors. Missing ones are simulated into it and stay there.
///     liquids: Only these liquids of the study; by default all.
///     seed: Seed of all random draws.
///     progress: Is called as `progress(task, done)`.
///
/// Raises:
///     MeniscusError: A liquid is not of the study, or a recording or the model is refused.
#[pyfunction]
#[pyo3(signature = (model=None, recordings=PathBuf::from("data"), *, liquids=None, seed=1, progress=None))]
pub(crate) fn evaluate(
    py: Python<'_>,
    model: Option<&Model>,
    recordings: PathBuf,
    liquids: Option<Vec<String>>,
    seed: u64,
    progress: Option<Py<PyAny>>,
) -> PyResult<Evaluation> {
    let liquids = liquids.unwrap_or_default();
    for name in &liquids {
        let known = COURSES.map(|course| course.name);
        if !known.contains(&name.as_str()) {
            return Err(refused(format!(
                "no liquid of the study is called '{name}': take {}",
                known.join(", ")
            )));
        }
    }
    check_writable(&recordings.join("x")).map_err(system)?;
    let blob = AlignedBytes::copy(model.map_or(meniscus_shipped::MODEL, |model| &model.blob()[..]));
    let study = attended(py, progress, |job| {
        study(&blob, &recordings, &liquids, seed, job.stop, &mut JobWatch(job)).map_err(|error| match error {
            EvaluateError::Correction(TrainError::Interrupted) => Stopped.into(),
            other => refused(other),
        })
    })??;
    let named = if model.is_some() { "a model" } else { "shipped" };
    let command = format!("meniscus evaluate --model {named} --seed {seed}");
    let report = report(&study, &checks(&study), &command).map_err(refused)?;
    Ok(Evaluation { study, report })
}
