//! The reduced slosh model: the first waves of an upright cylinder as a driven GENERIC system.

use crate::arguments;
use crate::arguments::{Numbers, Table};
use crate::errors::{check_range, refused};
use crate::liquid::Liquid;
use meniscus::reduced::effects::Stated;
use meniscus::reduced::{
    Baseline, Cylinder, EnergyBalance, Forcing, RADIAL, ReducedModel as Waves, ReducedState as State,
    Rheology, step, surface, velocity, wall_harmonics,
};
use meniscus_data::effects::Effects;
use meniscus_data::scene_file::GLASS;
use numpy::ndarray::{Array1, Array2};
use numpy::{PyArray1, PyArray2, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The waves (1,n), (0,n) and (2,n) of a liquid in an upright cylinder, with effects. Energy is exact against the work of the moved
/// glass, and heat never falls, for any step.
///
/// Args:
///     liquid: Name or path of a liquid, or a `Liquid`.
///     radius_m: Inner radius of the glass.
///     depth_m: Height of the liquid at rest.
///     effects: Effects that are on, by name as in `effects()`, SI units.
///     dt_s: Length of a step.
///
/// Example:
///     >>> from meniscus_liquid import ReducedModel
///     >>> water = ReducedModel("water")
///     >>> round(water.frequency_hz(0), 1)
///     3.6
#[pyclass(frozen, module = "meniscus_liquid")]
pub(crate) struct ReducedModel {
    waves: Waves,
    dt_s: f64,
}

/// State of the waves: heights at the wall and their rates, by direction (x, y) and radial mode.
///
/// Example:
///     >>> from meniscus_liquid import ReducedModel, ReducedState
///     >>> model, state = ReducedModel("water"), ReducedState()
///     >>> state.set_height(0, 0, 0.005)
///     >>> before = model.energy_j(state)
///     >>> _ = [model.step(state) for _ in range(240)]
///     >>> abs(model.energy_j(state) + state.heat_j - before) < 1e-12
///     True
#[pyclass(module = "meniscus_liquid")]
#[derive(Clone, Default)]
pub(crate) struct ReducedState(State);

/// A liquid by name or path, or as an object.
#[derive(FromPyObject)]
pub(crate) enum LiquidArgument<'py> {
    Named(String),
    Made(PyRef<'py, Liquid>),
}

#[pymethods]
impl ReducedModel {
    #[new]
    #[pyo3(signature = (liquid=None, *, radius_m=GLASS.radius_m, depth_m=GLASS.fill_m, effects=None, dt_s=1.0 / 240.0))]
    fn new(
        liquid: Option<LiquidArgument<'_>>,
        radius_m: f64,
        depth_m: f64,
        effects: Option<&Bound<'_, PyDict>>,
        dt_s: f64,
    ) -> PyResult<Self> {
        check_range("radius_m", &radius_m, 1e-3..=10.0)?;
        check_range("depth_m", &depth_m, 1e-3..=10.0)?;
        check_range("dt_s", &dt_s, 1e-6..=0.1)?;
        let liquid = match &liquid {
            None => meniscus_data::liquids::Liquid::load("glycerine").map_err(refused)?,
            Some(LiquidArgument::Named(name)) => {
                meniscus_data::liquids::Liquid::load(name).map_err(refused)?
            }
            Some(LiquidArgument::Made(liquid)) => liquid.0.clone(),
        };
        let law = liquid.rheology;
        if law.consistency <= 0.0 {
            return Err(refused(format!(
                "{}: a liquid without viscosity has no boundary layer, which the reduced model needs",
                liquid.name
            )));
        }
        let rheology =
            Rheology { index: law.index, yield_pa: law.yield_stress, ..Rheology::newtonian(law.consistency) };
        let (effects, _) = arguments::effects(effects, Effects::default())?;
        let stated = Stated { consistency_pa_sn: law.consistency, radius_m, fill_m: depth_m };
        let active = effects.over(liquid.effects).active(&stated).map_err(refused)?;
        if active.len() > meniscus::reduced::effects::MOST {
            return Err(refused(format!(
                "{} effects are on: the reduced model takes {} at once",
                active.len(),
                meniscus::reduced::effects::MOST
            )));
        }
        let glass = Cylinder { radius_m, depth_m, density_kg_m3: liquid.density_kg_m3 };
        Ok(Self { waves: Waves::new(glass, rheology, &Baseline::default(), &active, dt_s), dt_s })
    }

    /// Length of a step, s.
    #[getter]
    fn dt_s(&self) -> f64 {
        self.dt_s
    }

    /// Inner radius under the effects, m.
    #[getter]
    fn radius_m(&self) -> f64 {
        self.waves.glass.radius_m
    }

    /// Depth under the effects, m.
    #[getter]
    fn depth_m(&self) -> f64 {
        self.waves.glass.depth_m
    }

    /// Mass of the first mode, kg: its kinetic energy is m v^2/2 with v the rate of the height at the wall.
    #[getter]
    fn mass_kg(&self) -> f64 {
        self.waves.mass_kg()
    }

    /// Returns the frequency of the mode (1,n) at small amplitude, Hz; n is 0, 1 or 2.
    #[pyo3(signature = (n=0))]
    fn frequency_hz(&self, n: usize) -> PyResult<f64> {
        Ok(self.mode(n)?.0 / std::f64::consts::TAU)
    }

    /// Returns the decay rate of the amplitude of the mode (1,n) at small amplitude, 1/s.
    #[pyo3(signature = (n=0))]
    fn damping_1_s(&self, n: usize) -> PyResult<f64> {
        Ok(self.mode(n)?.1)
    }

    /// Returns the friction of the first mode, contact line included, at an amplitude of its rate (m/s), N s/m.
    fn friction_n_s_m(&self, rate_m_s: f64) -> f64 {
        self.waves.first_mode_friction(rate_m_s)
    }

    /// Advances `state` by one step while the glass accelerates; returns the energy balance: `work_j`, `heat_j`, `residue_j`.
    ///
    /// Args:
    ///     state: Is changed.
    ///     acceleration_m_s2: Acceleration of the glass along x and y, m/s2.
    ///     lift_m_s2: Acceleration of the glass upwards, m/s2.
    #[pyo3(signature = (state, acceleration_m_s2=(0.0, 0.0), lift_m_s2=0.0))]
    fn step<'py>(
        &self,
        py: Python<'py>,
        state: &mut ReducedState,
        acceleration_m_s2: (f64, f64),
        lift_m_s2: f64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let forcing = forcing(acceleration_m_s2, lift_m_s2)?;
        let balance = self.advance(&mut state.0, &forcing);
        let dict = PyDict::new(py);
        dict.set_item("work_j", balance.work_j)?;
        dict.set_item("heat_j", balance.heat_j)?;
        dict.set_item("residue_j", balance.residue_j)?;
        Ok(dict)
    }

    /// Advances `state` by one step for each row of `acceleration_m_s2` [N, 2] and returns the heights along the wall after each, as
    /// harmonics of the azimuth, m, [N, 5]: mean, cos, sin, cos 2, sin 2.
    fn run<'py>(
        &self,
        py: Python<'py>,
        state: &mut ReducedState,
        acceleration_m_s2: Table<'py>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let plan = acceleration_m_s2.as_array();
        if plan.ncols() != 2 {
            return Err(refused(format!(
                "acceleration_m_s2 is {} x {}: give one row a step, x and y",
                plan.nrows(),
                plan.ncols()
            )));
        }
        let steps: Vec<Forcing> =
            plan.rows().into_iter().map(|row| forcing((row[0], row[1]), 0.0)).collect::<PyResult<_>>()?;
        let heights = py.detach(|| {
            let each = steps.iter().map(|forcing| {
                self.advance(&mut state.0, forcing);
                wall_harmonics(&self.waves, &state.0, &forcing.along_m_s2)
            });
            each.flatten().collect::<Vec<f64>>()
        });
        let table = Array2::from_shape_vec((steps.len(), 5), heights).map_err(refused)?;
        Ok(table.to_pyarray(py))
    }

    /// Returns the energy of `state` without its heat, J.
    fn energy_j(&self, state: &ReducedState) -> f64 {
        self.waves.energy(&state.0)
    }

    /// Returns the liquid at rest under a constant acceleration of the glass along x and y, m/s2.
    #[pyo3(signature = (acceleration_m_s2=(0.0, 0.0), lift_m_s2=0.0))]
    fn rest(&self, acceleration_m_s2: (f64, f64), lift_m_s2: f64) -> PyResult<ReducedState> {
        Ok(ReducedState(self.waves.rest(&forcing(acceleration_m_s2, lift_m_s2)?)))
    }

    /// Returns the height of the surface over rest at each point, m, [K]; `points_m` is [K, 2], x and y in the glass.
    #[pyo3(signature = (state, points_m, acceleration_m_s2=(0.0, 0.0)))]
    fn surface_m<'py>(
        &self,
        py: Python<'py>,
        state: &ReducedState,
        points_m: Table<'py>,
        acceleration_m_s2: (f64, f64),
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let points = points_m.as_array();
        if points.ncols() != 2 {
            return Err(refused(format!("points_m is {} x {}: give K x 2", points.nrows(), points.ncols())));
        }
        let push = forcing(acceleration_m_s2, 0.0)?.along_m_s2;
        let heights = points.rows().into_iter().map(|p| surface(&self.waves, &state.0, &push, p[0], p[1]));
        Ok(heights.collect::<Array1<f64>>().to_pyarray(py))
    }

    /// Returns the height of the surface over rest at each azimuth of the wall, m, [K]: first and second order.
    #[pyo3(signature = (state, azimuth_rad, acceleration_m_s2=(0.0, 0.0)))]
    fn wall_m<'py>(
        &self,
        py: Python<'py>,
        state: &ReducedState,
        azimuth_rad: Numbers<'py>,
        acceleration_m_s2: (f64, f64),
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let push = forcing(acceleration_m_s2, 0.0)?.along_m_s2;
        let [mean, cos, sin, cos2, sin2] = wall_harmonics(&self.waves, &state.0, &push);
        let at =
            |t: &f64| mean + cos * t.cos() + sin * t.sin() + cos2 * (2.0 * t).cos() + sin2 * (2.0 * t).sin();
        Ok(azimuth_rad.as_array().iter().map(at).collect::<Array1<f64>>().to_pyarray(py))
    }

    /// Returns the velocity of the liquid at each point, first order, m/s, [K, 3]; `points_m` is [K, 3], z from the bottom.
    fn velocity_m_s<'py>(
        &self,
        py: Python<'py>,
        state: &ReducedState,
        points_m: Table<'py>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let points = points_m.as_array();
        if points.ncols() != 3 {
            return Err(refused(format!("points_m is {} x {}: give K x 3", points.nrows(), points.ncols())));
        }
        let each =
            points.rows().into_iter().flat_map(|p| velocity(&self.waves, &state.0, [p[0], p[1], p[2]]));
        let table = Array2::from_shape_vec((points.nrows(), 3), each.collect()).map_err(refused)?;
        Ok(table.to_pyarray(py))
    }

    fn __repr__(&self) -> String {
        let [radius, depth] = [self.waves.glass.radius_m, self.waves.glass.depth_m].map(|m| 1e3 * m);
        format!(
            "<ReducedModel of a glass of {radius:.1} mm radius, {depth:.1} mm deep, steps of {} s>",
            self.dt_s
        )
    }
}

