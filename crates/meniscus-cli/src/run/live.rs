//! A run behind its camera: the parts that the configuration asks for, opened, run and closed.

use super::config::{Front, RunConfig};
use super::foxglove::Foxglove;
use super::motion_source::OpenMotion;
use super::motion_tag::TagCamera;
use super::published::Published;
use super::ros2::Ros;
use super::shown::{self, Page};
use super::source::Source;
use super::{foxglove, ros2};
use crate::among::among;
use anyhow::Context;
use meniscus::blob::Model;
use meniscus::runtime::Estimator;
use meniscus::runtime::output::Packet;
use meniscus::surface::{Config, Rectifier};
use meniscus_data::recording::EstimateRecording;
use meniscus_data::validity::Validity;
use meniscus_platform::files::{check_writable, write_whole};
use meniscus_service::commanded_motion::MotionInlet;
use meniscus_service::controller::SharedPlan;
use meniscus_service::identify::GlassSize;
use meniscus_service::ledger::SpanEnd;
use meniscus_service::live::{CameraImages, Log, Worker};
use meniscus_service::run::{Finished, LiveRun, RunState, Viewer, attend_service, turn_table};
use meniscus_service::sink::TurnSink;
use meniscus_service::truth::Truth;
use meniscus_usb::link::WorkerEnd;
use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// A camera that is ready to send.
pub(super) struct ReadyCamera<'c> {
    /// Its name, for titles.
    pub(super) name: &'c str,
    /// Reader of its images.
    pub(super) reader: Config,
    /// Images that it sends.
    pub(super) images: CameraImages,
    /// Rectification of its outline image, where that is in colour.
    pub(super) rectifier: Option<Rectifier>,
    /// Frames whose turns the log keeps one by one; the totals have all.
    pub(super) frames: usize,
    /// End of what the camera takes, where the run ends with its link.
    pub(super) span_end: SpanEnd,
    /// The true surface, where it is simulated.
    pub(super) truth: Option<Truth>,
    /// The worker's end of the link to it.
    pub(super) end: WorkerEnd,
    /// One more sink of its turns, for the report.
    pub(super) sink: Option<&'c mut dyn TurnSink>,
}

/// A run that has ended.
pub(super) struct Played {
    /// Its log.
    pub(super) finished: Finished,
    /// Whether its tables could be written; to be looked at when the summary is out.
    pub(super) written: anyhow::Result<()>,
    /// Events of the camera.
    pub(super) notes: Vec<meniscus_usb::camera::Note>,
}

/// Viewers and publishers of a run.
struct Outputs {
    published: Option<Published>,
    page: Option<Page>,
    foxglove: Option<Foxglove>,
    ros: Option<Ros>,
}

/// Runs until `play`, which has the camera's thread, returns or somebody stops it.
pub(super) fn live(
    config: &RunConfig,
    model: &Model<'_>,
    mut camera: ReadyCamera<'_>,
    play: impl FnOnce(&RunState) + Send,
) -> anyhow::Result<Played> {
    // A run whose files cannot be written should not start.
    config.turn_table.iter().chain(&config.estimates).try_for_each(|path| check_writable(path))?;
    let title = format!("{}, {}, model {}", model.header.liquid, camera.name, config.model_name);
    let length = config.length();
    let motion = config.motion.as_ref().map(|motion| motion.open(&config.source, length)).transpose()?;
    let (motion, inlet, tag) =
        motion.map_or((None, None, None), |OpenMotion { motion, inlet, tag }| (Some(motion), inlet, tag));
    let mut outputs = Outputs::open(config, model, &camera, &title, inlet)?;
    let (radius_m, fill_m) = (model.header.radius_m, model.header.fill_m);
    let notes = among(&config.among, GlassSize { radius_m, fill_m })?;
    let state = Arc::new(RunState::default());
    let interrupted = Arc::clone(&state);
    ctrlc::set_handler(move || interrupted.stop.store(true, Ordering::Relaxed))
        .context("cannot watch for Ctrl-C")?;
    if let Some((tag, inlet)) = tag {
        let ReadyCamera { reader, rectifier, .. } = &camera;
        let (settings, rectifier, priority) = (*reader.settings(), *rectifier, config.priority);
        camera.end = tag.watch(camera.end, TagCamera { settings, rectifier, priority, inlet })?;
    }
    let estimator = Estimator::new(model).only(config.fields);
    let worker = Worker {
        images: camera.images,
        rectifier: camera.rectifier,
        motion,
        latency: config.latency,
        silence: config.silence,
        span_end: camera.span_end,
        ..Worker::new(estimator, camera.reader)
    };
    if let Some(sentence) = &Validity::of(&model.header).sentence {
        say(sentence);
    }
    let Outputs { published, page, foxglove, ros } = &mut outputs;
    let (publisher, controller) = published.as_mut().map(Published::parts).unzip();
    let (ros_outlet, ros_node) = ros.as_mut().map(Ros::parts).unzip();
    let publisher = publisher.map(|publisher| publisher as &mut dyn TurnSink);
    let sink = camera.sink.map(|sink| sink as &mut dyn TurnSink);
    let viewers: Vec<&dyn Viewer> = page
        .iter()
        .map(|page| page as &dyn Viewer)
        .chain(foxglove.iter().map(|foxglove| foxglove as &dyn Viewer))
        .chain(controller.flatten().map(|controller| controller as &dyn Viewer))
        .chain(ros_node)
        .collect();
    let run = LiveRun {
        model,
        worker,
        end: camera.end,
        frames: camera.frames,
        publishers: publisher.into_iter().chain(ros_outlet).chain(sink).collect(),
        viewers: &viewers,
        notes: &notes,
        flights: &config.out,
        priority: config.priority,
        state: &state,
        say: &say,
        // The dashboard has the whole screen and shows the last one itself.
        tell: if config.front == Front::Dashboard {
            &|_| ()
        } else {
            &|note| say(&format!("camera: {note}"))
        },
    };
    let caption = Caption { title, length };
    let finished = run.run(play, |finished| attend(config.front, model, caption, &state, finished))?;
    finished.flights.lines().iter().for_each(|line| say(line));
    outputs.close(config)?;
    let written = write(config, &finished.log, model);
    Ok(Played { finished, written, notes: state.notes.after(0) })
}

