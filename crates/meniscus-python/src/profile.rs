//! Profiles: heights of the surface at one instant, of a camera or of a recording.

use crate::arguments::Numbers;
use crate::errors::{check_output, check_range, refused, system};
use crate::model::Model;
use meniscus::blob::Header;
use meniscus::surface::{Config, POINTS, Settings, SurfaceProfile};
use meniscus::units::Micros;
use meniscus_bags::{observe_images, open};
use meniscus_data::profiles::{profiles_from_csv, profiles_to_csv};
use meniscus_data::recording::Recording;
use meniscus_platform::files::{read_text, write_whole};
use meniscus_service::setup::Setup;
use meniscus_virtual::observe_recording;
use meniscus_virtual::render::SceneSettings;
use numpy::PyArray1;
use pyo3::prelude::*;
use std::path::{Path, PathBuf};

/// Heights of the liquid's edge at 21 points across the glass, x from -0.9 R to 0.9 R, and what is known of them.
///
/// Args:
///     height_m: Heights above the inner bottom, m, [21]; NaN where a point was not seen.
///     std_m: Their standard deviations, m, [21] or one number.
///     glass_x_m: Position of the glass along x, m; `None` where its edges were not found.
///     sequence: Frame counter of the camera.
///     captured_us: Mid-exposure time on the camera's clock, microseconds.
///
/// Example:
///     >>> import numpy as np
///     >>> from meniscus_liquid import Profile
///     >>> Profile(np.full(21, 0.07), 1e-4, glass_x_m=0.0).valid.sum()
///     np.int64(21)
#[pyclass(frozen, eq, module = "meniscus_liquid")]
#[derive(Clone, PartialEq)]
pub(crate) struct Profile(pub(crate) SurfaceProfile);

/// Standard deviations: one for each point, or one for all.
#[derive(FromPyObject)]
pub(crate) enum Deviation<'py> {
    All(f64),
    Each(Numbers<'py>),
}

#[pymethods]
impl Profile {
    #[new]
    #[pyo3(signature = (height_m, std_m, *, glass_x_m=None, sequence=0, captured_us=0))]
    fn new(
        height_m: Numbers<'_>,
        std_m: Deviation<'_>,
        glass_x_m: Option<f64>,
        sequence: u32,
        captured_us: u64,
    ) -> PyResult<Self> {
        let heights = points("height_m", height_m.as_array().iter().copied())?;
        let deviations = match &std_m {
            Deviation::All(one) => [*one; POINTS],
            Deviation::Each(each) => points("std_m", each.as_array().iter().copied())?,
        };
        if let Some(x) = glass_x_m.filter(|x| !x.is_finite()) {
            return Err(refused(format!(
                "glass_x_m = {x}: it must be finite, or None where the glass was not seen"
            )));
        }
        let mut profile = SurfaceProfile {
            height_m: heights.map(|z| z as f32),
            variance_m2: [0.0; POINTS],
            valid: heights.map(|z| !z.is_nan()),
            glass_x_m: glass_x_m.map(|x| x as f32),
            sequence,
            captured: Micros(captured_us),
        };
        for point in (0..POINTS).filter(|point| profile.valid[*point]) {
            let (height, deviation) = (heights[point], deviations[point]);
            if !height.is_finite() || !(0.0..1e6).contains(&deviation) {
                return Err(refused(format!(
                    "point {point} has the height {height} m and the deviation {deviation} m: a height is finite, or NaN \
                     where the point was not seen, and a deviation is not negative"
                )));
            }
            profile.variance_m2[point] = (deviation * deviation) as f32;
        }
        for point in (0..POINTS).filter(|point| !profile.valid[*point]) {
            profile.height_m[point] = 0.0;
        }
        Ok(Self(profile))
    }

    /// Heights above the inner bottom, m, [21]; NaN where a point was not seen.
    #[getter]
    fn height_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        self.seen(py, self.0.height_m)
    }

    /// Standard deviations of the heights, m, [21]; NaN where a point was not seen.
    #[getter]
    fn std_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        self.seen(py, self.0.variance_m2.map(f32::sqrt))
    }

    /// Whether each point was seen, [21].
    #[getter]
    fn valid<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        PyArray1::from_slice(py, &self.0.valid)
    }

    /// Position of the glass along x, m; `None` where its edges were not found.
    #[getter]
    fn glass_x_m(&self) -> Option<f32> {
        self.0.glass_x_m
    }

    /// Frame counter of the camera.
    #[getter]
    fn sequence(&self) -> u32 {
        self.0.sequence
    }

    /// Mid-exposure time on the camera's clock, microseconds.
    #[getter]
    fn captured_us(&self) -> u64 {
        self.0.captured.0
    }

    fn __repr__(&self) -> String {
        format!(
            "<Profile {} at {} us, {} of {POINTS} points>",
            self.0.sequence,
            self.0.captured.0,
            self.0.valid_points()
        )
    }
}