impl ReducedModel {
    /// Frequency (rad/s) and damping (1/s) of the mode (1,n).
    fn mode(&self, n: usize) -> PyResult<(f64, f64)> {
        let mode = self.waves.frequency_and_damping(n);
        mode.ok_or_else(|| {
            refused(format!("there is no mode (1,{n}): the model keeps n = 0 to {}", RADIAL - 1))
        })
    }

    fn advance(&self, state: &mut State, forcing: &Forcing) -> EnergyBalance {
        step(&self.waves, state, forcing)
    }
}

/// The forcing of a glass that accelerates: the specific force on the liquid is minus the acceleration.
fn forcing(acceleration_m_s2: (f64, f64), lift_m_s2: f64) -> PyResult<Forcing> {
    let (x, y) = acceleration_m_s2;
    if ![x, y, lift_m_s2].iter().all(|a| a.is_finite()) {
        return Err(refused(format!("the acceleration ({x}, {y}, {lift_m_s2}) m/s2 must be finite")));
    }
    Ok(Forcing { along_m_s2: [-x, -y], lift_m_s2 })
}

#[pymethods]
impl ReducedState {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// Heights at the wall, m, [2, 3]: directions x and y, modes (1,0) to (1,2). A copy.
    #[getter]
    fn height_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        Array2::from(self.0.height.to_vec()).to_pyarray(py)
    }

    /// Rates of the heights, m/s, [2, 3]. A copy.
    #[getter]
    fn rate_m_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        Array2::from(self.0.rate.to_vec()).to_pyarray(py)
    }

    /// Heat since the start, J.
    #[getter]
    fn heat_j(&self) -> f64 {
        self.0.heat_j
    }

    /// Sets the height of mode (1,n) along `direction` (0 is x, 1 is y), m.
    fn set_height(&mut self, direction: usize, n: usize, height_m: f64) -> PyResult<()> {
        *place(&mut self.0.height, direction, n)? = finite("height_m", height_m)?;
        Ok(())
    }

    /// Sets the rate of the height of mode (1,n) along `direction`, m/s.
    fn set_rate(&mut self, direction: usize, n: usize, rate_m_s: f64) -> PyResult<()> {
        *place(&mut self.0.rate, direction, n)? = finite("rate_m_s", rate_m_s)?;
        Ok(())
    }

    /// Returns a copy.
    fn copy(&self) -> Self {
        self.clone()
    }
}

fn finite(name: &str, value: f64) -> PyResult<f64> {
    if value.is_finite() { Ok(value) } else { Err(refused(format!("{name} = {value}: it must be finite"))) }
}

fn place(table: &mut [[f64; RADIAL]; 2], direction: usize, n: usize) -> PyResult<&mut f64> {
    let found = table.get_mut(direction).and_then(|row| row.get_mut(n));
    found.ok_or_else(|| {
        refused(format!("there is no mode {n} along direction {direction}: modes 0 to 2, directions 0 and 1"))
    })
}
