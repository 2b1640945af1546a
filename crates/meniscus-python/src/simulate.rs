//! The particle simulator.

use crate::arguments;
use crate::errors::{SimulationError, check_output, check_range, refused};
use crate::glass::Glass;
use crate::interrupt::{Job, attended};
use crate::liquid::Liquid;
use crate::motion::Motion;
use crate::recording::Recording;
use crate::scene::Scene;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::liquids::Liquid as Known;
use meniscus_data::motion::Motion as Course;
use meniscus_data::recording::Recording as Recorded;
use meniscus_data::scene_file::GLASS;
use meniscus_sph::{Error, Observer, Particles, Setup, Simulator, record_until};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// A motion by its spelling, or as an object.
#[derive(FromPyObject)]
pub(crate) enum MotionArgument<'py> {
    Spelled(String),
    Made(PyRef<'py, Motion>),
}

/// A liquid by name or path, or as an object.
#[derive(FromPyObject)]
pub(crate) enum LiquidArgument<'py> {
    Named(String),
    Made(PyRef<'py, Liquid>),
}

/// Simulates a moved glass of liquid and returns its recording. Other Python threads go on meanwhile; Ctrl-C ends it within a
/// step.
///
/// It takes 5 s of processor time to settle at 5 mm, and 5 to 8 s for each second of slosh. The result depends on nothing but the
/// arguments: it is that of `meniscus simulate` to the bit, on any number of threads.
///
/// Args:
///     motion: As `Motion` takes it, or a `Motion`; by default that of the scene.
///     seconds: Length of the recording, 0.1 to 600 s.
///     liquid: Name, path of a liquid file, or a `Liquid`; by default that of the scene, or glycerine.
///     glass: The glass; by default that of the scene, or 35 mm inner radius filled to 70 mm.
///     effects: Effects to switch on, by name as in `effects()`, SI units: `{"surface_tension": 0.063}`.
///     scene: A `Scene`; the other arguments go before it.
///     spacing_mm: Spacing of the particles; by default that of the scene, or 5.
///     particles: New file for the particles of every frame, `NAME.particles.safetensors`, as of `meniscus simulate --particles`.
///     threads: Threads; 0 takes all processors.
///     progress: Is called as `progress(step, done)` with the share that is done, 0 to 1.
///
/// Raises:
///     MeniscusError: An argument is refused, before the simulation.
///     SimulationError: The simulation could not go on, as when the motion throws particles out.
///     OSError: The file of the particles cannot be written.
///
/// Example:
///     >>> import meniscus_liquid as ml
///     >>> recording = ml.simulate("jolts:1x0.3", seconds=1.5, spacing_mm=8.0)
///     >>> recording.frames, recording.is_compact
///     (90, False)
#[pyfunction]
#[pyo3(signature = (motion=None, *, seconds=6.0, liquid=None, glass=None, effects=None, scene=None, spacing_mm=None,
                    particles=None, threads=0, progress=None))]
