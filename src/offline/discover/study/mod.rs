//! The study: effects hidden in another simulator's data, clean glasses, measured water.

pub mod cases;
pub mod courses;
pub mod truth;

use crate::offline::prelude::*;
use rayon::prelude::*;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// Simulates every glass of the study that is not in `cache`, one a processor; tells `done` of each.
///
/// # Errors
/// In words, the first simulation that fails; those that are done stay.
pub fn simulate(cache: &Path, stop: &AtomicBool, done: impl Fn(usize, usize) + Sync) -> Result<(), String> {
    let missing: Vec<_> = cases::truths().into_iter().filter(|truth| !truth.is_there(cache)).collect();
    let count = std::sync::atomic::AtomicUsize::new(0);
    done(0, missing.len());
    // One after the other off the list, so that the most needed are there first.
    let next = std::sync::atomic::AtomicUsize::new(0);
    (0..rayon::current_num_threads()).into_par_iter().try_for_each(|_| {
        while let Some(truth) = missing.get(next.fetch_add(1, Ordering::Relaxed)) {
            if stop.load(Ordering::Relaxed) {
                return Ok(());
            }
            truth.make(cache)?;
            done(1 + count.fetch_add(1, Ordering::Relaxed), missing.len());
        }
        Ok(())
    })
}
