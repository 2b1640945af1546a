//! Discovery: the effect that a simulation lacks, from measurements.

use crate::arguments::to_python;
use crate::errors::{check_range, refused, system};
use crate::interrupt::{Job, Stopped, attended};
use crate::model::Model;
use crate::simulator::{Callable, Raised};
use meniscus_discover::decision::settings::Settings;
use meniscus_discover::fitting::fit_cache::FitCache;
use meniscus_discover::insert::simulated::Resolution;
use meniscus_discover::recordings::load::{load, load_references};
use meniscus_discover::references::ReferenceSettings;
use meniscus_discover::report::html::page;
use meniscus_discover::report::scene::scene_toml;
use meniscus_discover::report::verdict_json::verdict_json;
use meniscus_discover::sizing::error::SizingError;
use meniscus_discover::sizing::stage::SizingSettings;
use meniscus_discover::sizing::workload::SimulationProgress;
use meniscus_discover::workflow::error::DiscoverError;
use meniscus_discover::workflow::inputs::{Inputs, library};
use meniscus_discover::workflow::progress::{Progress, Stage};
use meniscus_discover::workflow::{Discovery, Report};
use meniscus_platform::files::{AlignedBytes, check_writable, write_whole};
use pyo3::prelude::*;
use std::cell::Cell;
use std::path::PathBuf;
use std::sync::{Arc, PoisonError};

/// First packing less the seed, as `meniscus discover` counts them.
const FIRST_PACKING: u64 = 100;

/// Verdict of a discovery with its evidence.
#[pyclass(frozen, module = "meniscus_liquid")]
pub(crate) struct Verdict {
    report: Report,
    command: String,
}

#[pymethods]
impl Verdict {
    /// `named`, `tied`, `none` or `unknown`; the simulator's word where sizes were found by simulation.
    #[getter]
    fn word(&self) -> &'static str {
        self.report.word()
    }

    /// The verdict in a sentence or two.
    #[getter]
    fn sentence(&self) -> String {
        self.report.sentence()
    }

    /// Names of the effects that the verdict states.
    #[getter]
    fn names(&self) -> Vec<&'static str> {
        self.report.names().to_vec()
    }

    /// Class of the verdict, where one is certain.
    #[getter]
    fn effect_class(&self) -> Option<&'static str> {
        self.report.class().map(meniscus::reduced::effects::Class::words)
    }

    /// Sizes: one dictionary a parameter with `effect`, `parameter`, `unit`, `value`, `interval_90` and `by` (which model).
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.report(py)?.get_item("parameters")
    }

    /// All evidence as a dictionary: the content of verdict.json.
    #[getter(report)]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &verdict_json(&self.report))
    }

    /// The effects as a scene file for `simulate` (TOML).
    #[getter]
    fn scene_toml(&self) -> String {
        scene_toml(&self.report)
    }

    /// The model with the effects inserted, where one was given.
    #[getter]
    fn model(&self) -> PyResult<Option<Model>> {
        self.report.insertion.blob.as_ref().map(|blob| Model::of(AlignedBytes::copy(blob))).transpose()
    }

    /// The report as a page of HTML with its pictures.
    #[getter]
    fn html(&self) -> PyResult<String> {
        page(&self.report, &self.command).map_err(refused)
    }

    /// Writes report.html, verdict.json, scene.toml and, where there is one, model.blob into the folder `out`, which is made.
    fn write(&self, out: PathBuf) -> PyResult<()> {
        check_writable(&out.join("verdict.json")).map_err(system)?;
        let write = |name: &str, bytes: &[u8]| write_whole(&out.join(name), bytes).map_err(system);
        if let Some(blob) = &self.report.insertion.blob {
            write("model.blob", blob)?;
        }
        write("report.html", self.html()?.as_bytes())?;
        write("verdict.json", format!("{:#}", verdict_json(&self.report)).as_bytes())?;
        write("scene.toml", self.scene_toml().as_bytes())
    }

    fn __repr__(&self) -> String {
        format!("<Verdict: {} {}>", self.word(), self.names().join(", "))
    }
}

/// Hands the stages of a discovery on.
struct JobProgress<'a> {
    job: &'a Job,
    begun: Cell<usize>,
    stages: usize,
}

impl JobProgress<'_> {
    fn share(&self, part: f64) -> f64 {
        ((self.begun.get() as f64 - 1.0 + part) / self.stages as f64).clamp(0.0, 1.0)
    }
}

impl Progress for JobProgress<'_> {
    fn begins(&self, stage: Stage) {
        self.begun.set(self.begun.get() + 1);
        self.job.tell(stage.words(), self.share(0.0));
    }

    fn simulated(&self, progress: SimulationProgress) {
        let SimulationProgress { done, expected, .. } = progress;
        let what = format!("simulation {done} of about {expected}");
        self.job.tell(what, self.share(done as f64 / expected.max(1) as f64));
    }
}

/// Question to a discovery.
struct Question {
    recordings: PathBuf,
    reference: Option<PathBuf>,
    library: Vec<String>,
    seed: u64,
    out: Option<PathBuf>,
    quick: bool,
    spacing_mm: f64,
    rivals: usize,
    packings: usize,
    simulate: bool,
    model: Option<Vec<u8>>,
    simulator: Option<Callable>,
    raised: Raised,
}

