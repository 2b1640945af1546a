//! The estimator: one turn a frame, from a profile and the motion of the glass to the whole liquid.

use crate::arguments::Numbers;
use crate::errors::{check_range, refused};
use crate::estimate::{Estimate, Estimates, Forecast};
use crate::model::Model;
use crate::profile::Profile;
use meniscus::runtime::output::Packet;
use meniscus::runtime::{Crest, Estimator as Turns, Forecast as Ahead, InputSource, Memory, Turn, TurnInput};
use meniscus::surface::SurfaceProfile;
use meniscus::units::{FRAME_INTERVAL_S, Micros};
use meniscus_data::recording::{EstimateRecording, GROUP_NAMES};
use meniscus_platform::clock::NoClock;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Most turns that a forecast may look ahead: ten seconds.
const FARTHEST: usize = 600;

/// The estimator on a model: call `turn` once a frame interval, 60 times a second.
///
/// It has no deadline of its own: the clock of a run stays with the caller, and every field is written.
///
/// Args:
///     model: The model; by default the glycerine model inside the package.
///     fields: Groups of the field that turns decode, of `q`, `v`, `e`, `sigma`, `tau`; by default all that the model knows.
///
/// Example:
///     >>> import numpy as np
///     >>> from meniscus_liquid import Estimator, Profile
///     >>> estimator = Estimator()
///     >>> rest = Profile(np.full(21, 0.07), 1e-4, glass_x_m=0.0)
///     >>> for _ in range(20):
///     ...     estimate = estimator.turn(rest)
///     >>> estimate.mode, estimate.field("q").shape
///     ('tracking', (2134, 3))
#[pyclass(module = "meniscus_liquid")]
pub(crate) struct Estimator {
    model: Py<Model>,
    fields: Vec<usize>,
    memory: Memory,
    field: Vec<f32>,
    number: u64,
    time: Option<Micros>,
}

/// Source of the motion of the glass, as Python spells it.
#[derive(FromPyObject)]
pub(crate) enum SourceArgument {
    Named(String),
    Measured((f64, f64)),
}

/// Returns the source of the motion of a turn.
fn source(argument: Option<SourceArgument>) -> PyResult<InputSource> {
    match argument {
        None => Ok(InputSource::Tracked),
        Some(SourceArgument::Named(name)) => match name.as_str() {
            "tracked" => Ok(InputSource::Tracked),
            "unobserved" => Ok(InputSource::Unobserved),
            _ => Err(refused(format!(
                "motion = '{name}': take \"tracked\", \"unobserved\", or the accelerations (before, now) in m/s2"
            ))),
        },
        Some(SourceArgument::Measured((before, now))) => {
            if !before.is_finite() || !now.is_finite() {
                return Err(refused(format!(
                    "motion = ({before}, {now}): accelerations must be finite, m/s2"
                )));
            }
            Ok(InputSource::Measured { before, now })
        }
    }
}

/// Returns the accelerations of a plan, refused where one is not finite.
fn plan(given: Option<Numbers<'_>>) -> PyResult<Vec<f64>> {
    let plan = given.map_or(Vec::new(), |plan| plan.as_array().to_vec());
    match plan.iter().position(|a| !a.is_finite()) {
        Some(at) => Err(refused(format!("plan[{at}] = {}: accelerations must be finite, m/s2", plan[at]))),
        None => Ok(plan),
    }
}

