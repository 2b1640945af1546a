//! A model on liquids that it has not been trained on, before and after correction.
//!
//! ```text
//! recordings (simulated where they are missing) --rendered camera--> sightings
//!   unseen  --model A-->  before          learnt --correct--> model B;   unseen --model B--> after
//! ```
//! Learning sees profiles and positions of the glass alone; errors are against the truth, as of
//! [`meniscus_score::score`]; the depth noise is 2 mm.

mod checks;
mod motion_plans;
mod motion_sources;
mod plots;
mod report;
mod trial;
mod unseen;

pub use checks::checks;
pub use motion_plans::{COURSES, Course};
pub use motion_sources::{MotionSource, sources};
pub use plots::{curves_png, peaks_png};
pub use report::report;
pub use trial::{Peak, Trial, trial};
pub use unseen::unseen;

use crate::TrainError;
use crate::correct::{Corrected, Correction, Sightings, correct};
use meniscus::blob::{LoadError, Model};
use meniscus::runtime::Mode;
use meniscus::surface::ConfigError;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::effects::Effects;
use meniscus_data::liquids::Liquid;
use meniscus_data::motion::{Motion, MotionError};
use meniscus_data::recording::{Recording, StoreError};
use meniscus_data::scene_file::GLASS;
use meniscus_platform::files::AlignedBytes;
use meniscus_score::score::SurfaceError;
use meniscus_sph::{Setup, record};
use meniscus_virtual::observe_recording::{DISPARITY_RMS_PX, sightings, turns};
use meniscus_virtual::render::SceneSettings;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Length of every recording, s: three to four sloshes.
const SECONDS: f64 = 4.0;

/// The source liquid and its unseen recording.
pub const SOURCE: (&str, &str) = ("glycerine", "strokes:1301");

/// The same motion a fifth further and harder: up to 4.2 m/s2, where the recordings of a training end at 3.5.
const OUTSIDE: &str = "strokes:1301x1.2";

/// Why the study ended early.
#[derive(Debug)]
pub enum EvaluateError {
    /// A recording could not be had.
    Recording(StoreError),
    /// A recording could not be simulated.
    Simulation(String),
    /// The model is refused.
    Model(LoadError),
    /// The camera of the scene cannot be.
    Camera(ConfigError),
    /// The motion of a recording is none that the program draws.
    Motion(MotionError),
    /// A correction failed.
    Correction(TrainError),
}

impl std::fmt::Display for EvaluateError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Recording(error) => write!(f, "{error}"),
            Self::Simulation(why) => write!(f, "a recording could not be simulated: {why}"),
            Self::Model(error) => write!(f, "the model is refused: {error}"),
            Self::Camera(error) => write!(f, "{error}"),
            Self::Motion(error) => write!(f, "how {} was moved is not known: {error}", SOURCE.1),
            Self::Correction(error) => write!(f, "{error}"),
        }
    }
}

impl std::error::Error for EvaluateError {}

macro_rules! from {
    ($($error:ty => $variant:ident),*) => {
        $(impl From<$error> for EvaluateError {
            fn from(error: $error) -> Self {
                Self::$variant(error)
            }
        })*
    };
}
from!(StoreError => Recording, LoadError => Model, ConfigError => Camera, MotionError => Motion, TrainError => Correction);

/// Observer of a running study: the present task and the share of it that is done.
pub trait Watch {
    /// `done` of 1 of `what`.
    fn tell(&mut self, what: &str, done: f64);
    /// Whether a correction shows a bar of its own.
    fn quiet(&self) -> bool;
}

/// One liquid, before and after.
#[derive(Clone, Debug)]
pub struct LiquidResult {
    /// The liquid.
    pub course: Course,
    /// The model as it was.
    pub before: Trial,
    /// The corrected model.
    pub after: Trial,
    /// Record of the correction.
    pub corrected: Corrected,
    /// Slosh-relative error, before and after, on the recording of the source liquid that was not to be forgotten.
    pub source: [f64; 2],
}

/// The whole study.
#[derive(Clone, Debug)]
pub struct Study {
    /// The source liquid on its unseen recording.
    pub source: Trial,
    /// The source liquid moved a fifth further and harder than any recording that a model is trained on.
    pub outside: Trial,
    /// The source liquid within that range, with the motion of the glass from elsewhere.
    pub motion: Vec<MotionSource>,
    /// Relative error of the best linear forecast of the acceleration, from the true position of the glass and from the
    /// tracked one.
    pub acceleration_forecast: [f64; 2],
    /// Relative error of an oracle that is a frame late.
    pub oracle_error: f64,
    /// The liquids.
    pub results: Vec<LiquidResult>,
}

