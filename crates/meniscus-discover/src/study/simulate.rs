//! Simulation of the study's glasses, one per processor.

use super::cases::truths;
use super::error::StudyError;
use crate::sizing::simulations::Shard;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Simulates every glass of the study that is not in `cache`, one per processor; `done` gets how many of how many are done.
/// Of a `part` only its share is made.
///
/// # Errors
/// [`StudyError`] of the first simulation that fails; those that are done stay.
pub fn simulate(
    cache: &Path,
    part: Option<Shard>,
    stop: &AtomicBool,
    done: impl Fn(usize, usize) + Sync,
) -> Result<(), StudyError> {
    let mine = |number: usize| part.is_none_or(|part| part.holds(number as u64));
    let glasses = truths().into_iter().enumerate().filter(|(number, _)| mine(*number));
    let missing: Vec<_> = glasses.map(|(_, truth)| truth).filter(|truth| !truth.is_there(cache)).collect();
    let count = AtomicUsize::new(0);
    done(0, missing.len());
    // One after the other off the list, so that the most needed are there first; where one cannot be made, the
    // others end theirs and begin no more. Each processor has a pool of its own: in a shared one a glass that waits
    // for its parts would take up the rest of the list meanwhile.
    let next = AtomicUsize::new(0);
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