#[pymethods]
impl Estimator {
    #[new]
    #[pyo3(signature = (model=None, *, fields=None))]
    fn new(py: Python<'_>, model: Option<Py<Model>>, fields: Option<Vec<String>>) -> PyResult<Self> {
        let model = match model {
            Some(model) => model,
            None => Py::new(
                py,
                Model::of(meniscus_platform::files::AlignedBytes::copy(meniscus_shipped::MODEL))?,
            )?,
        };
        let known = meniscus_data::recording::group_names(model.get().weights().header.known());
        let wanted = match fields {
            None => GROUP_NAMES.iter().filter(|name| known.contains(name)).map(ToString::to_string).collect(),
            Some(names) => names,
        };
        let mut fields = Vec::new();
        for name in &wanted {
            let index = GROUP_NAMES.iter().position(|group| group == name).ok_or_else(|| {
                refused(format!("no field is called '{name}': take some of {}", GROUP_NAMES.join(", ")))
            })?;
            if !known.contains(&name.as_str()) {
                return Err(refused(format!(
                    "the model does not know the field '{name}' of its liquid; it knows {}",
                    known.join(", ")
                )));
            }
            fields.push(index);
        }
        fields.sort_unstable();
        fields.dedup();
        let mut estimator =
            Self { model, fields, memory: Memory::default(), field: Vec::new(), number: 0, time: None };
        estimator.field = vec![0.0; estimator.turns().field_len()];
        Ok(estimator)
    }

    /// Takes one turn and returns its estimate.
    ///
    /// Args:
    ///     profile: Profile of the frame; `None` where no frame came or no liquid was seen.
    ///     motion: `"tracked"`: the position in the profile; `"unobserved"`: none; or a pair of accelerations along x in m/s2, one
    ///         frame interval before the frame and at it, of an IMU or a command.
    #[pyo3(signature = (profile=None, *, motion=None))]
    fn turn(&mut self, profile: Option<&Profile>, motion: Option<SourceArgument>) -> PyResult<Estimate> {
        let source = source(motion)?;
        let turn = self.step(profile.map(|profile| &profile.0), source);
        let header = &self.model.get().weights().header;
        let field = if turn.estimate.field_fresh { self.field.clone() } else { Vec::new() };
        Ok(Estimate::of(turn.estimate.known_only(header.known()), field, &self.fields))
    }

    /// Takes one turn for each of `profiles` and returns the estimates as arrays; fields are left out, which is twice as fast.
    ///
    /// Args:
    ///     profiles: One profile or `None` a frame interval, as `Recording.observe` gives them.
    ///     motion: `"tracked"`, `"unobserved"`, or the acceleration of the glass at each frame, m/s2, [len(profiles)].
    #[pyo3(signature = (profiles, *, motion=None))]
    fn track(
        &mut self,
        py: Python<'_>,
        profiles: Vec<Option<PyRef<'_, Profile>>>,
        motion: Option<MotionArgument<'_>>,
    ) -> PyResult<Estimates> {
        let sources = sources(motion, profiles.len())?;
        let profiles: Vec<Option<SurfaceProfile>> =
            profiles.into_iter().map(|profile| profile.map(|profile| profile.0)).collect();
        let field = std::mem::take(&mut self.field);
        let packets = py.detach(|| {
            let each = profiles.iter().zip(sources);
            each.map(|(profile, source)| {
                let number = self.number;
                let turn = self.step(profile.as_ref(), source);
                Packet::of(&turn, number, &self.model.get().weights().header)
            })
            .collect::<Vec<_>>()
        });
        self.field = field;
        Ok(Estimates(EstimateRecording::of(&packets, "meniscus_liquid.Estimator.track")))
    }

    /// Returns the surface `frames` turns from now.
    ///
    /// Args:
    ///     frames: Turns ahead, 0 to 600.
    ///     plan: Planned accelerations of the glass along x, m/s2, the next turn first; without a plan the glass moves on evenly,
    ///         and the interval counts what it might do instead.
    #[pyo3(signature = (frames, plan=None))]
    fn forecast(&self, frames: usize, plan: Option<Numbers<'_>>) -> PyResult<Forecast> {
        check_range("frames", &frames, 0..=FARTHEST)?;
        let plan = self::plan(plan)?;
        Ok(Forecast(Ahead::new(self.model.get().weights(), &self.memory, frames, &plan)))
    }

