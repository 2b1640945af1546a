//! A Python function as the simulator of a discovery.
//!
//! It is called from the threads that make the simulations, each of which takes the interpreter lock for the call alone.

use crate::errors::SimulationError;
use meniscus::reduced::effects::{Active, Stated};
use meniscus_data::effects::Effects;
use meniscus_discover::foreign::answer::{Frames, SimulatorAnswer};
use meniscus_discover::foreign::carried;
use meniscus_discover::foreign::scene::{FORMAT, Scene, SceneMotion};
use meniscus_discover::insert::simulated::Course;
use meniscus_discover::insert::simulator::{GlassSimulator, SimulatorFault};
use meniscus_sph::Setup;
use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArrayLike2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

/// Exception that ended a discovery, as it was raised.
pub(crate) type Raised = Arc<Mutex<Option<PyErr>>>;

/// Function that simulates.
pub(crate) struct Callable {
    function: Py<PyAny>,
    name: String,
    identity: String,
    raised: Raised,
}

impl Callable {
    /// Returns the simulator that calls `function`. Its results are kept under `version`; without one they are not used again.
    pub(crate) fn new(
        py: Python<'_>,
        function: &Py<PyAny>,
        version: Option<&str>,
        raised: &Raised,
    ) -> PyResult<Self> {
        static CALLS: AtomicU64 = AtomicU64::new(0);
        let bound = function.bind(py);
        if !bound.is_callable() {
            let why = "simulator must be a function: simulator(scene) returns the heights of each motion";
            return Err(pyo3::exceptions::PyTypeError::new_err(why));
        }
        let name = match bound.getattr("__qualname__") {
            Ok(name) => name.to_string(),
            Err(_) => bound.get_type().name()?.to_string(),
        };
        let once = || {
            let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos());
            format!("once {} {now} {}", std::process::id(), CALLS.fetch_add(1, Ordering::Relaxed))
        };
        let kept = version.map_or_else(once, |version| format!("version {version}"));
        let identity = format!("python {FORMAT} {kept}");
        Ok(Self { function: function.clone_ref(py), name, identity, raised: raised.clone() })
    }

    /// Calls the function on `scene`.
    fn call(&self, py: Python<'_>, scene: &Scene) -> PyResult<Vec<Frames>> {
        let answer = self.function.bind(py).call1((dictionary(py, scene)?,))?;
        let frames = |motion: Bound<'_, PyAny>| -> PyResult<Frames> {
            let heights: PyArrayLike2<'_, f64, AllowTypeChange> = motion.extract()?;
            Ok(heights
                .as_array()
                .rows()
                .into_iter()
                .map(|row| row.iter().map(|z| Some(*z)).collect())
                .collect())
        };
        answer.try_iter()?.map(|motion| frames(motion?)).collect()
    }
}

impl GlassSimulator for Callable {
    fn name(&self) -> &str {
        &self.name
    }

    fn identity(&self) -> &str {
        &self.identity
    }

    fn carried(&self, effects: &[Active], stated: &Stated) -> Result<Effects, String> {
        carried(effects, stated)
    }

    fn particle_step_s(&self) -> Option<f64> {
        None
    }

    fn run(
        &self,
        setup: &Setup,
        courses: &[&Course],
        stop: Option<&AtomicBool>,
    ) -> Result<Vec<Vec<f32>>, SimulatorFault> {
        let scene = Scene::new(setup, courses).map_err(SimulatorFault::Here)?;
        let called = Python::attach(|py| {
            // The lock may have been waited for.
            if stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
                return Err(SimulatorFault::Stopped);
            }
            self.call(py, &scene).map_err(|error| {
                if error.is_instance_of::<SimulationError>(py) {
                    return SimulatorFault::Here(error.value(py).to_string());
                }
                let reason = format!("the simulator {} raised {error}", self.name);
                let mut raised = self.raised.lock().unwrap_or_else(PoisonError::into_inner);
                // The first of several threads is the cause.
                raised.get_or_insert(error);
                SimulatorFault::Broken(reason)
            })
        })?;
        let answer = SimulatorAnswer { heights_m: Some(called), ..SimulatorAnswer::default() };
        answer.heights(&format!("the simulator {}", self.name), setup, courses)
    }
}

/// Returns `scene` as a dictionary with the keys of the protocol; tables are arrays.
fn dictionary<'py>(py: Python<'py>, scene: &Scene) -> PyResult<Bound<'py, PyDict>> {
    let of = |pairs: &[(&str, f64)]| -> PyResult<Bound<'py, PyDict>> {
        let dictionary = PyDict::new(py);
        pairs.iter().try_for_each(|(key, value)| dictionary.set_item(key, value))?;
        Ok(dictionary)
    };
    let Scene { glass, liquid, resolution, .. } = scene;
    let glass = of(&[("radius_m", glass.radius_m), ("fill_m", glass.fill_m), ("rim_m", glass.rim_m)])?;
    let liquid = of(&[("density_kg_m3", liquid.density_kg_m3), ("viscosity_pa_s", liquid.viscosity_pa_s)])?;
    let effects: Vec<(&str, f64)> = scene.effects.iter().map(|(name, value)| (*name, *value)).collect();
    let spacing = of(&[("spacing_m", resolution.spacing_m)])?;
    spacing.set_item("seed", resolution.seed)?;
    let motion = |motion: &SceneMotion| -> PyResult<Bound<'py, PyDict>> {
        let dictionary = PyDict::new(py);
        dictionary.set_item("frames", motion.frames)?;
        dictionary.set_item("time_s", PyArray1::from_slice(py, &motion.time_s))?;
        dictionary.set_item("x_m", PyArray1::from_slice(py, &motion.x_m))?;
        dictionary.set_item("acceleration_m_s2", PyArray1::from_slice(py, &motion.acceleration_m_s2))?;
        Ok(dictionary)
    };
    let points: Vec<Vec<f64>> = scene.points_m.iter().map(|point| point.to_vec()).collect();
    let out = of(&[("gravity_m_s2", scene.gravity_m_s2), ("frame_interval_s", scene.frame_interval_s)])?;
    out.set_item("meniscus_simulator", scene.meniscus_simulator)?;
    out.set_item("glass", glass)?;
    out.set_item("liquid", liquid)?;
    out.set_item("effects", of(&effects)?)?;
    out.set_item("resolution", spacing)?;
    out.set_item("points_m", PyArray2::from_vec2(py, &points)?)?;
    out.set_item("motions", scene.motions.iter().map(motion).collect::<PyResult<Vec<_>>>()?)?;
    Ok(out)
}
