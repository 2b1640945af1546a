//! Rows and checks of the path-traced scenes that nobody looked at while the reader was written.

use super::degrade::Faults;
use super::judge::{FRAMES, read_scene};
use super::set::{Behind, Kind, Light, SetError, TracedScene, read};
use crate::camera_study::judge::{Counts, Point, Row};
use meniscus::surface::{ConfigError, Settings};
use meniscus_report::checks::Check;
use std::path::Path;

/// Start of the names of these scenes.
const JUDGED: &str = "judge";
/// Group of the rows.
const GROUP: &str = "path-traced";
/// Thickest wall of the scenes that have targets, millimetres.
const THICKEST_MM: f64 = 3.0;
/// Pixels by which borders of the depth image are wrong.
const BORDERS_PX: [i32; 6] = [-4, -2, -1, 2, 4, 6];
/// Heights of the projector's dots over white, grey levels.
const DOTS: [f32; 2] = [60.0, 150.0];
/// Factors on the light that saturate the image.
const GAINS: [f32; 2] = [2.0, 3.0];
/// Errors of the distance to a clear glass, metres: root mean square 3 mm, as the settings state it.
const DISTANCE_ERRORS_M: [f32; 7] = [-0.0045, -0.003, -0.0015, 0.0, 0.0015, 0.003, 0.0045];

/// Targets.
mod target {
    /// Root mean square error and mean error of an opaque liquid, millimetres.
    pub(super) const RMS_MM: f64 = 0.4;
    pub(super) const BIAS_MM: f64 = 0.2;
    /// Share of points inside their stated interval.
    pub(super) const COVERAGE: (f64, f64) = (0.9, 0.98);
    /// Root mean square error of clear water, millimetres, and the share of its frames with a profile.
    pub(super) const CLEAR_RMS_MM: f64 = 0.8;
    pub(super) const CLEAR_SEEN: f64 = 0.9;
}

/// Why the scenes were not read.
#[derive(Debug)]
pub enum TracedError {
    /// A file is missing or damaged.
    Set(SetError),
    /// A scene's settings are refused.
    Config(ConfigError),
}

impl std::fmt::Display for TracedError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Set(error) => error.fmt(f),
            Self::Config(error) => write!(f, "a path-traced scene cannot be read: {error}"),
        }
    }
}

impl std::error::Error for TracedError {}

/// Rows of the study's table, and its checks.
#[derive(Clone, Debug, Default)]
pub struct TracedOutcome {
    /// By liquid and fault.
    pub rows: Vec<Row>,
    /// Over the scenes of opaque liquids behind walls of 1 to 3 mm, and of clear water before a card.
    pub checks: Vec<Check>,
}

/// Frames of several readings.
#[derive(Default)]
struct Readings {
    scenes: usize,
    frames: u64,
    profiles: u32,
    saturated: u32,
    points: Vec<Point>,
}

impl Readings {
    fn take(
        &mut self,
        scene: &TracedScene,
        faults: &Faults,
        adjust: &dyn Fn(Settings) -> Settings,
    ) -> Result<(), TracedError> {
        let read = read_scene(scene, faults, adjust).map_err(TracedError::Config)?;
        self.frames += FRAMES;
        self.profiles += read.profiles;
        self.saturated += read.tally.saturated;
        self.points.extend(read.points);
        Ok(())
    }

    fn of(scenes: &[&TracedScene], faults: &Faults) -> Result<Self, TracedError> {
        let mut all = Self { scenes: scenes.len(), ..Self::default() };
        scenes.iter().try_for_each(|scene| all.take(scene, faults, &|settings| settings))?;
        Ok(all)
    }

    /// The same with each error of the stated distance.
    fn of_clear(scenes: &[&TracedScene]) -> Result<Self, TracedError> {
        let mut all = Self { scenes: scenes.len(), ..Self::default() };
        for (scene, error_m) in scenes.iter().flat_map(|scene| DISTANCE_ERRORS_M.map(|error| (scene, error)))
        {
            let elsewhere = |s: Settings| Settings { camera_distance_m: s.camera_distance_m + error_m, ..s };
            all.take(scene, &Faults::default(), &elsewhere)?;
        }
        Ok(all)
    }

    fn row(&self, name: impl Into<String>) -> Row {
        let Self { scenes, frames, profiles, .. } = *self;
        Row::of_points(GROUP, name.into(), Counts { scenes, frames, profiles }, &self.points)
    }
}