#[allow(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
pub(crate) fn simulate(
    py: Python<'_>,
    motion: Option<MotionArgument<'_>>,
    seconds: f64,
    liquid: Option<LiquidArgument<'_>>,
    glass: Option<&Glass>,
    effects: Option<&Bound<'_, PyDict>>,
    scene: Option<&Scene>,
    spacing_mm: Option<f64>,
    particles: Option<PathBuf>,
    threads: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<Recording> {
    check_range("seconds", &seconds, 0.1..=600.0)?;
    particles.as_deref().map_or(Ok(()), |path| check_output(path, false))?;
    let defaults = scene.map(|scene| scene.experiment.clone()).unwrap_or_default();
    let (effects, spelled) = arguments::effects(effects, defaults.effects)?;
    effects.require_simulated().map_err(refused)?;
    let chosen = ChosenLiquid::of(liquid, defaults.liquid.as_deref())?;
    let motion = match motion {
        Some(MotionArgument::Made(motion)) => Motion::clone(&motion),
        Some(MotionArgument::Spelled(text)) => spelled_motion(&text, seconds)?,
        None => match &defaults.motion {
            Some(text) => spelled_motion(text, seconds)?,
            None => return Err(refused("give a motion, or a scene that has one")),
        },
    };
    let setup = Setup {
        glass: glass.map(|glass| glass.0).or(defaults.glass).unwrap_or(GLASS),
        liquid: chosen.liquid,
        spacing_m: 1e-3 * spacing_mm.or(defaults.spacing_mm).unwrap_or(5.0),
        seed: motion.course.seed,
        no_slip: true,
        effects,
        step_s: defaults.step_s,
    };
    setup.longest_step_s().map_err(refused)?;
    let command = command(&Command {
        motion: &motion,
        seconds,
        liquid: chosen.name,
        scene,
        spacing_mm,
        setup: &setup,
        spelled,
        reproducible: chosen.reproducible,
    });
    let course = motion.course;
    let mut kept = particles.as_ref().map(|_| Particles::default());
    let work = |job: &Job| recorded(job, &setup, &course, seconds, &command, threads, kept.as_mut());
    let recording = attended(py, progress, work)??;
    if let Some((path, kept)) = particles.as_deref().zip(kept.as_ref()) {
        kept.save(path).map_err(crate::errors::system)?;
    }
    Ok(Recording::of(recording))
}

/// The liquid of a simulation, and how a command would name it.
struct ChosenLiquid {
    liquid: Known,
    /// As the caller named it; `None` where nobody did.
    name: Option<String>,
    /// Whether a command can name it: the liquid of a text is in no file.
    reproducible: bool,
}

impl ChosenLiquid {
    /// Returns the liquid of `argument`, or that of the scene, or glycerine.
    fn of(argument: Option<LiquidArgument<'_>>, of_scene: Option<&str>) -> PyResult<Self> {
        let load = |name: &str| Known::load(name).map_err(refused);
        Ok(match argument {
            None => Self { liquid: load(of_scene.unwrap_or("glycerine"))?, name: None, reproducible: true },
            Some(LiquidArgument::Named(name)) => {
                Self { liquid: load(&name)?, name: Some(name), reproducible: true }
            }
            Some(LiquidArgument::Made(made)) => {
                let liquid = made.0.clone();
                let reproducible = Known::load(&liquid.name).is_ok_and(|known| known == liquid);
                Self { name: Some(liquid.name.clone()), liquid, reproducible }
            }
        })
    }
}

fn spelled_motion(text: &str, seconds: f64) -> PyResult<Motion> {
    Ok(Motion { course: Course::parse(text, seconds).map_err(refused)?, spelled: true })
}

/// Simulates in a pool of `threads`: from outside of one, every sum of every step would wait for its threads to wake.
fn recorded(
    job: &Job,
    setup: &Setup,
    motion: &Course,
    seconds: f64,
    command: &str,
    threads: usize,
    mut particles: Option<&mut Particles>,
) -> PyResult<Recorded> {
    let frames = (seconds / FRAME_INTERVAL_S).round() as usize;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(crate::errors::system)?;
    job.tell("settling", 0.0);
    let made = pool.install(|| {
        let mut watch = |done: usize| job.tell("simulating", done as f64 / frames as f64);
        let mut each = |simulator: &Simulator| {
            if let Some(particles) = &mut particles {
                particles.take(simulator);
            }
        };
        let observer = Observer { watch: &mut watch, each: &mut each, stop: job.stop };
        record_until(setup, motion, frames, command, observer)
    });
    made.map_err(|error| match error {
        Error::Setup(_) => refused(error),
        Error::Stopped => crate::interrupt::Stopped.into(),
        Error::Escaped { .. } | Error::NotFinite { .. } => SimulationError::new_err(error.to_string()),
    })
}

/// Parts of a command line.
struct Command<'a> {
    motion: &'a Motion,
    seconds: f64,
    liquid: Option<String>,
    scene: Option<&'a Scene>,
    spacing_mm: Option<f64>,
    setup: &'a Setup,
    spelled: Vec<String>,
    reproducible: bool,
}

/// The command that makes the recording again, in the spelling of `meniscus simulate`; where none can, the call.
fn command(of: &Command<'_>) -> String {
    let effects: String = of.spelled.iter().map(|effect| format!(" --effect {effect}")).collect();
    let spacing_mm = of.spacing_mm.unwrap_or((1e9 * of.setup.spacing_m).round() / 1e6);
    let path = of.scene.and_then(|scene| scene.path.as_ref());
    let plain = of.reproducible
        && of.motion.spelled
        && of.setup.glass == of.scene.and_then(|scene| scene.experiment.glass).unwrap_or(GLASS)
        && of.scene.is_none_or(|scene| scene.path.is_some());
    if !plain {
        return format!(
            "meniscus_liquid.simulate of {} under {}, {} s, {spacing_mm} mm{effects}",
            of.setup.liquid.name, of.motion.course.spelling, of.seconds
        );
    }
    let scene = path.map_or(String::new(), |path| format!(" --scene {}", path.display()));
    let liquid = match (&of.liquid, path) {
        (None, Some(_)) => String::new(),
        (liquid, _) => format!(" --liquid {}", liquid.as_deref().unwrap_or(&of.setup.liquid.name)),
    };
    format!(
        "meniscus simulate{scene}{liquid} --motion {} --seconds {} --spacing-mm {spacing_mm}{effects}",
        of.motion.course.spelling, of.seconds
    )
}