/// Runs the study with the model in `blob` on the recordings in `folder`, which are simulated there where
/// they are missing; `only` names the liquids, all if it is empty.
///
/// # Errors
/// [`EvaluateError`]; recordings that were simulated stay.
pub fn study(
    blob: &[u8],
    folder: &Path,
    only: &[String],
    seed: u64,
    stop: &AtomicBool,
    watch: &mut dyn Watch,
) -> Result<Study, EvaluateError> {
    let aligned = AlignedBytes::copy(blob);
    let model = Model::load(&aligned)?;
    let had = |liquid: &str, motion: &str, watch: &mut dyn Watch| obtain(folder, liquid, motion, watch);
    let unseen = had(SOURCE.0, SOURCE.1, watch)?;
    watch.tell("the camera looks at glycerine", 0.0);
    let source_seen = look(&unseen, seed)?;
    let source = trial(&model, &unseen, &source_seen);
    let mut motion = sources(&model, &unseen, &source_seen, seed);
    let (oracle, oracle_error) = motion_sources::oracle(&model, &unseen, &source_seen)?;
    motion.push(oracle);
    let acceleration_forecast = motion_sources::forecast_errors(&unseen, &source_seen);
    let outside = had(SOURCE.0, OUTSIDE, watch)?;
    let outside = trial(&model, &outside, &look(&outside, seed)?);
    // What must not be forgotten is not what the source is judged by.
    let kept = had(SOURCE.0, "strokes:101", watch)?;
    let kept_seen = vec![look(&kept, seed + 1)?];
    let knows = |model: &Model<'_>| surface_of(model, &kept, &kept_seen[0]);
    let known = knows(&model);
    let mut results = Vec::new();
    for course in COURSES {
        if !only.is_empty() && !only.iter().any(|name| name == course.name) {
            continue;
        }
        let mut learnt = Vec::new();
        for (k, motion) in (2..).zip(course.learnt) {
            let recording = had(course.liquid, motion, watch)?;
            watch.tell(&format!("the camera looks at {}", course.name), 0.0);
            learnt.push(look(&recording, seed + k)?);
        }
        let unseen = had(course.liquid, course.unseen, watch)?;
        let seen = look(&unseen, seed)?;
        let before = trial(&model, &unseen, &seen);
        watch.tell(&format!("{} is learnt", course.name), 0.0);
        let how = Correction {
            seed,
            liquid: format!("{} from {}", course.liquid, model.header.liquid),
            command: format!("meniscus evaluate --seed {seed}, {}", course.name),
            quiet: watch.quiet(),
            ..Correction::default()
        };
        let corrected = correct(blob, &learnt, &kept_seen, &how, stop)?;
        let new = AlignedBytes::copy(&corrected.blob);
        let new = Model::load(&new)?;
        let after = trial(&new, &unseen, &seen);
        results.push(LiquidResult { course, before, after, corrected, source: [known, knows(&new)] });
    }
    Ok(Study { source, outside, motion, acceleration_forecast, oracle_error, results })
}

/// Slosh-relative error of the surface that `model` estimates of `recording`.
fn surface_of(model: &Model<'_>, recording: &Recording, seen: &Sightings) -> f64 {
    let mut sums = SurfaceError::default();
    for (frame, logged) in turns(model, seen).iter().enumerate() {
        let estimate = &logged.turn.estimate;
        if matches!(estimate.mode, Mode::Tracking | Mode::Coasting) {
            sums.add(recording.profile(frame), &estimate.surface_m, recording.glass.fill_m);
        }
    }
    sums.slosh_rel()
}

/// Per cent.
fn percent(x: f64) -> f64 {
    100.0 * x
}

/// Returns the profiles that the camera saw of `recording`.
fn look(recording: &Recording, seed: u64) -> Result<Sightings, EvaluateError> {
    let scene =
        SceneSettings { disparity_rms_px: DISPARITY_RMS_PX, seed, ..SceneSettings::of(&recording.glass) };
    Ok(sightings(recording, scene)?)
}

/// The recording of `motion` in `folder/liquid`, simulated if it is not there.
fn obtain(
    folder: &Path,
    liquid: &str,
    motion: &str,
    watch: &mut dyn Watch,
) -> Result<Recording, EvaluateError> {
    let path: PathBuf = folder.join(liquid).join(format!("{}.safetensors", motion.replace(':', "-")));
    if path.exists() {
        return Ok(Recording::load(&path)?);
    }
    let wrong = |why: &dyn std::fmt::Display| EvaluateError::Simulation(format!("{liquid}, {motion}: {why}"));
    let parsed = Motion::parse(motion, SECONDS).map_err(|e| wrong(&e))?;
    let setup = Setup {
        glass: GLASS,
        liquid: Liquid::load(liquid).map_err(|e| wrong(&e))?,
        spacing_m: 0.005,
        seed: parsed.seed,
        no_slip: true,
        effects: Effects::default(),
        step_s: None,
    };
    let frames = (SECONDS / FRAME_INTERVAL_S).round() as usize;
    let command = format!("meniscus simulate --liquid {liquid} --motion {motion} --seconds {SECONDS}");
    let what = format!("{liquid}, {motion}");
    let tell = |done: usize| watch.tell(&what, done as f64 / frames as f64);
    let recording = record(&setup, &parsed, frames, &command, tell).map_err(|e| wrong(&e))?;
    let parent = path.parent().unwrap_or(folder);
    std::fs::create_dir_all(parent).map_err(|e| wrong(&format!("{}: {e}", parent.display())))?;
    recording.save(&path)?;
    Ok(recording)
}
