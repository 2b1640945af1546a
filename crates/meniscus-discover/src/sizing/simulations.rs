//! Batches of simulations: taken from the store, or made, one settled glass per processor.

use super::error::SizingError;
use super::store::{Heights, SimulationStore, digest_by, setup_digest};
use super::workload::{SimulationProgress, Workload};
use crate::insert::simulated::{Course, Resolution, SimulatedGlass};
use crate::insert::simulator::{GlassSimulator, Particles, SimulatorFault};
use crate::recordings::record::Record;
use crate::recordings::stated::Known;
use meniscus::reduced::effects::Active;
use meniscus_sph::Setup;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError, mpsc};
use std::time::Instant;

/// Part of the simulations of a round that one machine makes: `index` of `count`, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Number of the part, from 1.
    pub index: usize,
    /// Parts.
    pub count: usize,
}

impl Shard {
    /// Reads `INDEX/COUNT`.
    ///
    /// # Errors
    /// In words, when it is of another form or out of range.
    pub fn parse(text: &str) -> Result<Self, String> {
        let wrong =
            || format!("'{text}' is not a shard: write INDEX/COUNT with INDEX from 1 to COUNT, as 2/8");
        let (index, count) = text.split_once('/').ok_or_else(wrong)?;
        let number = |part: &str| part.trim().parse::<usize>().ok();
        let (index, count) = number(index).zip(number(count)).ok_or_else(wrong)?;
        if index == 0 || index > count {
            return Err(wrong());
        }
        Ok(Self { index, count })
    }

    /// Returns whether the work with the number or the digest `key` is of this part.
    pub(crate) fn holds(self, key: u64) -> bool {
        key % self.count as u64 == (self.index - 1) as u64
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

/// One simulation: a motion of a glass.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Glass and liquid.
    pub setup: Setup,
    /// Motion.
    pub course: Course,
}

/// Maker of simulations.
pub struct Simulations<'a> {
    /// Simulator that makes them.
    pub simulator: &'a dyn GlassSimulator,
    /// Store.
    pub store: &'a SimulationStore,
    /// Part that this machine makes; none makes all.
    pub shard: Option<Shard>,
    /// Flag that ends the work.
    pub stop: Option<&'a AtomicBool>,
    /// Observer.
    pub watch: &'a dyn Fn(SimulationProgress),
    /// Expected and finished work.
    pub workload: Mutex<Workload>,
    /// Simulations that were taken from the store.
    pub reused: AtomicUsize,
    /// Simulations that were made.
    pub made: AtomicUsize,
}

/// Simulations of one settled glass that are made one after the other.
struct Job {
    setup: Setup,
    /// Digest, place in the batch, motion.
    parts: Vec<(u64, Course)>,
}

impl<'a> Simulations<'a> {
    /// Returns a maker by the particle simulator that keeps its results in `store`.
    #[must_use]
    pub fn new(store: &'a SimulationStore, watch: &'a dyn Fn(SimulationProgress)) -> Self {
        Self {
            simulator: &Particles,
            store,
            shard: None,
            stop: None,
            watch,
            workload: Mutex::new(Workload::default()),
            reused: AtomicUsize::new(0),
            made: AtomicUsize::new(0),
        }
    }