impl Profile {
    fn seen<'py>(&self, py: Python<'py>, values: [f32; POINTS]) -> Bound<'py, PyArray1<f32>> {
        let each = values.into_iter().zip(self.0.valid);
        PyArray1::from_iter(py, each.map(|(value, valid)| if valid { value } else { f32::NAN }))
    }
}

/// Returns the 21 numbers of `values`.
fn points(name: &str, values: impl ExactSizeIterator<Item = f64>) -> PyResult<[f64; POINTS]> {
    let count = values.len();
    let values: Vec<f64> = values.collect();
    values
        .try_into()
        .map_err(|_| refused(format!("{name} has {count} numbers: a profile has {POINTS} points")))
}

fn wrapped(seen: Vec<Option<SurfaceProfile>>) -> Vec<Option<Profile>> {
    seen.into_iter().map(|profile| profile.map(Profile)).collect()
}

/// Returns the profiles that the rendered camera makes of `recording`.
pub(crate) fn observe(
    py: Python<'_>,
    recording: &Recording,
    seed: u64,
    noise_px: f64,
) -> PyResult<Vec<Option<Profile>>> {
    seen_by_camera(py, recording, seed, noise_px).map(wrapped)
}

/// The same as the core has them.
pub(crate) fn seen_by_camera(
    py: Python<'_>,
    recording: &Recording,
    seed: u64,
    noise_px: f64,
) -> PyResult<Vec<Option<SurfaceProfile>>> {
    check_range("noise_px", &noise_px, 0.0..=5.0)?;
    if !recording.is_level() {
        return Err(refused(
            "this recording is of a conical, round, lifted or inclined glass: the rendered camera shows upright cylinders on \
             a table",
        ));
    }
    let scene = SceneSettings { disparity_rms_px: noise_px, seed, ..SceneSettings::of(&recording.glass) };
    py.detach(|| observe_recording::sightings(recording, scene)).map_err(refused)
}

/// Returns the true profiles of `recording`.
pub(crate) fn perfect(recording: &Recording) -> Vec<Option<Profile>> {
    wrapped(observe_recording::perfect(recording))
}

/// Returns the profiles in a CSV file, as `meniscus record` writes it: one a line, times rising.
#[pyfunction]
pub(crate) fn load_profiles(path: PathBuf) -> PyResult<Vec<Profile>> {
    let named = |why: &dyn std::fmt::Display| format!("{}: {why}", path.display());
    let text = read_text(&path).map_err(|error| system(named(&error)))?;
    let profiles = profiles_from_csv(&text).map_err(|error| refused(named(&error)))?;
    Ok(profiles.into_iter().map(Profile).collect())
}

/// Writes profiles as a CSV file, whole or not at all.
#[pyfunction]
#[pyo3(signature = (path, profiles, *, overwrite=false))]
pub(crate) fn save_profiles(
    path: PathBuf,
    profiles: Vec<PyRef<'_, Profile>>,
    overwrite: bool,
) -> PyResult<()> {
    check_output(&path, overwrite)?;
    let profiles: Vec<SurfaceProfile> = profiles.iter().map(|profile| profile.0).collect();
    write_whole(&path, profiles_to_csv(&profiles).as_bytes()).map_err(system)
}

/// Returns the profiles in a camera's recording (.mcap, .bag, .db3, or a folder of images): one for each frame interval, `None`
/// where no frame came or no liquid was seen.
///
/// Args:
///     path: The recording.
///     setup: Glass and position of the camera, as `meniscus setup` wrote them.
///     model: Model that the profiles are for: its glass holds where the two differ by less than can be measured, and a
///         setup of another glass is refused.
#[pyfunction]
#[pyo3(signature = (path, setup, *, model=None))]
pub(crate) fn camera_profiles(
    py: Python<'_>,
    path: PathBuf,
    setup: PathBuf,
    model: Option<&Model>,
) -> PyResult<Vec<Option<Profile>>> {
    let header = model.map(|model| &model.weights().header);
    py.detach(|| of_camera(&path, &setup, header)).map(wrapped)
}

fn of_camera(path: &Path, file: &Path, header: Option<&Header>) -> PyResult<Vec<Option<SurfaceProfile>>> {
    let setup = Setup::read(file).map_err(refused)?;
    let recording = open(path).map_err(refused)?;
    let calibration = recording.calibration.clone();
    if setup.view.outline != calibration.outline {
        return Err(refused(format!(
            "{} has its outline in {}, the setup was made in the other image",
            path.display(),
            calibration.outline
        )));
    }
    let settings: Settings = match header {
        None => setup.settings(calibration.optics()),
        Some(header) => setup
            .settings_for(header, calibration.optics())
            .map_err(|misfit| refused(format!("{}: {misfit}", file.display())))?,
    };
    let config = Config::new(settings).map_err(|error| {
        refused(format!("the camera of {} cannot see that glass: {error}", path.display()))
    })?;
    observe_images(recording, config).map_err(refused)
}