    /// Returns the next crest within `frames` turns as a dictionary: `frames` from now, `height_m`, `half_width_m` (90 %), and
    /// whether it `spills`; `None` if the surface only sinks. `plan` as in `forecast`.
    #[pyo3(signature = (frames, plan=None))]
    fn next_crest<'py>(
        &self,
        py: Python<'py>,
        frames: usize,
        plan: Option<Numbers<'_>>,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        check_range("frames", &frames, 0..=FARTHEST)?;
        let plan = self::plan(plan)?;
        let Some(crest) = Crest::next(self.model.get().weights(), &self.memory, frames, &plan) else {
            return Ok(None);
        };
        let dict = PyDict::new(py);
        dict.set_item("frames", crest.frames)?;
        dict.set_item("height_m", crest.height_m)?;
        dict.set_item("half_width_m", crest.half_width_m)?;
        dict.set_item("spills", crest.spills)?;
        Ok(Some(dict))
    }

    /// Counters since the start, by cause.
    #[getter]
    fn health<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let value = serde_json::to_value(self.memory.health).map_err(refused)?;
        crate::arguments::to_python(py, &value)
    }

    /// The model.
    #[getter]
    fn model(&self, py: Python<'_>) -> Py<Model> {
        self.model.clone_ref(py)
    }

    /// Groups of the field that a turn decodes.
    #[getter]
    fn fields(&self) -> Vec<&'static str> {
        self.fields.iter().map(|group| GROUP_NAMES[*group]).collect()
    }

    /// Forgets everything that was seen, counters included.
    fn reset(&mut self) {
        (self.memory, self.number, self.time) = (Memory::default(), 0, None);
    }
}

impl Estimator {
    fn turns(&self) -> Turns<'_> {
        use meniscus::latent::decoder::Selection;
        let selection = self.fields.iter().fold(Selection::NONE, |chosen, group| chosen.with(*group));
        Turns::new(self.model.get().weights()).only(selection)
    }

    /// Takes one turn; the field goes into `self.field`.
    fn step(&mut self, profile: Option<&SurfaceProfile>, source: InputSource) -> Turn {
        let interval_us = (1e6 * FRAME_INTERVAL_S).round() as u64;
        let after = self.time.map_or(Micros(0), |time| Micros(time.0 + interval_us));
        let time = profile.map_or(after, |profile| profile.captured);
        let (mut memory, mut field) = (std::mem::take(&mut self.memory), std::mem::take(&mut self.field));
        let input = TurnInput { profile, source, surface_us: 0 };
        let estimate = self.turns().turn(&mut memory, input, &mut NoClock, &mut field);
        (self.memory, self.field, self.time) = (memory, field, Some(time));
        self.number += 1;
        let stamp =
            profile.map(|profile| meniscus::usb::frame::Stamp { sequence: profile.sequence, captured: time });
        Turn { time, stamp, profile: profile.map(|profile| Ok(*profile)), estimate }
    }
}

/// Motion of all frames, as Python spells it.
#[derive(FromPyObject)]
pub(crate) enum MotionArgument<'py> {
    Named(String),
    Measured(Numbers<'py>),
}

/// Returns the source of each of `frames` turns.
fn sources(motion: Option<MotionArgument<'_>>, frames: usize) -> PyResult<Vec<InputSource>> {
    let accelerations = match motion {
        None => return Ok(vec![InputSource::Tracked; frames]),
        Some(MotionArgument::Named(name)) => {
            return Ok(vec![source(Some(SourceArgument::Named(name)))?; frames]);
        }
        Some(MotionArgument::Measured(array)) => array.as_array().to_vec(),
    };
    if accelerations.len() != frames {
        return Err(refused(format!(
            "motion has {} accelerations for {frames} profiles",
            accelerations.len()
        )));
    }
    // The port takes the acceleration of one interval before the frame.
    let before = std::iter::once(0.0).chain(accelerations.iter().copied());
    before
        .zip(&accelerations)
        .map(|(before, now)| source(Some(SourceArgument::Measured((before, *now)))))
        .collect()
}