/// Reads the scenes in `folder` that nobody looked at.
///
/// # Errors
/// [`TracedError`].
pub fn outcome(folder: &Path) -> Result<TracedOutcome, TracedError> {
    let all = read(folder, JUDGED).map_err(TracedError::Set)?;
    let of = |keep: &dyn Fn(&TracedScene) -> bool| -> Vec<&TracedScene> {
        all.iter().filter(|scene| keep(scene)).collect()
    };
    let is = |scene: &TracedScene, kinds: &[Kind]| kinds.contains(&scene.truth.liquid);
    let thin = |scene: &TracedScene| scene.truth.wall_mm <= THICKEST_MM;
    let opaque = of(&|scene| is(scene, &[Kind::Coffee, Kind::Milk]) && thin(scene));
    let mut outcome = TracedOutcome::default();

    let plain = Readings::of(&opaque, &Faults::default())?.row("opaque, walls of 1 to 3 mm");
    let (least, most) = target::COVERAGE;
    outcome.checks.extend([
        rms(plain.rms_mm),
        Check::within("pathtraced_bias_mm", plain.bias_mm, "mm", -target::BIAS_MM, target::BIAS_MM),
        Check::within("pathtraced_coverage", plain.coverage, "1", least, most),
    ]);
    outcome.rows.push(plain);
    for (name, kind, thick) in [
        ("dark, up to 3 mm", Kind::Coffee, false),
        ("bright, up to 3 mm", Kind::Milk, false),
        ("dark, 3 to 4 mm", Kind::Coffee, true),
        ("bright, 3 to 4 mm", Kind::Milk, true),
    ] {
        let scenes = of(&|scene| is(scene, &[kind]) && thin(scene) != thick);
        outcome.rows.push(Readings::of(&scenes, &Faults::default())?.row(name));
    }
    outcome.add_faults(&opaque)?;
    outcome.add_clear(&of(&|scene| {
        is(scene, &[Kind::Water])
            && scene.truth.behind == Behind::Card
            && scene.truth.light == Light::NearInfrared
    }))?;

    let empty = Readings::of(&of(&|scene| is(scene, &[Kind::Empty])), &Faults::default())?;
    outcome.checks.push(Check::exactly("pathtraced_false_profiles", f64::from(empty.profiles), "1", 0.0));
    outcome.rows.push(empty.row("empty"));
    Ok(outcome)
}

/// Returns the check of the root mean square error; of NaN where nothing was read.
pub(in crate::camera_study) fn rms(rms_mm: f64) -> Check {
    Check::at_most("pathtraced_rms_mm", rms_mm, "mm", target::RMS_MM)
}

impl TracedOutcome {
    /// Opaque liquids under faults of the camera.
    fn add_faults(&mut self, opaque: &[&TracedScene]) -> Result<(), TracedError> {
        let mut add = |name: String, faults: Faults| -> Result<(Row, f64), TracedError> {
            let read = Readings::of(opaque, &faults)?;
            let row = read.row(name);
            self.rows.push(row.clone());
            Ok((row, f64::from(read.saturated) / f64::from(read.profiles)))
        };
        let (mut border_mm, mut dots_mm, mut dots_inside, mut noticed) = (0.0_f64, 0.0_f64, 1.0_f64, 1.0_f64);
        for border_px in BORDERS_PX {
            let name = format!("depth border {border_px:+} px");
            let (row, _) = add(name, Faults { border_px, ..Faults::default() })?;
            border_mm = border_mm.max(row.bias_mm.abs());
        }
        for dots in DOTS {
            let (row, _) = add(format!("dots of {dots} grey"), Faults { dots, ..Faults::default() })?;
            (dots_mm, dots_inside) = (dots_mm.max(row.rms_mm), dots_inside.min(row.coverage));
        }
        for gain in GAINS {
            let (_, share) = add(format!("{gain} times the light"), Faults { gain, ..Faults::default() })?;
            noticed = noticed.min(share);
        }
        self.checks.extend([
            Check::at_most("depth_border_bias_mm", border_mm, "mm", target::BIAS_MM),
            Check::at_most("pathtraced_dots_rms_mm", dots_mm, "mm", target::RMS_MM),
            Check::at_least("pathtraced_dots_coverage", dots_inside, "1", target::COVERAGE.0),
            Check::exactly("pathtraced_saturation_noticed", noticed, "1", 1.0),
        ]);
        Ok(())
    }

    /// Clear water before a card.
    fn add_clear(&mut self, clear: &[&TracedScene]) -> Result<(), TracedError> {
        let read = Readings::of_clear(clear)?;
        let row = read.row("clear water");
        self.checks.extend([
            Check::at_most("pathtraced_clear_rms_mm", row.rms_mm, "mm", target::CLEAR_RMS_MM),
            Check::at_least(
                "pathtraced_clear_seen",
                f64::from(read.profiles) / read.frames as f64,
                "1",
                target::CLEAR_SEEN,
            ),
        ]);
        self.rows.push(row);
        Ok(())
    }
}
