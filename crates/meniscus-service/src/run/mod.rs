//! One run from the camera's link to its log: the threads, who feeds whom, and the order in which they end.
//!
//! ```text
//! camera's thread --link--> worker's thread --sinks--> publisher, viewers, identification, flight files
//!                                                      front end: the calling thread, until the worker has finished
//! ```
//! The library prints nothing: what a person should read at once goes to [`LiveRun::say`], the rest into [`Finished`].

mod flight_files;
pub mod statistics;
mod systemd;
mod turn_table;

pub use flight_files::FlightFiles;
pub use systemd::{attend as attend_service, tell_failure};
pub use turn_table::csv as turn_table;

use crate::identify::{Note, ProfileFeed, ProfileOutlet, Standing, channel};
use crate::live::{CrestImage, FlightRecorder, Log, Worker};
use crate::sink::{LatestTurn, TurnSink};
use crate::snapshot::SnapshotOutlet;
use meniscus::blob::Model;
use meniscus_platform::realtime::{Granted, Priority};
use meniscus_usb::camera::{Note as CameraNote, NoteBook};
use meniscus_usb::link::WorkerEnd;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Interval at which the camera's notes are looked at.
const NOTES_EVERY: Duration = Duration::from_millis(100);

/// A viewer of a run: a sink in the worker's thread and work in a thread of its own.
pub trait Viewer: Sync {
    /// Returns the viewer's sink for the worker.
    fn sink(&self) -> SnapshotOutlet;

    /// Shows turns until [`Self::end`] is called.
    fn show(&self, model: &Model<'_>);

    /// Takes what happened to the camera; nothing when it is well again.
    fn tell(&self, note: &str);

    /// Ends [`Self::show`]: the run is over.
    fn end(&self);
}

/// State of a run that the front end reads and sets while it goes.
#[derive(Debug, Default)]
pub struct RunState {
    /// Set by anyone who wants the run to end.
    pub stop: AtomicBool,
    /// Newest turn.
    pub latest: LatestTurn,
    /// Probabilities of the liquids; `None` where none are compared.
    pub standing: Mutex<Option<Standing>>,
    /// Events of the camera.
    pub notes: NoteBook,
}

/// Parts of a run.
pub struct LiveRun<'r> {
    /// The model, for the viewers.
    pub model: &'r Model<'r>,
    /// The worker.
    pub worker: Worker<'r>,
    /// The worker's end of the link to the camera.
    pub end: WorkerEnd,
    /// Frames whose turns the log keeps one by one; later turns are in its totals.
    pub frames: usize,
    /// Publishing to other programs.
    pub publishers: Vec<&'r mut dyn TurnSink>,
    /// Live page, Foxglove.
    pub viewers: &'r [&'r dyn Viewer],
    /// Liquids that are compared; none of them, no identification.
    pub notes: &'r [Note],
    /// Folder for the tables around missed deadlines.
    pub flights: &'r Path,
    /// Scheduling of the worker.
    pub priority: Priority,
    /// State that the front end shares.
    pub state: &'r RunState,
    /// Receives what a person should read while the run goes.
    pub say: &'r (dyn Fn(&str) + Sync),
    /// Receives what happens to the camera; the viewers receive it as well.
    pub tell: &'r (dyn Fn(&str) + Sync),
}

/// Result of a run.
#[derive(Debug)]
pub struct Finished {
    /// Turns and counters.
    pub log: Log,
    /// Image of the highest crest.
    pub crest: CrestImage,
    /// Tables around missed deadlines.
    pub flights: FlightFiles,
}

/// The worker's thread panicked; its message is on standard error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorkerPanicked;

impl std::fmt::Display for WorkerPanicked {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the worker stopped on an error of its own")
    }
}

impl std::error::Error for WorkerPanicked {}