/// Identifies the effect that a simulation lacks, as `meniscus discover` does.
///
/// Args:
///     recordings: Folder with setup.toml and the recordings (docs/formats.md); three of different strength or more.
///     reference: Folder of recordings of a known liquid in the same glass and motions, or of such folders. Without it the verdict
///         is much weaker.
///     library: Effects that may be identified; by default all.
///     seed: Seed of the bootstrap and of the packings.
///     quick: Leave the sizes by simulation out; they take minutes and need `out`. The default is True, and False with a
///         `simulator`.
///     out: Folder in which fits and simulations are kept: the same call goes on from them.
///     spacing_mm, rivals, packings, simulate: As of the command.
///     model: Model into which the effects are inserted.
///     simulator: Function that simulates the glass in place of the particle simulator: `simulator(scene)` gets a dictionary
///         (docs/simulators.md; tables are arrays) and returns an array [frames, 21] of heights, m, for each of
///         `scene["motions"]`. Without `reference` it makes the references too. It may raise `SimulationError` where this glass
///         cannot be simulated; any other exception ends the discovery and comes back as it was raised.
///     simulator_version: Text under which its results are kept in `out`; change it with the function. Without it they are not
///         used again.
///     progress: Is called as `progress(step, done)`.
///
/// Raises:
///     MeniscusError: Recordings are refused or too few, or a simulator returns wrong counts, NaN or heights outside of the glass.
#[pyfunction]
#[pyo3(signature = (recordings, reference=None, *, library=None, seed=1, quick=None, out=None, spacing_mm=5.0, rivals=1,
                    packings=2, simulate=false, model=None, simulator=None, simulator_version=None, progress=None))]
#[allow(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
pub(crate) fn discover(
    py: Python<'_>,
    recordings: PathBuf,
    reference: Option<PathBuf>,
    library: Option<Vec<String>>,
    seed: u64,
    quick: Option<bool>,
    out: Option<PathBuf>,
    spacing_mm: f64,
    rivals: usize,
    packings: usize,
    simulate: bool,
    model: Option<&Model>,
    simulator: Option<Py<PyAny>>,
    simulator_version: Option<&str>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Verdict> {
    let quick = quick.unwrap_or(simulator.is_none());
    if quick && simulator.is_some() {
        return Err(refused(
            "quick leaves all simulations out, so that the simulator has nothing to do: leave one of them out",
        ));
    }
    let raised = Raised::default();
    let simulator =
        simulator.map(|function| Callable::new(py, &function, simulator_version, &raised)).transpose()?;
    check_range("rivals", &rivals, 0..=4)?;
    check_range("packings", &packings, 1..=9)?;
    match &out {
        Some(out) => check_writable(&out.join("verdict.json")).map_err(system)?,
        None if quick => {}
        None => {
            return Err(refused(
                "sizes by simulation need a folder for the simulations: give out, or quick=True",
            ));
        }
    }
    let command = format!("meniscus_liquid.discover({:?}), seed {seed}", recordings.display().to_string());
    let question = Question {
        recordings,
        reference,
        library: library.unwrap_or_default(),
        seed,
        out,
        quick,
        spacing_mm,
        rivals,
        packings,
        simulate,
        model: model.map(|model| model.blob().to_vec()),
        simulator,
        raised,
    };
    let report = attended(py, progress, |job| answer(question, job))??;
    Ok(Verdict { report, command })
}

/// Runs one discovery.
fn answer(question: Question, job: &Job) -> PyResult<Report> {
    job.tell("reading the recordings", 0.0);
    let mut inputs = Inputs::new(load(&question.recordings).map_err(refused)?);
    inputs.settings = Settings {
        library: library(&question.library).map_err(refused)?,
        seed: question.seed,
        cache: question.out.as_ref().map(|out| Arc::new(FitCache::new(&out.join("fits")))),
        ..Settings::default()
    };
    let spacing_m = 1e-3 * question.spacing_mm;
    let seed = FIRST_PACKING + question.seed;
    inputs.simulation = question.simulate.then_some(Resolution { spacing_m, seed });
    if let Some(out) = question.out.as_ref().filter(|_| !question.quick) {
        inputs.sizing = Some(SizingSettings {
            spacing_m,
            seed,
            packings: question.packings,
            rivals: question.rivals,
            store: out.join("simulations"),
            shard: None,
        });
    }
    inputs.check().map_err(refused)?;
    if let Some(path) = &question.reference {
        inputs.references = load_references(path).map_err(refused)?;
    }
    if let Some(simulator) = question.simulator {
        let store = question.out.as_ref().filter(|_| question.reference.is_none());
        inputs.simulated_references = store.map(|out| {
            let radius_m = inputs.recordings.known.radius_m;
            ReferenceSettings::new(radius_m, question.seed, out.join("simulations"))
        });
        inputs.simulator = Box::new(simulator);
    }
    inputs.model = question.model.as_ref().map(|blob| AlignedBytes::copy(blob));
    inputs.stop = Some(job.stop);
    let stages = 4
        + usize::from(inputs.simulated_references.is_some())
        + usize::from(inputs.sizing.is_some())
        + usize::from(inputs.model.is_some())
        + usize::from(inputs.simulation.is_some());
    let progress = JobProgress { job, begun: Cell::new(0), stages };
    Discovery::run(&inputs, &progress).map_err(|error| match error {
        DiscoverError::Sizing(SizingError::Stopped) => Stopped.into(),
        other => {
            let raised = question.raised.lock().unwrap_or_else(PoisonError::into_inner).take();
            raised.unwrap_or_else(|| refused(other))
        }
    })
}
