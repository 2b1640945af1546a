//! A run behind its camera: the parts that the configuration asks for, opened, run and closed.

use super::config::{Front, RunConfig};
use super::foxglove::Foxglove;
use super::published::Published;
use super::{foxglove, page};
use crate::among::among;
use anyhow::Context;
use meniscus::blob::Model;
use meniscus::runtime::Estimator;
use meniscus::runtime::output::Packet;
use meniscus::surface::{Config, Rectifier};
use meniscus_data::recording::EstimateRecording;
use meniscus_data::validity::Validity;
use meniscus_platform::files::{check_writable, write_whole};
use meniscus_service::identify::GlassSize;
use meniscus_service::ledger::SpanEnd;
use meniscus_service::live::{Log, Worker};
use meniscus_service::run::{Finished, LiveRun, RunState, Viewer, attend_service, turn_table};
use meniscus_ui::page::Page;
use meniscus_ui::terminal::{Caption, Dashboard};
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
    /// Rectification of its outline image, where that is in colour.
    pub(super) rectifier: Option<Rectifier>,
    /// Frames whose turns the log keeps one by one; the totals have all.
    pub(super) frames: usize,
    /// End of what the camera takes, where the run ends with its link.
    pub(super) span_end: SpanEnd,
    /// The worker's end of the link to it.
    pub(super) end: WorkerEnd,
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
}

/// Runs until `play`, which has the camera's thread, returns or somebody stops it.
pub(super) fn live(
    config: &RunConfig,
    model: &Model<'_>,
    camera: ReadyCamera<'_>,
    play: impl FnOnce(&RunState) + Send,
) -> anyhow::Result<Played> {
    // A run whose files cannot be written should not start.
    config.turn_table.iter().chain(&config.estimates).try_for_each(|path| check_writable(path))?;
    let title = format!("{}, {}, model {}", model.header.liquid, camera.name, config.model_name);
    let mut outputs = Outputs::open(config, model, camera.reader, &title)?;
    let (radius_m, fill_m) = (model.header.radius_m, model.header.fill_m);
    let notes = among(&config.among, GlassSize { radius_m, fill_m })?;
    let length = config.length();
    let motion = config.motion.as_ref().map(|motion| motion.open(&config.source, length)).transpose()?;
    let state = Arc::new(RunState::default());
    let interrupted = Arc::clone(&state);
    ctrlc::set_handler(move || interrupted.stop.store(true, Ordering::Relaxed))
        .context("cannot watch for Ctrl-C")?;
    let estimator = Estimator::new(model).only(config.fields);
    let worker = Worker {
        rectifier: camera.rectifier,
        motion,
        latency: config.latency,
        silence: config.silence,
        span_end: camera.span_end,
        ..Worker::new(estimator, camera.reader)
    };
    let validity = Validity::of(&model.header);
    if let Some(sentence) = &validity.sentence {
        say(sentence);
    }
    let caption = Caption { title, fill_m, radius_m, length, validity };
    let Outputs { published, page, foxglove } = &mut outputs;
    let (publisher, controller) = published.as_mut().map(Published::parts).unzip();
    let viewers: Vec<&dyn Viewer> = page
        .iter()
        .map(|page| page as &dyn Viewer)
        .chain(foxglove.iter().map(|foxglove| foxglove as &dyn Viewer))
        .chain(controller.flatten().map(|controller| controller as &dyn Viewer))
        .collect();
    let run = LiveRun {
        model,
        worker,
        end: camera.end,
        frames: camera.frames,
        publisher,
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
    let finished = run.run(play, |finished| attend(config.front, caption, &state, finished))?;
    finished.flights.lines().iter().for_each(|line| say(line));
    outputs.close(config)?;
    let written = write(config, &finished.log, model);
    Ok(Played { finished, written, notes: state.notes.after(0) })
}

/// Writes the tables of the run that the configuration asks for.
fn write(config: &RunConfig, log: &Log, model: &Model<'_>) -> anyhow::Result<()> {
    if log.overflow > 0 && (config.turn_table.is_some() || config.estimates.is_some()) {
        let (kept, all) = (log.turns.len(), log.totals.turns);
        say(&format!(
            "the tables have the first {kept} of {all} turns: --seconds makes room for a longer run"
        ));
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
    fn open(config: &RunConfig, model: &Model<'_>, reader: Config, title: &str) -> anyhow::Result<Self> {
        let page = config.page.as_ref().map(|page| page::open(page, model, reader, title)).transpose()?;
        Ok(Self {
            published: Published::open(&config.publishing, model)?,
            page,
            foxglove: foxglove::open(&config.foxglove, reader)?,
        })
    }

    /// Closes everything and says what became of the turns.
    fn close(self, config: &RunConfig) -> anyhow::Result<()> {
        if let Some(page) = self.page {
            page::close(page);
        }
        if let Some(foxglove) = self.foxglove {
            foxglove::close(&config.foxglove, foxglove)?;
        }
        if let Some(published) = self.published {
            published.close();
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

/// Attends the run in the calling thread until the worker has finished.
fn attend(front: Front, caption: Caption, state: &RunState, finished: &dyn Fn() -> bool) {
    let shown = match front {
        Front::Service => {
            attend_service(state, &say, finished);
            Ok(())
        }
        Front::Page => {
            page::attend(finished);
            Ok(())
        }
        Front::Dashboard => Dashboard::new(caption).run(state, finished),
        Front::Progress => {
            progress(caption.length, finished);
            Ok(())
        }
    };
    // A terminal that fails ends the show, not the run.
    if let Err(error) = shown {
        eprintln!("the dashboard ended: {error}");
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
