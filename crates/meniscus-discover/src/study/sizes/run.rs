//! Which trials are sized, and the sizing of each.
//!
//! The glasses that were held out while rules were made come first. Every trial leaves a file in `sized/`, and a study that
//! is run again sizes only what is missing.

use super::trial::{SizedTrial, SizedTrials, sized};
use crate::findings::Findings;
use crate::recordings::record::Record;
use crate::recordings::stated::Known;
use crate::sizing::error::SizingError;
use crate::sizing::outcome::Sizing;
use crate::sizing::simulations::Simulations;
use crate::sizing::stage::{SizingSettings, size};
use crate::sizing::store::SimulationStore;
use crate::study::bench::{Bench, Judged, StudyFolders, TimedFindings, findings};
use crate::study::cases::clean;
use crate::study::error::StudyError;
use crate::study::motions::MotionKind;
use crate::study::plans::{Family, Plan, plans};
use crate::study::run::{RunOptions, judged_before};
use crate::study::tally::class_right;
use meniscus_platform::files::write_whole;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

/// Spacing of the particles at the end, m: the default of `meniscus discover`, and that of the hidden glasses.
pub const SPACING_M: f64 = 0.005;

/// First packing less the seed; no glass of the study has these.
const FIRST_PACKING: u64 = 2000;

/// Sizes the judged trials at reference size whose verdict states a class, and those whose effect the library lacks.
///
/// Where `stop` is set or `options` judge nothing, only earlier results are gathered. `progress` gets the work, how much of
/// it is done and how much there is.
///
/// # Errors
/// [`StudyError`]; what was sized stays.
pub fn size_all(
    places: &StudyFolders,
    options: RunOptions,
    stop: &AtomicBool,
    progress: &dyn Fn(&str, usize, usize),
) -> Result<SizedTrials, StudyError> {
    let wanted = wanted(places, options);
    let planned = wanted.iter().filter(|(_, plan)| plan.answer.family != Family::Without).count();
    let mut out = SizedTrials { planned, ..SizedTrials::default() };
    let mut bench = None;
    for (done, (number, plan)) in wanted.iter().enumerate() {
        progress("sizing by simulation", done, wanted.len());
        let of = match plan.answer.family {
            Family::Without => &mut out.without,
            _ => &mut out.trials,
        };
        if let Some(sized) = sized_before(places, plan, options.spacing_m) {
            of.push(sized);
            continue;
        }
        let ready = plan.is_there(&places.cache)
            && clean(MotionKind::Single).iter().all(|truth| truth.is_there(&places.cache));
        if !options.judges(*number) || !ready || stop.load(Ordering::Relaxed) {
            continue;
        }
        let bench = match &mut bench {
            Some(bench) => bench,
            none => none.insert(Bench::new(places, MotionKind::Single)?),
        };
        let name = format!("t{number:03}");
        let TimedFindings { findings, .. } = findings(places, plan, bench, &name, None)?;
        let sizing = match sizing(places, &findings, bench, options, stop) {
            Err(SizingError::Stopped) => continue,
            Err(error) if error.ends_all() => return Err(StudyError::trial(error)),
            outcome => outcome,
        };
        let sized = sized(&plan.answer, &findings, sizing);
        let text = serde_json::to_string_pretty(&sized).map_err(StudyError::Json)?;
        write_whole(&file(places, plan, options.spacing_m), text.as_bytes())?;
        of.push(sized);
    }
    Ok(out)
}

/// Returns the trials to be sized with their numbers: those of the held-out glasses, of the others, and of effects that the
/// library lacks.
fn wanted(places: &StudyFolders, options: RunOptions) -> Vec<(usize, Plan)> {
    let plans = plans(options.cleans, options.seed).into_iter().enumerate();
    let (mut fresh, mut looked_at, mut without) = (Vec::new(), Vec::new(), Vec::new());
    for (number, plan) in plans {
        let of = match plan.answer.family {
            Family::Fresh => &mut fresh,
            Family::Hidden if plan.answer.size == 1.0 => &mut looked_at,
            Family::Without => &mut without,
            _ => continue,
        };
        let is_wanted = |judged: Judged| match plan.answer.family {
            Family::Without => matches!(judged.verdict.as_str(), "named" | "tied"),
            _ => class_right(&plan.answer, &judged).is_some(),
        };
        if judged_before(places, &plan).is_some_and(is_wanted) {
            of.push((number, plan));
        }
    }
    fresh.extend(looked_at);
    fresh.extend(without);
    fresh
}

fn file(places: &StudyFolders, plan: &Plan, spacing_m: f64) -> PathBuf {
    let at = if spacing_m == SPACING_M { String::new() } else { format!("-{:.0}um", 1e6 * spacing_m) };
    places.out.join("sized").join(format!("{}{at}.json", plan.digest()))
}

fn sized_before(places: &StudyFolders, plan: &Plan, spacing_m: f64) -> Option<SizedTrial> {
    let kept: SizedTrial =
        serde_json::from_slice(&std::fs::read(file(places, plan, spacing_m)).ok()?).ok()?;
    // A file from before the verdict was kept is made anew; its simulations are in the store.
    (!kept.verdict.is_empty()).then_some(kept)
}

/// Sizes the effects of `findings` by simulation, with the references of `bench` as control variate.
fn sizing(
    places: &StudyFolders,
    findings: &Findings,
    bench: &Bench,
    options: RunOptions,
    stop: &AtomicBool,
) -> Result<Sizing, SizingError> {
    let references: Vec<(Known, &[Record])> =
        bench.groups().iter().map(|group| (group.known, group.records.as_slice())).collect();
    let settings = SizingSettings {
        spacing_m: options.spacing_m,
        seed: FIRST_PACKING + options.seed,
        packings: 2,
        rivals: 1,
        store: places.cache.join("sizes"),
        shard: None,
    };
    let store = SimulationStore::new(&settings.store);
    let mut simulations = Simulations::new(&store, &|_| ());
    simulations.stop = Some(stop);
    size(findings, &references, &settings, &simulations)
}
