//! All moves of a study, kept one by one, so that an interrupted study goes on where it ended.

use super::carry::{Bench, Failure};
use super::draw::{Move, StudyLiquid, moves};
use super::judge::{Outcome, Planner, Planners, VERSION, judge};
use crate::models::{LearnedModel, ReducedLiquid};
use meniscus::blob::Model;
use meniscus_data::effects::Effects;
use meniscus_data::scene_file::GLASS;
use meniscus_platform::files::write_whole;
use meniscus_sph::{Setup, WatchedGlass};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Spacing of the particles, m.
const SPACING_M: f64 = 0.005;

/// Moves of a study, and their folder.
#[derive(Clone, Debug)]
pub struct StudyOptions {
    /// Moves.
    pub count: usize,
    /// First seed; tuning has other ones than reports.
    pub first_seed: u64,
    /// Folder of the outcomes.
    pub folder: PathBuf,
    /// Kind of the model that plans water.
    pub water: Planner,
}

impl StudyOptions {
    /// Kind of the model that plans a move.
    fn planner(&self, of: &Move) -> Planner {
        match of.liquid {
            StudyLiquid::Glycerine => Planner::Learned,
            StudyLiquid::Water => self.water,
        }
    }
}

/// Learned models that plan.
#[derive(Clone, Copy, Debug)]
pub struct StudyModels<'a> {
    /// Model of glycerine.
    pub glycerine: &'a Model<'a>,
    /// Model of water; the reduced model plans without.
    pub water: Option<&'a Model<'a>>,
}

/// Progress of a study.
#[derive(Clone, Copy, Debug)]
pub enum Progress<'a> {
    /// A glass of this liquid settles.
    Settling(&'a str),
    /// So many moves are done, of all.
    Done(usize, usize),
    /// A move failed, for this reason.
    Failed(&'a Move, &'a Failure),
}

/// Returns the outcomes in `folder` of the moves of `options`, in their order.
#[must_use]
pub fn read(options: &StudyOptions) -> Vec<Outcome> {
    let of = |one: &Move| outcome(options, one);
    moves(options.count, options.first_seed).iter().filter_map(of).collect()
}

/// The outcome of a move that is kept in the folder of `options`, planned by the model that they name.
fn outcome(options: &StudyOptions, of: &Move) -> Option<Outcome> {
    let planner = options.planner(of);
    let bytes = std::fs::read(file(&options.folder, of, planner)).ok()?;
    let outcome: Outcome = serde_json::from_slice(&bytes).ok()?;
    (outcome.version == VERSION && outcome.of == *of && outcome.planner == planner).then_some(outcome)
}

/// The file of a move: one for each planner, so that a study by another one replaces nothing.
fn file(folder: &Path, of: &Move, planner: Planner) -> PathBuf {
    folder.join(format!("{}-{}.json", of.name(), planner.name()))
}

/// Why a study ended.
pub type StudyError = Box<dyn std::error::Error + Send + Sync>;

