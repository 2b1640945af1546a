//! The study of the camera's side: how far the surface can be trusted, condition by condition.
//!
//! ```text
//! conditions --render, extract--> judge --> rows and checks --> report, pictures
//! faults: the fault table through the session        golden: filters beside the library's frames
//! traced: glasses by a path tracer, with refraction, meniscus and scattering
//! ```
//!
//! The variance of a profile's points was calibrated on the scenes of other seeds than [`SEED`], on which it
//! is judged. The rendered scenes have no refraction by the glass and no meniscus on its wall; the path-traced ones have both.

pub mod conditions;
pub mod fault_table;
pub mod faults;
pub mod golden;
pub mod judge;
mod plots;
mod report;
mod speed;
pub mod traced;

pub use plots::{errors_png, scenes_png};
pub use report::report;

use conditions::{Case, Condition, DISTANCES_M, LOOKS};
use golden::{Golden, GoldenError};
use judge::{Judged, Row, judge};
use meniscus::surface::ConfigError;
use meniscus_hil::device::Habits;
use meniscus_report::checks::Check;
use meniscus_usb::camera::OutlineImage;
use rayon::prelude::*;
use std::path::Path;
use traced::rows::{TracedError, outcome as traced_rows};

/// Seed of the scenes that are judged.
pub const SEED: u64 = 2026;
/// Targets.
mod target {
    /// Root mean square error at the camera's noise, millimetres.
    pub(super) const RMS_MM: f64 = 0.6;
    /// Share of points inside their stated interval.
    pub(super) const COVERAGE: f64 = 0.95;
    /// From payload to profile, microseconds.
    pub(super) const ROI_US: f64 = 500.0;
    /// A quarter of the reference's 9.4 ms.
    pub(super) const SPATIAL_MS: f64 = 2.35;
}

/// Why there is no study.
#[derive(Debug)]
pub enum StudyError {
    /// A scene cannot be set up.
    Config(ConfigError),
    /// The reference frames are damaged.
    Golden(GoldenError),
    /// The path-traced scenes are damaged.
    Traced(TracedError),
}

impl std::fmt::Display for StudyError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Config(error) => write!(f, "a scene cannot be set up: {error}"),
            Self::Golden(error) => error.fmt(f),
            Self::Traced(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for StudyError {}

/// Results of the study.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The table.
    pub rows: Vec<Row>,
    /// The checks.
    pub checks: Vec<Check>,
    /// Every scene.
    pub scenes: Vec<Judged>,
    /// Troubles that did not end as they must, in words.
    pub unrecovered: Vec<String>,
    /// The comparison with the reference frames, or why there is none.
    pub golden: Result<Vec<golden::Compared>, String>,
    /// Why no path-traced scene was read, if none was; their rows and checks stand behind the others.
    pub traced_missing: Option<String>,
}

/// Folders of what others have made; by default those of the repository.
#[derive(Clone, Copy, Debug, Default)]
pub struct Material<'m> {
    /// Reference frames of the depth filters.
    pub reference: Option<&'m Path>,
    /// Path-traced scenes.
    pub traced: Option<&'m Path>,
}

/// Renders and reads `count` scenes of a seed; `done` is called behind each.
///
/// # Errors
/// [`StudyError`].
pub fn scenes(seed: u64, count: usize, done: impl Fn() + Sync) -> Result<Vec<Judged>, StudyError> {
    let one = |index| judge(Case::new(seed, index)).inspect(|_| done());
    (0..count).into_par_iter().map(one).collect::<Result<_, _>>().map_err(StudyError::Config)
}

