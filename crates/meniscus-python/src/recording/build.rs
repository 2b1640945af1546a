//! Recordings from arrays that another program made.

use crate::errors::refused;
use meniscus::blob::{FieldGroup, KnownGroups};
use meniscus::surface::POINTS;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::recording::{
    COLUMNS, EnergyBook, GROUP_NAMES, Glass, Provenance, Recording, STATE, States, WALL_POINTS,
};
use numpy::ndarray::{ArrayView1, ArrayView2};
use pyo3::prelude::*;

/// The arrays, one row a frame.
pub(super) struct Arrays<'a> {
    pub(super) glass_x_m: ArrayView1<'a, f64>,
    pub(super) column_m: ArrayView2<'a, f32>,
    pub(super) wall_m: ArrayView2<'a, f32>,
    pub(super) profile_m: ArrayView2<'a, f32>,
    pub(super) states: Option<ArrayView2<'a, f32>>,
    pub(super) acceleration_m_s2: Option<ArrayView1<'a, f64>>,
}

/// Everything but the arrays.
pub(super) struct About {
    pub(super) glass: Glass,
    pub(super) liquid: String,
    pub(super) density_kg_m3: f64,
    pub(super) known: Option<Vec<String>>,
    pub(super) command: String,
}

/// Returns the numbers of `array`, refused where it is not `frames` x `columns` or has a number that is not finite.
fn table(name: &str, array: ArrayView2<'_, f32>, frames: usize, columns: usize) -> PyResult<Vec<f32>> {
    if array.dim() != (frames, columns) {
        let (has, wide) = array.dim();
        return Err(refused(format!("{name} is {has} x {wide}: {frames} frames need {frames} x {columns}")));
    }
    if let Some((place, value)) = array.indexed_iter().find(|(_, value)| !value.is_finite()) {
        return Err(refused(format!("{name}[{}, {}] is {value}: it must be finite", place.0, place.1)));
    }
    Ok(array.iter().copied().collect())
}

/// Returns the numbers of `array`, refused where it is not of `frames` or has a number that is not finite.
fn column(name: &str, array: ArrayView1<'_, f64>, frames: usize) -> PyResult<Vec<f64>> {
    if array.len() != frames {
        return Err(refused(format!("{name} has {} numbers for {frames} frames", array.len())));
    }
    if let Some((frame, value)) = array.indexed_iter().find(|(_, value)| !value.is_finite()) {
        return Err(refused(format!("{name}[{frame}] is {value}: it must be finite")));
    }
    Ok(array.to_vec())
}

/// Second difference of the position, m/s2: `(x(t+dt) - 2 x(t) + x(t-dt)) / dt^2`, the glass at rest before and after.
fn second_difference(x: &[f64]) -> Vec<f64> {
    let at = |n: usize| x.get(n).or(x.last()).copied().unwrap_or(0.0);
    let mean = |n: usize| {
        (at(n + 1) - 2.0 * at(n) + at(n.saturating_sub(1))) / (FRAME_INTERVAL_S * FRAME_INTERVAL_S)
    };
    (0..x.len()).map(mean).collect()
}

/// Returns the groups called `names`.
fn groups(names: &[String]) -> PyResult<KnownGroups> {
    let all: Vec<&str> = GROUP_NAMES.into_iter().chain(["surface"]).collect();
    names.iter().try_fold(KnownGroups::NONE, |known, name| {
        let place = all.iter().position(|group| group == name);
        let group = place.map(|place| FieldGroup::ALL[place]).ok_or_else(|| {
            refused(format!("no field group is called '{name}': take some of {}", all.join(", ")))
        })?;
        Ok(known.with(group))
    })
}

/// Returns the recording of `arrays`.
pub(super) fn recording(arrays: &Arrays<'_>, about: About) -> PyResult<Recording> {
    let frames = arrays.glass_x_m.len();
    if frames == 0 {
        return Err(refused("a recording needs a frame or more"));
    }
    let glass_x_m = column("glass_x_m", arrays.glass_x_m, frames)?;
    let acceleration_m_s2 = match arrays.acceleration_m_s2 {
        Some(given) => column("acceleration_m_s2", given, frames)?,
        None => second_difference(&glass_x_m),
    };
    if !(100.0..=20_000.0).contains(&about.density_kg_m3) {
        return Err(refused(format!(
            "density_kg_m3 = {} is out of range: 100 to 20000",
            about.density_kg_m3
        )));
    }
    let known = match (&about.known, arrays.states) {
        (Some(names), _) => groups(names)?,
        (None, Some(_)) => KnownGroups::ALL,
        (None, None) => KnownGroups::NONE.with(FieldGroup::Surface),
    };
    let states = match arrays.states {
        Some(states) => table("states", states, frames, STATE)?,
        None if known == KnownGroups::NONE.with(FieldGroup::Surface) => vec![0.0; frames * STATE],
        None => {
            return Err(refused("a recording without states knows the surface alone: known=(\"surface\",)"));
        }
    };
    Ok(Recording {
        glass: about.glass,
        provenance: Provenance {
            liquid: about.liquid,
            density_kg_m3: about.density_kg_m3,
            motion: "arrays".into(),
            seed: 0,
            command: about.command,
            spacing_m: 0.0,
            pivot_m: [0.0; 2],
            effects: Vec::new(),
        },
        glass_x_m,
        acceleration_m_s2,
        glass_y_m: vec![0.0; frames],
        glass_z_m: vec![0.0; frames],
        tilt_rad: vec![0.0; frames],
        column_m: table("column_m", arrays.column_m, frames, COLUMNS)?,
        wall_m: table("wall_m", arrays.wall_m, frames, WALL_POINTS)?,
        profile_m: table("profile_m", arrays.profile_m, frames, POINTS)?,
        energy: vec![EnergyBook::default(); frames],
        spilled_m3: vec![0.0; frames],
        states: States::Full(states),
        known,
    })
}
