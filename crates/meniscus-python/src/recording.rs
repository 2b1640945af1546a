//! Recordings as arrays.

mod build;

use crate::errors::{check_output, check_range, refused, system};
use crate::glass::Glass;
use crate::profile::{Profile, observe, perfect};
use crate::views::view;
use meniscus::surface::POINTS;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::recording::{
    COLUMNS, GROUP_COMPONENTS, GROUP_NAMES, Lattice, Recording as Recorded, STATE, States, StoreError,
    TRACERS, WALL_POINTS, group_names, group_range, wall_azimuth,
};
use numpy::ndarray::{ArrayView1, ArrayView2, ArrayView3, ShapeBuilder};
use numpy::{PyArray1, PyArray2, PyArray3, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::OnceLock;

/// A recording: one liquid in one moved glass at 60 Hz, on 2134 tracers. N is the number of frames.
///
/// Every array is read-only and a view on the recording's own memory. The states of a compact recording are expanded once, when
/// they are first requested (66 MB for 600 frames). Writing to `array.copy()` changes no recording.
///
/// Example:
///     >>> from meniscus_liquid import Recording
///     >>> recording = Recording.shipped()
///     >>> recording.frames, recording.field("v").shape
///     (600, (600, 2134, 3))
#[pyclass(frozen, module = "meniscus_liquid")]
pub(crate) struct Recording {
    pub(crate) recorded: Recorded,
    /// Full states of a compact recording, once they were requested.
    expanded: OnceLock<Vec<f32>>,
}

/// Returns the exception for a recording that cannot be read or written.
pub(crate) fn stored(error: StoreError) -> PyErr {
    match error {
        StoreError::Io(_, ref cause) if cause.kind() == std::io::ErrorKind::InvalidData => refused(error),
        StoreError::Io(..) => system(error),
        StoreError::Malformed(..) => refused(error),
    }
}

impl Recording {
    pub(crate) fn of(recorded: Recorded) -> Self {
        Self { recorded, expanded: OnceLock::new() }
    }

    /// Returns the recording inside the package.
    pub(crate) fn shipped_recorded() -> PyResult<Recorded> {
        let origin = std::path::Path::new("the shipped recording");
        Recorded::from_bytes(origin, meniscus_shipped::RECORDING).map_err(stored)
    }

    /// Returns all full states, frame after frame.
    pub(crate) fn states(&self) -> &[f32] {
        match &self.recorded.states {
            States::Full(all) => all,
            States::Factored(_) => self.expanded.get_or_init(|| {
                let mut all = vec![0.0; self.recorded.frames() * STATE];
                for (frame, state) in all.chunks_exact_mut(STATE).enumerate() {
                    self.recorded.state(frame, state);
                }
                all
            }),
        }
    }

    /// Returns the group called `name` of all states, N x 2134 x components.
    fn group(&self, name: &str) -> PyResult<ArrayView3<'_, f32>> {
        let group = GROUP_NAMES.iter().position(|known| *known == name).ok_or_else(|| {
            refused(format!("no field is called '{name}': take one of {}", GROUP_NAMES.join(", ")))
        })?;
        if !group_names(self.recorded.known).contains(&GROUP_NAMES[group]) {
            return Err(refused(format!(
                "the field '{name}' is not known in this recording: its numbers are of another liquid; known are {}",
                group_names(self.recorded.known).join(", ")
            )));
        }
        let components = GROUP_COMPONENTS[group];
        let shape = (self.recorded.frames(), TRACERS, components).strides((STATE, components, 1));
        let first = group_range(group).start;
        let states = self.states().get(first..).unwrap_or_default();
        ArrayView3::from_shape(shape, states).map_err(|error| refused(format!("field '{name}': {error}")))
    }
}

/// Returns `all` as frames x `columns`.
fn rows<T>(all: &[T], columns: usize) -> PyResult<ArrayView2<'_, T>> {
    ArrayView2::from_shape((all.len() / columns, columns), all).map_err(refused)
}

