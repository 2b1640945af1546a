//! Simulation of the planned recordings: several at once, and none of them twice.
//!
//! A recording is finished when its file can be read whole, has the planned length and carries the command that makes it. Anything
//! else of that name is simulated again. Files are written whole or not at all. A simulation that fails leaves a note with the
//! reason, so that a run that goes on does not spend the time again.
//!
//! Each worker simulates one recording on threads of its own. One simulation on all processors would wait at the end of every sum.

use crate::error::RelearnError;
use crate::motions::SimulatedRecording;
use crate::progress::Progress;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::motion::Motion;
use meniscus_data::recording::{Recording, States};
use meniscus_platform::files::write_whole;
use meniscus_sph::{Setup, record};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Part of the recordings that one job of several simulates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Number of the job, from 1.
    pub job: usize,
    /// Jobs in all.
    pub jobs: usize,
}

impl Shard {
    /// All recordings.
    pub const WHOLE: Self = Self { job: 1, jobs: 1 };

    /// Whether recording number `index` is of this job.
    fn has(self, index: usize) -> bool {
        index % self.jobs == self.job - 1
    }
}

/// Processors of the simulations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Workers {
    /// Processors in all; 0 takes all that the machine has.
    pub processors: usize,
    /// Part of the recordings that is simulated here.
    pub shard: Shard,
}

impl Default for Workers {
    fn default() -> Self {
        Self { processors: 0, shard: Shard::WHOLE }
    }
}

/// Everything that the simulations of a run share.
pub(crate) struct Simulations<'a> {
    /// Glass, liquid and spacing; its seed is that of each motion.
    pub(crate) setup: &'a Setup,
    /// Length of each recording, s.
    pub(crate) seconds: f64,
    /// Liquid, as the command of each recording names it.
    pub(crate) liquid: &'a str,
    /// Folder of the recordings.
    pub(crate) folder: PathBuf,
}

/// Simulation that failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FailedSimulation {
    /// Recording.
    pub(crate) recording: String,
    /// Reason.
    pub(crate) why: String,
}

/// Results of one pass over the planned recordings.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pass {
    /// Recordings that were simulated now.
    pub(crate) simulated: usize,
    /// Recordings that lay there finished.
    pub(crate) reused: usize,
    /// Simulations that failed, now or before.
    pub(crate) failed: Vec<FailedSimulation>,
}