impl LiveRun<'_> {
    /// Runs until the camera ends or `state.stop` is set. `camera` gets a thread of its own; `front` has the calling
    /// thread and returns once its argument says that the worker has finished.
    ///
    /// # Errors
    /// [`WorkerPanicked`].
    pub fn run(
        self,
        camera: impl FnOnce(&RunState) + Send,
        front: impl FnOnce(&dyn Fn() -> bool),
    ) -> Result<Finished, WorkerPanicked> {
        let Self {
            model,
            worker,
            end,
            frames,
            publishers,
            viewers,
            notes,
            flights,
            priority,
            state,
            say,
            tell,
        } = self;
        let (recorder, ended) = (FlightRecorder::default(), AtomicBool::new(false));
        let (recorder, ended) = (&recorder, &ended);
        let (width, height) = worker.config.image_size();
        let mut sinks = Sinks {
            log: Log::for_frames(frames),
            crest: CrestImage::new(model.header.fill_m as f32, width * height),
            publishers,
            viewers: viewers.iter().map(|viewer| viewer.sink()).collect(),
            profiles: None,
        };
        let mut feed: Option<ProfileFeed> = None;
        if !notes.is_empty() {
            let (outlet, end) = channel();
            (sinks.profiles, feed) = (Some(outlet), Some(end));
        }
        std::thread::scope(|scope| {
            scope.spawn(move || camera(state));
            let teller = scope.spawn(move || tell_notes(&state.notes, viewers, tell, ended));
            for viewer in viewers {
                scope.spawn(move || viewer.show(model));
            }
            recorder.open();
            let keeper = scope.spawn(move || FlightFiles::keep(recorder, flights, ended, say));
            let fill_m = model.header.fill_m;
            let identification =
                feed.map(|feed| scope.spawn(move || feed.attend(notes, fill_m, &state.standing, ended)));
            let worker = scope.spawn(move || {
                if priority == Priority::RealTime {
                    // A refusal is said, and the run goes on as well as it may.
                    Granted::ask().refusals().iter().for_each(|line| say(&format!("real time: {line}")));
                }
                sinks.run(worker, &end, state, recorder)
            });
            front(&|| worker.is_finished());
            let done = worker.join().map_err(|_| WorkerPanicked);
            ended.store(true, Ordering::Relaxed);
            let _ended = teller.join();
            viewers.iter().for_each(|viewer| viewer.end());
            // A thread that panicked has said so on standard error; the run's own log is not lost for it.
            let mut flights = keeper.join().unwrap_or_default();
            flights.lost = recorder.lost();
            let standing = identification.and_then(|thread| thread.join().ok());
            done.map(|(mut log, crest)| {
                log.recognised = standing;
                Finished { log, crest, flights }
            })
        })
    }
}

/// Tells every note of the camera to the viewers and to `tell`, until the run has `ended`.
fn tell_notes(notes: &NoteBook, viewers: &[&dyn Viewer], tell: &(dyn Fn(&str) + Sync), ended: &AtomicBool) {
    let mut reported = 0;
    loop {
        // Before the look, so that what came before the end is reported.
        let last = ended.load(Ordering::Relaxed);
        for note in notes.after(reported) {
            let line = note.to_string();
            tell(&line);
            let standing = if note == CameraNote::Recovered { "" } else { &line };
            viewers.iter().for_each(|viewer| viewer.tell(standing));
            reported += 1;
        }
        if last {
            return;
        }
        std::thread::sleep(NOTES_EVERY);
    }
}

/// Sinks that a run builds for its worker.
struct Sinks<'p> {
    log: Log,
    crest: CrestImage,
    publishers: Vec<&'p mut dyn TurnSink>,
    viewers: Vec<SnapshotOutlet>,
    profiles: Option<ProfileOutlet>,
}

impl Sinks<'_> {
    /// Runs the worker with these sinks, in the worker's thread.
    fn run(
        mut self,
        worker: Worker<'_>,
        end: &WorkerEnd,
        state: &RunState,
        recorder: &FlightRecorder,
    ) -> (Log, CrestImage) {
        let (mut ring, mut latest) = (recorder.ring(), &state.latest);
        {
            // Other programs first: each later sink delays them.
            let mut sinks: Vec<&mut dyn TurnSink> = Vec::new();
            sinks.extend(self.publishers.iter_mut().map(|sink| &mut **sink as &mut dyn TurnSink));
            sinks.extend(self.viewers.iter_mut().map(|sink| sink as &mut dyn TurnSink));
            sinks.extend(self.profiles.as_mut().map(|sink| sink as &mut dyn TurnSink));
            sinks.push(&mut latest);
            sinks.push(&mut ring);
            sinks.push(&mut self.crest);
            sinks.push(&mut self.log);
            worker.run(end, &state.stop, &mut sinks);
        }
        (self.log, self.crest)
    }
}