    /// Returns the heights of each of `batch`; what is not in the store is made first.
    ///
    /// # Errors
    /// [`SizingError`], when the work was stopped, belongs to other shards, or cannot be kept.
    pub fn run(&self, batch: &[Wanted]) -> Result<Vec<Heights>, SizingError> {
        let of = self.simulator.identity();
        let keys: Vec<u64> = batch.iter().map(|w| digest_by(of, &w.setup, &w.course)).collect();
        let absent = |i: &usize| self.store.get(keys[*i], batch[*i].course.frames).is_none();
        let mut missing: Vec<usize> = (0..batch.len()).filter(absent).collect();
        missing.sort_by_key(|i| keys[*i]);
        missing.dedup_by_key(|i| keys[*i]);
        self.reused.fetch_add(batch.len() - missing.len(), Ordering::Relaxed);
        let others =
            missing.iter().filter(|i| self.shard.is_some_and(|shard| !shard.holds(keys[**i]))).count();
        let mine = missing.iter().filter(|i| self.shard.is_none_or(|shard| shard.holds(keys[**i])));
        log::info!(
            "{} of {} simulations are missing, {others} of them made elsewhere",
            missing.len(),
            batch.len()
        );
        let workers = rayon::current_num_threads();
        let jobs = jobs(mine.map(|i| (keys[*i], &batch[*i])), workers);
        self.make(&jobs, workers)?;
        if others > 0 {
            return Err(SizingError::Pending { missing: others });
        }
        let lost =
            || SizingError::Write(format!("a simulation is gone from {}", self.store.folder().display()));
        let of = |(key, wanted): (&u64, &Wanted)| self.store.get(*key, wanted.course.frames).ok_or_else(lost);
        keys.iter().zip(batch).map(of).collect()
    }

    /// Returns each channel of `record` by the simulator for `known` with `effects`, m.
    ///
    /// # Errors
    /// [`SizingError`], when the simulator does not carry an effect, it stops, or the work ends early.
    pub fn predict(
        &self,
        known: &Known,
        effects: &[Active],
        record: &Record,
        lag_s: f64,
        resolution: Resolution,
    ) -> Result<Vec<Vec<f64>>, SizingError> {
        let refused = |reason| SizingError::NotSimulated { reason };
        let glass = self.glass(known, effects, resolution).map_err(refused)?;
        let course = glass.course(record).map_err(refused)?;
        let heights = self.run(&[Wanted { setup: glass.setup.clone(), course }])?.remove(0);
        glass.channels(record, &heights.map_err(refused)?, lag_s).map_err(refused)
    }

    /// Returns the glass and liquid of `known` with `effects`, for the simulator.
    ///
    /// # Errors
    /// In words, when the simulator does not carry an effect or a value is out of its range.
    pub fn glass(
        &self,
        known: &Known,
        effects: &[Active],
        resolution: Resolution,
    ) -> Result<SimulatedGlass, String> {
        SimulatedGlass::of(self.simulator, known, effects, resolution)
    }

    /// Makes `jobs` on `workers` threads; the observer is called from this one.
    fn make<'j>(&self, jobs: &'j [Job], workers: usize) -> Result<(), SizingError> {
        let next = AtomicUsize::new(0);
        let begun = Instant::now();
        let (simulator, store, stop, made) = (self.simulator, self.store, self.stop, &self.made);
        let worker = Worker { simulator, store, stop, made };
        let (sender, receiver) = mpsc::channel::<Result<&'j Job, SizingError>>();
        let work = |sender: mpsc::Sender<Result<&'j Job, SizingError>>| {
            // Each processor has a pool of its own, so that a glass that waits for its parts takes up no other one.
            let Ok(alone) = rayon::ThreadPoolBuilder::new().num_threads(1).build() else { return };
            while let Some(job) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
                let stopped = stop.is_some_and(|stop| stop.load(Ordering::Relaxed));
                let done =
                    if stopped { Err(SizingError::Stopped) } else { alone.install(|| worker.make_one(job)) };
                let failed = done.is_err();
                // The receiver lives as long as this scope.
                let _sent = sender.send(done.map(|()| job));
                if failed {
                    return;
                }
            }
        };
        let ended = std::thread::scope(|scope| {
            for _ in 0..workers.min(jobs.len()) {
                let sender = sender.clone();
                scope.spawn(|| work(sender));
            }
            drop(sender);
            let mut ended = Ok(());
            for done in receiver {
                match done {
                    Ok(job) => self.tell(job, begun.elapsed().as_secs_f64()),
                    Err(error) => ended = Err(error),
                }
            }
            ended
        });
        let mut workload = self.workload.lock().unwrap_or_else(PoisonError::into_inner);
        workload.end_batch(begun.elapsed().as_secs_f64());
        ended
    }

    /// Books a finished job, `batch_s` after its batch began, and reports it to the observer.
    fn tell(&self, job: &Job, batch_s: f64) {
        let frames = job.parts.iter().map(|(_, course)| course.frames).sum();
        let mut workload = self.workload.lock().unwrap_or_else(PoisonError::into_inner);
        workload.finish(&job.setup, frames, job.parts.len(), batch_s);
        let progress = workload.progress();
        drop(workload);
        (self.watch)(progress);
    }
}

