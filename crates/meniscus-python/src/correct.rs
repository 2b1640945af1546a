//! Correction: a model learns another liquid from its free surface.

use crate::arguments::to_python;
use crate::errors::{check_range, refused};
use crate::interrupt::{Stopped, attended};
use crate::model::Model;
use crate::profile::Profile;
use crate::recording::Recording;
use meniscus::blob::Model as Weights;
use meniscus_data::recording::Recording as Recorded;
use meniscus_learn::TrainError;
use meniscus_learn::correct::liquid::{SOURCE_SEED, corrected_name, is_own, looks};
use meniscus_learn::correct::{
    Corrected, Correction as How, CorrectionParameters, Sightings, correct as learn,
};
use meniscus_platform::files::AlignedBytes;
use meniscus_report::checks::Check;
use pyo3::prelude::*;
use serde_json::json;
use std::sync::atomic::AtomicBool;

/// Recording of the new liquid: of the simulator, or the profiles that a camera saw in each frame interval.
#[derive(FromPyObject)]
pub(crate) enum Learnt<'py> {
    Recorded(PyRef<'py, Recording>),
    Seen(Vec<Option<PyRef<'py, Profile>>>),
}

/// A corrected model with its record; errors are slosh-relative, of the measured surface.
#[pyclass(frozen, module = "meniscus_liquid")]
pub(crate) struct Correction {
    corrected: Corrected,
    forgetting: f64,
}

#[pymethods]
impl Correction {
    /// The corrected model.
    ///
    /// Raises:
    ///     MeniscusError: No candidate forecasts the held-out recording better than the model did.
    #[getter]
    fn model(&self) -> PyResult<Model> {
        let [before, after] = self.corrected.held;
        if after < before {
            return Model::of(AlignedBytes::copy(&self.corrected.blob));
        }
        Err(refused(format!(
            "nothing was learnt: no candidate forecasts the held-out recording better than {:.1} %; record more, and livelier, \
             motions",
            100.0 * before
        )))
    }

    /// Whether a candidate forecasts the held-out recording better than the model did.
    #[getter]
    fn improved(&self) -> bool {
        self.corrected.held[1] < self.corrected.held[0]
    }

    /// Figures of the command: one dictionary each with `name`, `value`, `unit`, `target` and `ok`.
    #[getter]
    fn checks<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let percent = |x: f64| 100.0 * x;
        let [held, source] = [self.corrected.held, self.corrected.source].map(|pair| pair.map(percent));
        let checks = [
            Check::informational("held_before_forecast", held[0], "%"),
            Check::at_most("held_after_forecast", held[1], "%", held[0]),
            Check::informational("source_before_slosh", source[0], "%"),
            Check::at_most("source_after_slosh", source[1], "%", source[0] + percent(self.forgetting)),
            Check::informational("refused_for_forgetting", self.corrected.refused as f64, "1"),
        ];
        to_python(py, &json!(checks))
    }

    /// Step, error of the held-out forecast and error on the model's own liquid of every candidate, 1.
    #[getter]
    fn looks(&self) -> Vec<(usize, f64, f64)> {
        self.corrected.looks.clone()
    }

    fn __repr__(&self) -> String {
        let [before, after] = self.corrected.held.map(|error| 100.0 * error);
        format!("<Correction: forecast {before:.1} % before, {after:.1} % after>")
    }
}

/// Corrects a model for another liquid by recordings of its free surface, as `meniscus correct` does, to the bit.
///
/// Args:
///     recordings: Recordings of the new liquid, which the simulated camera looks at; or for each one the profiles that a camera saw,
///         as `camera_profiles` returns them. The last is held out; of a single one its last three tenths.
///     model: Model to correct; by default the one in the package.
///     source: Recordings of the model's own liquid, against forgetting; by default the one in the package.
///     noise_px: Noise of the simulated camera's disparity, pixels rms, 0 to 5.
///     steps: Steps of Adam, 1 to 100000.
///     forgetting: Largest growth of the slosh-relative error on the model's own liquid.
///     seed: Seed of all random draws.
///     liquid: Name of the liquid in profiles; recordings of the simulator name theirs.
///     same_liquid: Whether profiles are of the model's own liquid.
///
/// Raises:
///     MeniscusError: An argument or a recording is refused.
#[pyfunction]
#[pyo3(signature = (recordings, *, model=None, source=None, noise_px=0.08, steps=300, forgetting=0.05, seed=1, liquid=None,
                    same_liquid=false))]