#[pymethods]
impl Recording {
    /// Reads the recording at `path`; every type and shape is checked.
    ///
    /// Raises:
    ///     OSError: The file cannot be read.
    ///     MeniscusError: It is not a whole recording.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        py.detach(|| Recorded::load(&path)).map(Self::of).map_err(stored)
    }

    /// Returns the recording inside the package: glycerine, 10 s, a motion that the shipped model has never seen.
    #[staticmethod]
    fn shipped() -> PyResult<Self> {
        Self::shipped_recorded().map(Self::of)
    }

    /// Returns a recording of arrays, as those of another simulator, 60 Hz.
    ///
    /// Args:
    ///     glass: The glass.
    ///     liquid: Name of the liquid.
    ///     density_kg_m3: Its density.
    ///     glass_x_m: Position of the glass along x, [N], float64.
    ///     column_m, wall_m, profile_m: Heights of the surface in the 194 columns, at the 72 wall points, and as the camera sees
    ///         it, m, [N, 194], [N, 72] and [N, 21], float32.
    ///     states: Full states, [N, 27742], float32: q, v, e, sigma, tau, group after group; or `None`.
    ///     known: Names of the groups that are of this liquid; without states `("surface",)`.
    ///     acceleration_m_s2: Acceleration along x, [N]; by default the second difference of the position.
    ///     command: How it was made, for the file.
    #[staticmethod]
    #[pyo3(signature = (glass, liquid, density_kg_m3, glass_x_m, column_m, wall_m, profile_m, *, states=None, known=None,
                        acceleration_m_s2=None, command="meniscus_liquid.Recording.from_arrays"))]
    #[allow(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
    fn from_arrays(
        glass: &Glass,
        liquid: String,
        density_kg_m3: f64,
        glass_x_m: numpy::PyReadonlyArray1<'_, f64>,
        column_m: numpy::PyReadonlyArray2<'_, f32>,
        wall_m: numpy::PyReadonlyArray2<'_, f32>,
        profile_m: numpy::PyReadonlyArray2<'_, f32>,
        states: Option<numpy::PyReadonlyArray2<'_, f32>>,
        known: Option<Vec<String>>,
        acceleration_m_s2: Option<numpy::PyReadonlyArray1<'_, f64>>,
        command: &str,
    ) -> PyResult<Self> {
        let arrays = build::Arrays {
            glass_x_m: glass_x_m.as_array(),
            column_m: column_m.as_array(),
            wall_m: wall_m.as_array(),
            profile_m: profile_m.as_array(),
            states: states.as_ref().map(|states| states.as_array()),
            acceleration_m_s2: acceleration_m_s2.as_ref().map(|a| a.as_array()),
        };
        let about = build::About { glass: glass.0, liquid, density_kg_m3, known, command: command.into() };
        build::recording(&arrays, about).map(Self::of)
    }

    /// Writes the recording to `path`, whole or not at all.
    #[pyo3(signature = (path, *, overwrite=false))]
    fn save(&self, py: Python<'_>, path: PathBuf, overwrite: bool) -> PyResult<()> {
        check_output(&path, overwrite)?;
        py.detach(|| self.recorded.save(&path)).map_err(stored)
    }

    /// Returns the recording with each field group as few modes as hold its relative error at `tolerance`, for a small file.
    #[pyo3(signature = (tolerance=0.005))]
    fn compact(&self, py: Python<'_>, tolerance: f64) -> PyResult<Self> {
        check_range("tolerance", &tolerance, 1e-6..=0.5)?;
        Ok(Self::of(py.detach(|| self.recorded.clone().compact(tolerance))))
    }

    /// Number of frames N, 1/60 s apart.
    #[getter]
    fn frames(&self) -> usize {
        self.recorded.frames()
    }

    fn __len__(&self) -> usize {
        self.recorded.frames()
    }

    /// Time of each frame since the start, s, [N].
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, (0..self.recorded.frames()).map(|n| n as f64 * FRAME_INTERVAL_S))
    }

    /// The glass.
    #[getter]
    fn glass(&self) -> Glass {
        Glass(self.recorded.glass)
    }

    /// Origin of the recording: liquid, density, motion, seed, command, spacing, pivot and effects.
    #[getter]
    fn provenance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let value = serde_json::to_value(&self.recorded.provenance).map_err(refused)?;
        crate::arguments::to_python(py, &value)
    }

    /// Field groups that are of this liquid: of `q`, `v`, `e`, `sigma`, `tau`, `surface`.
    #[getter]
    fn known(&self) -> Vec<&'static str> {
        group_names(self.recorded.known)
    }

    /// Whether the states are stored as a truncated singular value decomposition.
    #[getter]
    fn is_compact(&self) -> bool {
        matches!(self.recorded.states, States::Factored(_))
    }

    /// Relative error of the stored modes by group, measured after all rounding; `None` for full states.
    #[getter]
    fn truncation<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let States::Factored(factored) = &self.recorded.states else { return Ok(None) };
        let dict = PyDict::new(py);
        for (name, error) in GROUP_NAMES.iter().zip(factored.truncation) {
            dict.set_item(name, error)?;
        }
        Ok(Some(dict))
    }

    /// Position of the glass along x in the room, m, [N].
    #[getter]
    fn glass_x_m<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        view(slf, |this| Ok(ArrayView1::from(&this.recorded.glass_x_m)))
    }

    /// Position of the glass away from the camera, m, [N].
    #[getter]
    fn glass_y_m<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        view(slf, |this| Ok(ArrayView1::from(&this.recorded.glass_y_m)))
    }

    /// Position of the glass upwards, m, [N].
    #[getter]
    fn glass_z_m<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        view(slf, |this| Ok(ArrayView1::from(&this.recorded.glass_z_m)))
    }

    /// Inclination of the glass towards +x, rad, [N].
    #[getter]
    fn tilt_rad<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        view(slf, |this| Ok(ArrayView1::from(&this.recorded.tilt_rad)))
    }

    /// Acceleration of the glass along x, mean over the frame interval centred on the frame, m/s2, [N].
    #[getter]
    fn acceleration_m_s2<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        view(slf, |this| Ok(ArrayView1::from(&this.recorded.acceleration_m_s2)))
    }

    /// Height of the free surface in each tracer column, m, [N, 194].
    #[getter]
    fn column_m<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        view(slf, |this| rows(&this.recorded.column_m, COLUMNS))
    }

    /// Height of the contact line at each wall azimuth, m, [N, 72].
    #[getter]
    fn wall_m<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        view(slf, |this| rows(&this.recorded.wall_m, WALL_POINTS))
    }

    /// The surface as a perfect camera sees it, m, [N, 21].
    #[getter]
    fn profile_m<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        view(slf, |this| rows(&this.recorded.profile_m, POINTS))
    }

    /// Position of each tracer column in the glass at the height of the surface at rest, m, [194, 2].
    #[getter]
    fn columns_xy_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let columns = Lattice::new(&self.recorded.glass).columns;
        let flat: Vec<f64> = columns.into_iter().flatten().collect();
        Ok(rows(&flat, 2)?.to_pyarray(py))
    }

    /// Azimuth of each wall point, rad, [72]: 0 at +x, counter-clockwise from above.
    #[getter]
    fn wall_azimuth_rad<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, (0..WALL_POINTS).map(wall_azimuth))
    }

    /// Energies relative to rest, J: kinetic, potential, internal (heat), work and spilled, each [N].
    #[getter]
    fn energy_j<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        let books = &self.recorded.energy;
        dict.set_item("kinetic", PyArray1::from_iter(py, books.iter().map(|book| book.kinetic)))?;
        dict.set_item("potential", PyArray1::from_iter(py, books.iter().map(|book| book.potential)))?;
        dict.set_item("internal", PyArray1::from_iter(py, books.iter().map(|book| book.internal)))?;
        dict.set_item("work", PyArray1::from_iter(py, books.iter().map(|book| book.work)))?;
        dict.set_item("spilled", PyArray1::from_iter(py, books.iter().map(|book| book.spilled)))?;
        Ok(dict)
    }

    /// Volume that left over the rim since the start, m3, [N].
    #[getter]
    fn spilled_m3<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        view(slf, |this| Ok(ArrayView1::from(&this.recorded.spilled_m3)))
    }

    /// Full states, [N, 27742]: q, v, e, sigma, tau, group after group, tracer after tracer, SI units.
    #[getter(states)]
    fn states_array<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        view(slf, |this| rows(this.states(), STATE))
    }

    /// Returns one field of all frames, [N, 2134, components]: `q` position (m, 3), `v` velocity (m/s, 3), `e` specific internal
    /// energy (J/kg, 1), `sigma` normal stresses xx, yy, zz (Pa, 3), `tau` shear stresses xy, yz, zx (Pa, 3).
    ///
    /// A group that is not of this liquid is refused (`known`).
    fn field<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyArray3<f32>>> {
        view(slf, |this| this.group(name))
    }

    /// Returns one profile a frame, as the rendered camera sees it; `None` where the liquid was not seen.
    ///
    /// Args:
    ///     seed: Seed of the camera's noise.
    ///     noise_px: Noise of the disparity, pixels rms: 0.08 is a D435, 0.24 makes 2 mm of depth at 0.4 m.
    #[pyo3(signature = (seed=1, noise_px=0.08))]
    fn observe(&self, py: Python<'_>, seed: u64, noise_px: f64) -> PyResult<Vec<Option<Profile>>> {
        observe(py, &self.recorded, seed, noise_px)
    }

    /// Returns one profile a frame without a camera: every point seen, the position of the glass known.
    fn profiles(&self) -> Vec<Option<Profile>> {
        perfect(&self.recorded)
    }

    fn __repr__(&self) -> String {
        let provenance = &self.recorded.provenance;
        format!(
            "<Recording of {}, {}, {} frames>",
            provenance.liquid,
            provenance.motion,
            self.recorded.frames()
        )
    }
}