/// Things that the threads of a batch share.
struct Worker<'a> {
    simulator: &'a dyn GlassSimulator,
    store: &'a SimulationStore,
    stop: Option<&'a AtomicBool>,
    made: &'a AtomicUsize,
}

impl Worker<'_> {
    /// Makes one job and keeps its results; where it fails, each motion is tried alone to see which one fails.
    fn make_one(&self, job: &Job) -> Result<(), SizingError> {
        let courses: Vec<&Course> = job.parts.iter().map(|(_, course)| course).collect();
        log::debug!(
            "{} simulates {} motions with {:?}",
            self.simulator.name(),
            courses.len(),
            job.setup.effects
        );
        let keep = |key: u64, heights: &Heights| {
            self.made.fetch_add(1, Ordering::Relaxed);
            self.store.put(key, heights).map_err(|error| SizingError::Write(error.to_string()))
        };
        match self.simulator.run(&job.setup, &courses, self.stop) {
            Ok(all) => job.parts.iter().zip(all).try_for_each(|((key, _), heights)| keep(*key, &Ok(heights))),
            Err(SimulatorFault::Here(reason)) if courses.len() == 1 => keep(job.parts[0].0, &Err(reason)),
            Err(SimulatorFault::Here(_)) => job.parts.iter().try_for_each(|(key, course)| {
                match self.simulator.run(&job.setup, &[course], self.stop) {
                    Ok(mut all) => keep(*key, &Ok(all.remove(0))),
                    Err(SimulatorFault::Here(reason)) => keep(*key, &Err(reason)),
                    Err(fault) => Err(fault.into()),
                }
            }),
            Err(fault) => Err(fault.into()),
        }
    }
}

/// Groups simulations by their settled glass; groups are split where there are fewer of them than `workers`.
fn jobs<'a>(missing: impl Iterator<Item = (u64, &'a Wanted)>, workers: usize) -> Vec<Job> {
    let mut jobs: Vec<(u64, Job)> = Vec::new();
    for (key, wanted) in missing {
        let glass = setup_digest(&wanted.setup);
        let part = (key, wanted.course.clone());
        match jobs.iter_mut().find(|(digest, _)| *digest == glass) {
            Some((_, job)) => job.parts.push(part),
            None => jobs.push((glass, Job { setup: wanted.setup.clone(), parts: vec![part] })),
        }
    }
    let mut jobs: Vec<Job> = jobs.into_iter().map(|(_, job)| job).collect();
    let split = workers.div_ceil(jobs.len().max(1));
    if split > 1 {
        jobs = jobs
            .into_iter()
            .flat_map(|job| {
                let size = job.parts.len().div_ceil(split);
                let setup = job.setup;
                job.parts
                    .chunks(size)
                    .map(|parts| Job { setup: setup.clone(), parts: parts.to_vec() })
                    .collect::<Vec<_>>()
            })
            .collect();
    }
    jobs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shard_is_read_and_refused_with_what_to_write() {
        assert_eq!(Shard::parse("2/8"), Ok(Shard { index: 2, count: 8 }));
        for wrong in ["0/4", "5/4", "3", "a/b", "1/0"] {
            let refused = Shard::parse(wrong).expect_err(wrong);
            assert!(refused.contains(wrong) && refused.contains("INDEX/COUNT"), "{refused}");
        }
    }

    #[test]
    fn shards_share_every_simulation_out() {
        let shards: Vec<Shard> = (1..=3).map(|index| Shard { index, count: 3 }).collect();
        for key in [0, 1, 2, 17, u64::MAX] {
            assert_eq!(shards.iter().filter(|shard| shard.holds(key)).count(), 1, "{key}");
        }
    }
}