#[allow(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
pub(crate) fn correct(
    py: Python<'_>,
    recordings: Vec<Learnt<'_>>,
    model: Option<&Model>,
    source: Option<Vec<PyRef<'_, Recording>>>,
    noise_px: f64,
    steps: usize,
    forgetting: f64,
    seed: u64,
    liquid: Option<String>,
    same_liquid: bool,
) -> PyResult<Correction> {
    check_range("noise_px", &noise_px, 0.0..=5.0)?;
    check_range("steps", &steps, 1..=100_000)?;
    check_range("forgetting", &forgetting, 0.0..=10.0)?;
    let new = New::of(recordings, liquid, same_liquid)?;
    let source = match source {
        Some(given) => given.iter().map(|one| one.recorded.clone()).collect(),
        None => vec![Recording::shipped_recorded()?],
    };
    source.iter().try_for_each(level)?;
    let blob = AlignedBytes::copy(model.map_or(meniscus_shipped::MODEL, |model| &model.blob()[..]));
    let parameters = CorrectionParameters { steps, forgetting, ..CorrectionParameters::default() };
    let how = How {
        seed,
        parameters,
        command: format!("meniscus correct --steps {steps} --seed {seed}"),
        quiet: true,
        ..How::default()
    };
    let wanted = Wanted { blob, new, source, noise_px, how };
    let corrected = attended(py, None, |job| answer(wanted, job.stop))??;
    Ok(Correction { corrected, forgetting })
}

/// Refuses a glass that the simulated camera does not show.
fn level(recording: &Recorded) -> PyResult<()> {
    if recording.is_level() {
        return Ok(());
    }
    Err(refused(
        "a recording is of a conical, round, lifted or inclined glass: the rendered camera shows upright cylinders on a table",
    ))
}

/// The new liquid.
enum New {
    Recorded(Vec<Recorded>),
    Seen { liquid: String, same: bool, seen: Vec<Sightings> },
}

impl New {
    fn of(recordings: Vec<Learnt<'_>>, liquid: Option<String>, same: bool) -> PyResult<Self> {
        let (mut recorded, mut seen) = (Vec::new(), Vec::new());
        for one in recordings {
            match one {
                Learnt::Recorded(recording) => {
                    level(&recording.recorded)?;
                    recorded.push(recording.recorded.clone());
                }
                Learnt::Seen(profiles) => {
                    seen.push(profiles.into_iter().map(|profile| profile.map(|profile| profile.0)).collect());
                }
            }
        }
        match (recorded.is_empty(), seen.is_empty()) {
            (true, true) => Err(refused("recordings is empty: give one or more")),
            (false, false) => {
                Err(refused("recordings of the simulator and profiles of a camera at once: give one kind"))
            }
            (false, true) if liquid.is_some() || same => Err(refused(
                "liquid and same_liquid are for profiles: recordings of the simulator name theirs",
            )),
            (false, true) => Ok(Self::Recorded(recorded)),
            (true, false) => {
                let liquid =
                    liquid.ok_or_else(|| refused("profiles do not name their liquid: give liquid"))?;
                Ok(Self::Seen { liquid, same, seen })
            }
        }
    }
}

/// A correction that is wanted.
struct Wanted {
    blob: AlignedBytes,
    new: New,
    source: Vec<Recorded>,
    noise_px: f64,
    how: How,
}

/// Makes one correction.
fn answer(wanted: Wanted, stop: &AtomicBool) -> PyResult<Corrected> {
    let Wanted { blob, new, source, noise_px, mut how } = wanted;
    let model = Weights::load(&blob).map_err(refused)?;
    let (name, seen) = match new {
        New::Seen { liquid, same, seen } => {
            how.same_liquid = same;
            (liquid, seen)
        }
        New::Recorded(all) => {
            how.same_liquid = all.iter().all(|one| is_own(&one.provenance, &model.header, &source));
            let name = all.first().map_or(String::new(), |one| one.provenance.liquid.clone());
            (name, looks(&all, noise_px, how.seed).map_err(refused)?)
        }
    };
    how.liquid = corrected_name(&name, &model.header, how.same_liquid);
    let source_seen = looks(&source, noise_px, how.seed + SOURCE_SEED).map_err(refused)?;
    learn(&blob, &seen, &source_seen, &how, stop).map_err(|error| match error {
        TrainError::Interrupted => Stopped.into(),
        other => refused(other),
    })
}
