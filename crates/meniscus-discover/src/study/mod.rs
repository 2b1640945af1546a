//! The study: effects hidden in another simulator's data, clean glasses, measured water.

pub mod bench;
pub mod cases;
pub mod coverage;
pub mod error;
pub mod measured;
mod measured_runs;
pub mod motions;
pub mod page;
pub mod pictures;
pub mod plans;
pub mod run;
pub mod tally;
pub mod trial;
pub mod truth;

use super::calibrate::Calibration;
use super::group::Group;
use super::load::load;
use super::predict::{Known, predict};
use super::problem::Problem;
use super::record::{Channel, Quantity, Record};
use super::settings::Settings;
use super::thresholds::Thresholds;
use super::workflow::discover;
use crate::motion_table::drive_of;
use crate::study::error::StudyError;
use crate::motion_plan::MotionPlan;
use meniscus::reduced::effects::{Active, EffectKind};
use meniscus_data::motion::Motion;
use meniscus_numerics::random::normal;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Draws of the test of intervals.
const DRAWS: usize = 160;

/// Simulates every glass of the study that is not in `cache`, one per processor; `done` gets how many of how many are done.
///
/// # Errors
/// [`StudyError`] of the first simulation that fails; those that are done stay.
pub fn simulate(
    cache: &Path,
    stop: &AtomicBool,
    done: impl Fn(usize, usize) + Sync,
) -> Result<(), StudyError> {
    let missing: Vec<_> = cases::truths().into_iter().filter(|truth| !truth.is_there(cache)).collect();
    let count = std::sync::atomic::AtomicUsize::new(0);
    done(0, missing.len());
    // One after the other off the list, so that the most needed are there first; where one cannot be made, the
    // others end theirs and begin no more. Each processor has a pool of its own: in a shared one a glass that waits
    // for its parts would take up the rest of the list meanwhile.
    let next = std::sync::atomic::AtomicUsize::new(0);
    let failed = AtomicBool::new(false);
    let work = || -> Result<(), StudyError> {
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(StudyError::Pool)?;
        while let Some(truth) = missing.get(next.fetch_add(1, Ordering::Relaxed)) {
            if stop.load(Ordering::Relaxed) || failed.load(Ordering::Relaxed) {
                return Ok(());
            }
            let made = alone.install(|| truth.make(cache));
            made.inspect_err(|_| failed.store(true, Ordering::Relaxed)).map_err(StudyError::trial)?;
            done(1 + count.fetch_add(1, Ordering::Relaxed), missing.len());
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..rayon::current_num_threads()).map(|_| scope.spawn(work)).collect();
        let ended = |worker: std::thread::ScopedJoinHandle<'_, Result<(), StudyError>>| {
            worker.join().unwrap_or(Err(StudyError::Panic))
        };
        workers.into_iter().try_for_each(ended)
    })
}

/// Returns the coverage of 90 % intervals by draws from the model as the references under `out` calibrate it, and the
/// number of draws; none where there are no references.
///
/// # Errors
/// [`StudyError`], when a reference cannot be used.
pub fn reference_coverage(out: &Path, seed: u64) -> Result<Option<(f64, usize)>, StudyError> {
    let mut groups = Vec::new();
    for index in 0.. {
        let path = out.join(format!("references/single-{index}"));
        if !path.join("setup.toml").exists() {
            break;
        }
        let folder = load(&path)?;
        groups.push(Group::new(folder.known, folder.records, None)?);
    }
    let Some((first, others)) = groups.split_first() else { return Ok(None) };
    let records = &first.split.fitted;
    let others: Vec<&Group> = others.iter().collect();
    let problem = Problem::new(records, first.known, &Calibration::from(&others, records, None), 1.0)?;
    Ok(Some((coverage::coverage(&problem, DRAWS, seed), DRAWS)))
}

/// Returns a recording of `course` by the reduced model itself, with white noise of `noise_m`.
#[must_use]
pub fn made_up(
    name: &str,
    known: &Known,
    course: &MotionPlan,
    theta: &[f64],
    noise_m: f64,
    seed: u64,
) -> Option<Record> {
    made_up_with(name, known, course, theta, &[], noise_m, seed)
}

/// Returns the same with effects.
#[must_use]
pub fn made_up_with(
    name: &str,
    known: &Known,
    course: &MotionPlan,
    theta: &[f64],
    active: &[Active],
    noise_m: f64,
    seed: u64,
) -> Option<Record> {
    let motion = Motion::sampled(&course.samples())?;
    let kinds = [Quantity::Level, Quantity::Slope, Quantity::Bow, Quantity::Place];
    let mut record = Record {
        name: name.into(),
        interval_s: meniscus::units::FRAME_INTERVAL_S,
        channels: kinds.map(|quantity| Channel { quantity, value: vec![None; course.frames()] }).to_vec(),
        drive: drive_of(&motion, course.seconds),
        rest_frames: (course.jolts[0].start_s / meniscus::units::FRAME_INTERVAL_S) as usize,
    };
    let expected = predict(&record, known, theta, 0.0, active);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for (channel, expected) in record.channels.iter_mut().zip(expected) {
        channel.value = expected.iter().map(|z| Some(z + noise_m * normal(&mut random))).collect();
    }
    Some(record)
}

/// Returns the seconds of one discovery on three recordings of 10 s and a held-out one, with three references.
///
/// The recordings are made up, because the time does not depend on what they show.
///
/// # Errors
/// [`StudyError`], when it fails.
pub fn long_discovery_s() -> Result<f64, StudyError> {
    let known = Known {
        radius_m: 0.035,
        fill_m: 0.07,
        density_kg_m3: truth::DENSITY_KG_M3,
        viscosity_pa_s: cases::VISCOSITY_PA_S,
        motion_share: [1.0; 2],
    };
    let theta = Calibration::blind(&[], 0.0).mean;
    let make = |known: &Known, seed: u64, active: &[Active]| -> Vec<Record> {
        let courses = [0.6, 1.2, 2.2, 1.7].map(|a| MotionPlan::jolt(0.28, a, 10.0));
        let all = courses.iter().enumerate();
        all.filter_map(|(i, c)| made_up_with("long", known, c, &theta, active, 1e-4, seed + i as u64))
            .collect()
    };
    let mut groups = Vec::new();
    for (i, factor) in [0.85, 1.0, 1.15].into_iter().enumerate() {
        let known = Known { viscosity_pa_s: factor * known.viscosity_pa_s, ..known };
        groups.push(Group::new(known, make(&known, 10 * i as u64, &[]), None)?);
    }
    let references: Vec<&Group> = groups.iter().collect();
    let entry = EffectKind::YieldStress.effect();
    let records = make(&known, 99, &[Active { entry, values: [1.0, 0.0] }]);
    let begun = Instant::now();
    discover(&records, known, &references, &Thresholds::default(), &Settings::default())?;
    Ok(begun.elapsed().as_secs_f64())
}