/// Runs the whole study; `done` is called behind each scene, and behind each trouble of the fault table under each of the habits of
/// [`faults::HABITS`].
///
/// The depth filters are compared with the reference frames of `material`, and the path-traced scenes are read from there. A
/// program away from the repository has neither, and its outcome says so.
///
/// # Errors
/// [`StudyError`].
pub fn study(
    seed: u64,
    count: usize,
    material: Material<'_>,
    done: impl Fn() + Sync,
) -> Result<Outcome, StudyError> {
    let scenes = scenes(seed, count, &done)?;
    let drive = |((name, must), (habit, habits)): (&(&str, faults::Must), &(&str, Habits))| {
        let ended = faults::check(name, *must, OutlineImage::Infrared, *habits).err();
        done();
        ended.map(|why| format!("{habit}: {why}"))
    };
    let all =
        faults::TABLE.par_iter().flat_map(|line| faults::HABITS.par_iter().map(move |habits| (line, habits)));
    let unrecovered: Vec<String> = all.filter_map(drive).collect();
    let folder = material.reference.map_or_else(golden::folder, Path::to_path_buf);
    let golden = if material.reference.is_some() || folder.is_dir() {
        Ok(Golden::open(&folder).and_then(|golden| golden.compare()).map_err(StudyError::Golden)?)
    } else {
        Err(format!("{} is not there: the filters are compared with nothing", folder.display()))
    };
    let folder = material.traced.map_or_else(traced::set::folder, Path::to_path_buf);
    let is_there = material.traced.is_some() || folder.is_dir();
    let traced = if is_there { Some(traced_rows(&folder).map_err(StudyError::Traced)?) } else { None };
    let traced_missing =
        (!is_there).then(|| format!("{} is not there: no path-traced glass was read", folder.display()));
    let mut rows = rows(&scenes);
    let mut checks = checks(&rows, &scenes, &unrecovered, golden.as_ref().ok());
    match traced {
        Some(traced) => {
            rows.extend(traced.rows);
            checks.extend(traced.checks);
        }
        None => checks.push(traced::rows::rms(f64::NAN)),
    }
    Ok(Outcome { rows, checks, scenes, unrecovered, golden, traced_missing })
}

/// The table: by condition, and the scenes without clutter by liquid, distance and tilt.
fn rows(scenes: &[Judged]) -> Vec<Row> {
    let of = |keep: &dyn Fn(&Case) -> bool| -> Vec<&Judged> {
        scenes.iter().filter(|judged| keep(&judged.case)).collect()
    };
    let plain = |case: &Case| case.condition == Condition::Nominal;
    let mut rows = Vec::new();
    for condition in Condition::ALL {
        rows.push(Row::of("condition", condition.name(), &of(&|case| case.condition == condition)));
    }
    for (look, (name, ..)) in LOOKS.iter().enumerate() {
        rows.push(Row::of("nominal, liquid", *name, &of(&|case| plain(case) && case.look == look)));
    }
    for (distance, metres) in DISTANCES_M.iter().enumerate() {
        let chosen = of(&|case| plain(case) && case.distance == distance);
        rows.push(Row::of("nominal, distance", format!("{metres} m"), &chosen));
    }
    for (name, range) in [("up to 5 deg", 0.0..5.0), ("5 to 10 deg", 5.0..10.0), ("10 to 15 deg", 10.0..15.1)]
    {
        let chosen = of(&|case| plain(case) && range.contains(&case.tilt_deg.abs()));
        rows.push(Row::of("nominal, tilt", name, &chosen));
    }
    rows
}

fn checks(
    rows: &[Row],
    scenes: &[Judged],
    unrecovered: &[String],
    golden: Option<&Vec<golden::Compared>>,
) -> Vec<Check> {
    let row = |condition: Condition| rows.iter().find(|row| row.name == condition.name());
    let rms = |condition| row(condition).map_or(f64::NAN, |row| row.rms_mm);
    let points = || {
        scenes.iter().filter(|judged| judged.case.condition != Condition::NoLiquid).flat_map(|j| &j.points)
    };
    let inside = points().filter(|point| point.error_mm.abs() <= point.half_mm).count();
    let half_mm = points().map(|point| point.half_mm).sum::<f64>() / points().count() as f64;
    let total = faults::TABLE.len() * faults::HABITS.len();
    let equal = |frames: &[golden::Compared]| frames.iter().filter(|f| f.different == 0).count() as f64;
    let mut checks = vec![
        Check::at_most("surface_rms_nominal", rms(Condition::Nominal), "mm", target::RMS_MM),
        Check::informational("surface_rms_double_noise", rms(Condition::DoubleNoise), "mm"),
        Check::at_least("interval_coverage", inside as f64 / points().count() as f64, "1", target::COVERAGE),
        Check::informational("interval_half_width", half_mm, "mm"),
        Check::exactly(
            "false_profiles",
            row(Condition::NoLiquid).map_or(f64::NAN, |row| f64::from(row.profiles)),
            "1",
            0.0,
        ),
        Check::exactly("faults_recovered", (total - unrecovered.len()) as f64, "1", total as f64),
        Check::informational("faults_total", total as f64, "1"),
        Check::at_most("roi_path_us", speed::roi_path_us(), "us", target::ROI_US),
        Check::at_most("spatial_filter_ms", speed::spatial_filter_ms(), "ms", target::SPATIAL_MS),
    ];
    checks.push(match golden {
        Some(frames) => Check::exactly("golden_frames_equal", equal(frames), "1", frames.len() as f64),
        None => Check::at_least("golden_frames_equal", f64::NAN, "1", 1.0),
    });
    checks
}