/// Writes the tables of the run that the configuration asks for.
fn write(config: &RunConfig, log: &Log, model: &Model<'_>) -> anyhow::Result<()> {
    if log.overflow > 0 && (config.turn_table.is_some() || config.estimates.is_some()) {
        let (kept, all) = (log.turns.len(), log.totals.turns);
        let why = match config.source {
            // It begins again behind its last frame, and its truth with it.
            Source::Rendered { .. } => "a simulated recording is kept once, however often it is played",
            _ => "--seconds makes room for a longer run",
        };
        say(&format!("the tables have the first {kept} of {all} turns: {why}"));
    }
    if let Some(path) = &config.turn_table {
        write_whole(path, turn_table(&log.turns).as_bytes())?;
    }
    if let Some(path) = &config.estimates {
        estimates(log, model).save(path)?;
    }
    Ok(())
}

impl Outputs {
    /// Opens what the configuration asks for.
    fn open(
        config: &RunConfig,
        model: &Model<'_>,
        camera: &ReadyCamera<'_>,
        title: &str,
        inlet: Option<MotionInlet>,
    ) -> anyhow::Result<Self> {
        let (reader, plan) = (camera.reader, SharedPlan::default());
        let page = config.page.as_ref().map(|page| shown::open(page, model, reader, title)).transpose()?;
        let page = page.map(|page| page.with_truth(camera.truth.clone()));
        Ok(Self {
            published: Published::open(&config.publishing, model, &plan)?,
            page,
            foxglove: foxglove::open(&config.foxglove, reader)?,
            ros: ros2::open(config, model, reader, camera.name, &plan, inlet)?,
        })
    }

    /// Closes everything and says what became of the turns.
    fn close(self, config: &RunConfig) -> anyhow::Result<()> {
        if let Some(page) = self.page {
            shown::close(page);
        }
        if let Some(foxglove) = self.foxglove {
            foxglove::close(&config.foxglove, foxglove)?;
        }
        if let Some(published) = self.published {
            published.close();
        }
        if let Some(ros) = self.ros {
            ros.close();
        }
        Ok(())
    }
}

/// Returns the estimates of a run for a file.
fn estimates(log: &Log, model: &Model<'_>) -> EstimateRecording {
    let numbered = (0..).zip(&log.turns);
    let packets: Vec<Packet> = numbered
        .map(|(number, timed)| Packet { host: timed.host, ..Packet::of(&timed.turn, number, &model.header) })
        .collect();
    let command: Vec<String> = std::env::args().collect();
    EstimateRecording::of(&packets, &command.join(" "))
}

/// Messages of a run, on standard error.
fn say(line: &str) {
    eprintln!("{line}");
}

/// Title and length of a run.
struct Caption {
    title: String,
    length: Duration,
}

/// Attends the run in the calling thread until the worker has finished.
fn attend(front: Front, model: &Model<'_>, caption: Caption, state: &RunState, finished: &dyn Fn() -> bool) {
    let Caption { title, length } = caption;
    match front {
        Front::Service => attend_service(state, &say, finished),
        Front::Page => shown::attend(finished),
        Front::Progress => progress(length, finished),
        Front::Dashboard => {
            // A terminal that fails ends the show, not the run.
            if let Err(error) = shown::dashboard(model, title, length, state, finished) {
                eprintln!("the dashboard ended: {error}");
            }
        }
    }
}

/// Shows a bar with the time left, on standard error.
fn progress(length: Duration, finished: &dyn Fn() -> bool) {
    if std::io::stderr().is_terminal() && crate::bars::is_plain_terminal() {
        return progress_in_lines(length, finished);
    }
    let bar = crate::bars::bar(length.as_millis().try_into().unwrap_or(u64::MAX));
    if let Ok(style) = crate::bars::style("running {wide_bar} {left}") {
        bar.set_style(style);
    }
    while !finished() {
        bar.set_position(bar.elapsed().as_millis().try_into().unwrap_or(u64::MAX));
        std::thread::sleep(Duration::from_millis(50));
    }
    bar.finish_and_clear();
}

/// Writes a line every five seconds, for a terminal that moves no cursor.
fn progress_in_lines(length: Duration, finished: &dyn Fn() -> bool) {
    let (begun, mut next_s) = (Instant::now(), 0);
    while !finished() {
        let passed_s = begun.elapsed().as_secs();
        if passed_s >= next_s {
            say(&format!("running: {passed_s} of {} s", length.as_secs()));
            next_s = passed_s + 5;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}
