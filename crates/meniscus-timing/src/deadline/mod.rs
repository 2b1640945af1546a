//! Deadline study: minutes of turns beside a load, each turn in a histogram, each missed deadline reported.
//!
//! ```text
//! pace: images rendered before --a frame every 1/rate s--> link --> the worker of `meniscus run` --> log
//! load: processor, memory and disk, in threads of their own        steal: what the host took, meanwhile
//! tally: latency = estimate ready - last byte due;  missed = later than the next frame, or no turn at all
//! ```
//! The time of a turn counts from when its last payload was **due**, not from when a thread found time to hand it over:
//! a camera does not wait either.

mod load;
mod pace;
mod plot;
mod report;
mod steal;
mod tally;

pub use load::{Load, Pressed, press};
pub use pace::Film;
pub use plot::latencies_png;
pub use report::{checks, markdown};
pub use steal::Steal;
pub use tally::{Miss, Tally};

use meniscus::blob::Model;
use meniscus::runtime::Estimator;
use meniscus::surface::Config;
use meniscus_platform::realtime::{Granted, Priority};
use meniscus_service::live::{Log, Worker};
use meniscus_usb::link::link;
use meniscus_virtual::camera::PAYLOAD_ROOM;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Payload buffers between camera and worker, as in the main job.
const BUFFERS: usize = 8;

/// Time in which the window fills and the load gets going, s: left out.
const SETTLE_S: f64 = 2.0;

/// One run of the study.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Frames a second.
    pub rate_hz: f64,
    /// Length, s.
    pub seconds: f64,
    /// Loads that run meanwhile.
    pub loads: Vec<Load>,
    /// Scheduling of worker and camera.
    pub priority: Priority,
}

impl Run {
    /// The time that a turn may take, microseconds: until the next frame.
    #[must_use]
    pub fn deadline_us(&self) -> u64 {
        (1e6 / self.rate_hz).round() as u64
    }

    /// Frames of it.
    #[must_use]
    pub fn frames(&self) -> usize {
        ((self.seconds + SETTLE_S) * self.rate_hz).round() as usize
    }

    /// Returns the name of the run in tables: `60 Hz, cpu + memory + disk`.
    #[must_use]
    pub fn name(&self) -> String {
        let loads: Vec<&str> = self.loads.iter().map(|load| load.name()).collect();
        let loads = if loads.is_empty() { String::from("idle") } else { loads.join(" + ") };
        let rights = if self.priority == Priority::RealTime { "" } else { ", no real-time rights" };
        format!("{} Hz, {loads}{rights}", self.rate_hz)
    }
}

/// Result of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The run.
    pub run: Run,
    /// Every turn.
    pub tally: Tally,
    /// Work of the loads.
    pub pressed: Pressed,
    /// Share of the processors' time that the host of a virtual machine took; `None` where that is unknown.
    pub stolen: Option<f64>,
    /// Real-time rights that were requested and refused, in words.
    pub refused: Vec<String>,
}

/// Everything that the runs of a study share.
#[derive(Debug)]
pub struct Bench<'b> {
    /// The model.
    pub model: &'b Model<'b>,
    /// Reader of the images.
    pub config: Config,
    /// Images, rendered before.
    pub film: &'b Film,
    /// Folder that the load on the disk writes to.
    pub folder: &'b Path,
}

/// Does one run; `progress` is called ten times a second with the share that is done. Ends early when `stop` is set:
/// the turns until then are counted.
pub fn run(run: &Run, bench: &Bench<'_>, stop: &AtomicBool, mut progress: impl FnMut(f64)) -> Outcome {
    let Bench { model, config, film, folder } = *bench;
    let frames = run.frames();
    let estimator = Estimator::new(model).within(run.deadline_us());
    let (camera_end, worker_end) = link(BUFFERS, PAYLOAD_ROOM);
    let halt = AtomicBool::new(false);
    // A turn a frame, and room for those that silence adds.
    let log = Log::with_room(frames + frames / 4 + 64);
    let (ended, mut pressed, mut steal) = (AtomicBool::new(false), Pressed::default(), Steal::default());
    let (mut refused, mut shots, mut turns) = (Vec::new(), Vec::new(), Log::default());
    std::thread::scope(|scope| {
        let (halt, ended) = (&halt, &ended);
        let loads = scope.spawn(move || press(&run.loads, folder, ended));
        let samples = scope.spawn(move || Steal::watch(ended));
        let worker = scope.spawn(move || {
            let refused =
                if run.priority == Priority::RealTime { Granted::ask().refusals() } else { Vec::new() };
            let mut log = log;
            Worker::new(estimator, config).run(&worker_end, halt, &mut [&mut log]);
            (log, refused)
        });
        let camera = scope.spawn(move || film.play(run.rate_hz, frames, run.priority, &camera_end, halt));
        let mut done = 0.0;
        while !camera.is_finished() {
            std::thread::sleep(Duration::from_millis(100));
            done += 0.1 / (run.seconds + SETTLE_S);
            progress(f64::min(done, 1.0));
            if stop.load(Ordering::Relaxed) {
                halt.store(true, Ordering::Relaxed);
            }
        }
        // A thread that panicked has said so; its share of the outcome is empty.
        shots = camera.join().unwrap_or_default();
        (turns, refused) = worker.join().unwrap_or_default();
        ended.store(true, Ordering::Relaxed);
        pressed = loads.join().unwrap_or_default();
        steal = samples.join().unwrap_or_default();
    });
    let settled = (SETTLE_S * run.rate_hz) as usize;
    let tally = Tally::new(&shots, &turns, settled, run.deadline_us(), &steal);
    Outcome { run: run.clone(), tally, pressed, stolen: steal.share(), refused }
}