impl Simulations<'_> {
    /// Path of a recording.
    pub(crate) fn path(&self, one: &SimulatedRecording) -> PathBuf {
        self.folder.join(format!("{}.safetensors", one.name))
    }

    /// Path of the note of a failure.
    fn note(&self, one: &SimulatedRecording) -> PathBuf {
        self.folder.join(format!("{}.failed.txt", one.name))
    }

    /// Frames of each recording.
    fn frames(&self) -> usize {
        (self.seconds / FRAME_INTERVAL_S).round() as usize
    }

    /// Command that makes `one` again, as `meniscus simulate` writes it.
    fn command(&self, one: &SimulatedRecording) -> String {
        let spacing_mm = (1e9 * self.setup.spacing_m).round() / 1e6;
        // Measured motions lie in the folder of the run, whose place means nothing elsewhere.
        let path = Path::new(&one.motion);
        let motion = if one.motion.contains(':') { Some(path.as_os_str()) } else { path.file_name() };
        format!(
            "meniscus simulate --liquid {} --motion {} --seconds {} --spacing-mm {spacing_mm}",
            self.liquid,
            motion.unwrap_or_default().to_string_lossy(),
            self.seconds
        )
    }

    /// Returns the finished recording `one`; `None` where there is none, or half of one, or another's.
    pub(crate) fn finished(&self, one: &SimulatedRecording) -> Option<Recording> {
        let recording = Recording::load(&self.path(one)).ok()?;
        // An effect of the liquid may change the fill.
        let glass = self.setup.resolved().glass;
        let same = recording.provenance.command == self.command(one) && recording.glass == glass;
        let finite = match &recording.states {
            States::Full(all) => all.iter().all(|x| x.is_finite()),
            States::Factored(_) => true,
        };
        (same && finite && recording.frames() == self.frames()).then_some(recording)
    }

    /// Returns the reason for which `one` failed before with the same command.
    fn failed_before(&self, one: &SimulatedRecording) -> Option<String> {
        let note = std::fs::read_to_string(self.note(one)).ok()?;
        let (command, why) = note.split_once('\n')?;
        (command == self.command(one)).then(|| why.trim().to_owned())
    }

    /// Simulates what of `planned` is missing.
    ///
    /// # Errors
    /// [`RelearnError`], when a recording cannot be written or the run was stopped.
    pub(crate) fn run(
        &self,
        planned: &[SimulatedRecording],
        workers: Workers,
        stop: &AtomicBool,
        progress: &dyn Progress,
    ) -> Result<Pass, RelearnError> {
        let mut pass = Pass::default();
        let mut missing = Vec::new();
        for (index, one) in planned.iter().enumerate() {
            if let Some(why) = self.failed_before(one) {
                pass.failed.push(FailedSimulation { recording: one.name.clone(), why });
            } else if self.finished(one).is_some() {
                pass.reused += 1;
            } else if workers.shard.has(index) {
                missing.push(one);
            }
        }
        let done = self.all(&missing, workers.processors, stop, progress);
        for (one, result) in missing.iter().zip(done) {
            match result {
                Some(Ok(Ok(()))) => pass.simulated += 1,
                Some(Ok(Err(why))) => {
                    pass.failed.push(FailedSimulation { recording: one.name.clone(), why });
                }
                Some(Err(error)) => return Err(error),
                None => {}
            }
        }
        if stop.load(Ordering::Relaxed) {
            let kept =
                format!("{} of {} recordings are finished", pass.simulated + pass.reused, planned.len());
            return Err(RelearnError::Interrupted { stage: "simulate", kept });
        }
        Ok(pass)
    }

    /// Simulates all of `missing` on `processors`, one result for each; `None` for those that were not begun.
    #[allow(clippy::type_complexity, reason = "the disk's error around the simulation's, for each recording")]
    fn all(
        &self,
        missing: &[&SimulatedRecording],
        processors: usize,
        stop: &AtomicBool,
        progress: &dyn Progress,
    ) -> Vec<Option<Result<Result<(), String>, RelearnError>>> {
        let machine = std::thread::available_parallelism().map_or(1, usize::from);
        let processors = if processors == 0 { machine } else { processors };
        let workers = processors.min(missing.len()).max(1);
        let (next, frames) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let results = Mutex::new(Vec::new());
        results.lock().unwrap_or_else(PoisonError::into_inner).resize_with(missing.len(), || None);
        let total = (missing.len() * self.frames()).max(1);
        let advanced = || {
            let done = frames.fetch_add(1, Ordering::Relaxed) + 1;
            progress.advances(done as f64 / total as f64);
        };
        std::thread::scope(|scope| {
            for _ in 0..workers {
                scope.spawn(|| {
                    while !stop.load(Ordering::Relaxed) {
                        let index = next.fetch_add(1, Ordering::Relaxed);
                        let Some(one) = missing.get(index) else { break };
                        let result = self.one(one, processors / workers, &advanced);
                        let broken = result.is_err();
                        results.lock().unwrap_or_else(PoisonError::into_inner)[index] = Some(result);
                        if broken {
                            // What one cannot write, the others cannot either.
                            next.store(missing.len(), Ordering::Relaxed);
                        }
                    }
                });
            }
        });
        results.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    /// Simulates `one` on `threads` and writes it, or the note of its failure.
    fn one(
        &self,
        one: &SimulatedRecording,
        threads: usize,
        advanced: &(dyn Fn() + Sync),
    ) -> Result<Result<(), String>, RelearnError> {
        let motion = Motion::parse(&one.motion, self.seconds)?;
        let setup = Setup { seed: motion.seed, ..self.setup.clone() };
        let command = self.command(one);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.max(1)).build();
        let simulated = match pool {
            Ok(pool) => pool.install(|| record(&setup, &motion, self.frames(), &command, |_| advanced())),
            Err(_) => record(&setup, &motion, self.frames(), &command, |_| advanced()),
        };
        match simulated {
            Ok(recording) => {
                recording.save(&self.path(one))?;
                Ok(Ok(()))
            }
            Err(error) => {
                let why = format!("{}: {error}", one.name);
                write_whole(&self.note(one), format!("{command}\n{why}\n").as_bytes())?;
                Ok(Err(why))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_cover_every_recording_once() {
        for jobs in 1..6 {
            for index in 0..20 {
                let having = (1..=jobs).filter(|&job| Shard { job, jobs }.has(index)).count();
                assert_eq!(having, 1, "recording {index} of {jobs} jobs");
            }
        }
    }
}