/// Carries out what is missing of the moves of `options` with `models`, one move a processor, until `stop` is
/// raised.
///
/// # Errors
/// When a glass does not settle or a file cannot be written. A move that fails is reported to `progress` and left out.
pub fn run(
    options: &StudyOptions,
    models: StudyModels<'_>,
    stop: &AtomicBool,
    progress: impl Fn(Progress<'_>) + Sync,
) -> Result<(), StudyError> {
    let all = moves(options.count, options.first_seed);
    let missing: Vec<&Move> = all.iter().filter(|one| outcome(options, one).is_none()).collect();
    if missing.is_empty() || stop.load(Ordering::Relaxed) {
        return Ok(());
    }
    let glycerine = LearnedModel::new(models.glycerine);
    let learned_water = models.water.map(LearnedModel::new);
    let [thick, thin] =
        StudyLiquid::ALL.map(|liquid| liquid.load().map(|liquid| ReducedLiquid::new(&GLASS, &liquid)));
    let (Some(thick), Some(water)) = (thick?, thin?) else {
        return Err("the glass of the study is no cylinder".into());
    };
    let first_modes = [thick.first_mode(), water.first_mode()];
    let planners =
        Planners { glycerine: &glycerine, learned_water: learned_water.as_ref(), water: &water, first_modes };
    let mut settled = Vec::new();
    for liquid in StudyLiquid::ALL {
        progress(Progress::Settling(liquid.name()));
        let Some(glass) = settle(liquid, stop)? else { return Ok(()) };
        settled.push(glass);
    }
    let done = AtomicUsize::new(all.len() - missing.len());
    progress(Progress::Done(done.load(Ordering::Relaxed), all.len()));
    let one = |of: &Move| -> Result<(), StudyError> {
        let glass = &settled[usize::from(of.liquid == StudyLiquid::Water)];
        match judge(&planners, Bench { glass, fill_m: GLASS.fill_m, stop }, of) {
            Ok(outcome) => {
                let text = serde_json::to_string_pretty(&outcome)?;
                write_whole(&file(&options.folder, of, outcome.planner), text.as_bytes())?;
                progress(Progress::Done(1 + done.fetch_add(1, Ordering::Relaxed), all.len()));
            }
            Err(Failure::Simulation(meniscus_sph::Error::Stopped)) => {}
            Err(failure) => progress(Progress::Failed(of, &failure)),
        }
        Ok(())
    };
    each(&missing, stop, one)
}

/// Does `one` for every move, one move a processor. A simulation inside has one thread: its own threads would wait for each other.
fn each(
    missing: &[&Move],
    stop: &AtomicBool,
    one: impl Fn(&Move) -> Result<(), StudyError> + Sync,
) -> Result<(), StudyError> {
    let next = AtomicUsize::new(0);
    let worker = || -> Result<(), StudyError> {
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
        while let Some(of) = missing.get(next.fetch_add(1, Ordering::Relaxed)) {
            if stop.load(Ordering::Relaxed) {
                break;
            }
            alone.install(|| one(of))?;
        }
        Ok(())
    };
    let workers = std::thread::available_parallelism().map_or(1, usize::from).min(missing.len());
    std::thread::scope(|scope| {
        let all: Vec<_> = (0..workers).map(|_| scope.spawn(worker)).collect();
        let joined = |handle: std::thread::ScopedJoinHandle<'_, Result<(), StudyError>>| {
            handle.join().unwrap_or_else(|_| Err("a move of the study panicked".into()))
        };
        all.into_iter().try_for_each(joined)
    })
}

/// Settles the glass of the study with `liquid`; `None` where it was stopped.
fn settle(liquid: StudyLiquid, stop: &AtomicBool) -> Result<Option<WatchedGlass>, StudyError> {
    let setup = Setup {
        glass: GLASS,
        liquid: liquid.load()?,
        spacing_m: SPACING_M,
        seed: 0,
        no_slip: true,
        effects: Effects::default(),
        step_s: None,
    };
    match WatchedGlass::new(&setup, stop) {
        Ok(glass) => Ok(Some(glass)),
        Err(meniscus_sph::Error::Stopped) => Ok(None),
        Err(error) => Err(Box::new(Failure::from(error))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A study that is interrupted at once keeps nothing and is not an error; a file of another form is not read.
    #[test]
    fn what_is_not_whole_is_not_read() {
        let folder = std::env::temp_dir().join(format!("meniscus-plan-study-{}", std::process::id()));
        let options =
            StudyOptions { count: 2, first_seed: 1, folder: folder.clone(), water: Planner::Reduced };
        let bytes = meniscus_platform::files::AlignedBytes::copy(meniscus_shipped::MODEL);
        let model = Model::load(&bytes).expect("the shipped model");
        let stop = AtomicBool::new(true);
        run(&options, StudyModels { glycerine: &model, water: None }, &stop, |_| {}).expect("nothing to do");
        assert!(read(&options).is_empty());
        std::fs::create_dir_all(&folder).expect("a folder");
        std::fs::write(folder.join("glycerine-1-learned.json"), "{\"version\":0").expect("written");
        assert!(read(&options).is_empty());
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
