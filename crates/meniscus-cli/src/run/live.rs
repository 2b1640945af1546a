//! Camera, worker and whoever looks on, at work together.

use super::foxglove::Foxglove;
use super::motion_source;
use super::published::Published;
use super::{Arguments, flight, page, service, turns};
use crate::among::among;
use anyhow::{Context, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use meniscus::blob::Model;
use meniscus::latent::decoder::Selection;
use meniscus::runtime::Estimator;
use meniscus::surface::{Config, Rectifier};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::recording::GROUP_NAMES;
use meniscus_platform::files::write_whole;
use meniscus_platform::realtime::Granted;
use meniscus_service::identify::{Standing, channel};
use meniscus_service::live::{Flight, Log, Outlets, Still, Watch, watch};
use meniscus_ui::page::Page;
use meniscus_ui::terminal::{Caption, Dashboard};
use meniscus_usb::link::WorkerEnd;
use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Camera, worker and dashboard at work, until the camera ends or somebody stops it. Of the camera its name, and what
/// makes the outline's image of what it sends in colour.
#[allow(clippy::too_many_arguments, reason = "each is one party of the run")]
pub(super) fn live(
    arguments: &Arguments,
    model: &Model<'_>,
    config: Config,
    frames: usize,
    (camera, rectifier): (&str, Option<Rectifier>),
    play: impl FnOnce(&AtomicBool) + Send,
    worker_end: WorkerEnd,
    still: &mut Still,
) -> anyhow::Result<Log> {
    let estimator = Estimator::new(model).only(groups(arguments)?);
    let published = Published::open(arguments, model)?;
    let title = format!("{}, {camera}, model {}", model.header.liquid, arguments.model);
    let page = arguments.page.open(model, config, &title)?;
    let foxglove = arguments.foxglove.open(config)?;
    let glass = (model.header.radius_m, model.header.fill_m);
    let notes = among(&arguments.among, glass)?;
    let (outlet, feed) = channel();
    let told = motion_source::told(arguments, Duration::from_secs_f64(frames as f64 * FRAME_INTERVAL_S))?;
    let shared = Arc::new(Watch { patient: arguments.patient, rectifier, told, ..Watch::default() });
    let interrupted = Arc::clone(&shared);
    ctrlc::set_handler(move || interrupted.stop.store(true, Ordering::Relaxed))
        .context("cannot watch for Ctrl-C")?;
    // Room for a turn a frame, for those that faults add, and for a second more.
    let log = Log::with_room(frames + frames / 2 + 64);
    let length = Duration::from_secs_f64(frames as f64 * FRAME_INTERVAL_S);
    let watching = &*shared;
    let recorder = Flight::default();
    let outlets = Outlets {
        publish: published.as_ref().map(Published::outlet),
        page: page.as_ref().map(Page::outlet),
        foxglove: foxglove.as_ref().map(Foxglove::outlet),
        recognise: (!notes.is_empty()).then_some(&outlet),
        flight: Some(&recorder),
    };
    let (recorder, ended) = (&recorder, &AtomicBool::new(false));
    let realtime = arguments.realtime || arguments.service;
    let (notes, outlet) = (&notes, &outlet);
    let log = std::thread::scope(|scope| {
        scope.spawn(move || play(&watching.stop));
        if let Some(page) = &page {
            scope.spawn(move || page.compose(model));
        }
        if let Some(foxglove) = &foxglove {
            scope.spawn(move || foxglove.compose(model));
        }
        recorder.open();
        let keeper = scope.spawn(move || flight::keep(recorder, &arguments.out, ended));
        let recogniser = scope.spawn(move || feed.attend(notes, glass.1, outlet, watching, ended));
        let worker = scope.spawn(move || {
            if realtime {
                // Plainly told; the run goes on as well as it may.
                Granted::ask().refusals().iter().for_each(|line| eprintln!("real time: {line}"));
            }
            watch(estimator, config, &worker_end, watching, outlets, log, still)
        });
        let finished = || worker.is_finished();
        let shown = if arguments.service {
            service::attend(watching, finished);
            Ok(())
        } else if page.is_some() {
            page::attend(finished);
            Ok(())
        } else if !arguments.json && std::io::stdout().is_terminal() {
            let (fill_m, radius_m) = (model.header.fill_m, model.header.radius_m);
            Dashboard::new(Caption { title, fill_m, radius_m, length }).run(watching, finished)
        } else {
            progress(length, finished);
            Ok(())
        };
        // A terminal that fails ends the show, not the run.
        if let Err(error) = shown {
            eprintln!("the dashboard ended: {error}");
        }
        let log = worker.join().map_err(|_| anyhow::anyhow!("the worker stopped on an error of its own"));
        ended.store(true, Ordering::Relaxed);
        if let Some(page) = &page {
            page.close();
        }
        if let Some(foxglove) = &foxglove {
            foxglove.end();
        }
        // A keeper that panicked has said so; the run's own report is not lost for it.
        if let Ok(records) = keeper.join() {
            records.tell(recorder.lost());
        }
        // The same for a recogniser.
        let standing: Option<Standing> = recogniser.join().ok();
        log.map(|mut log| {
            log.recognised = standing.filter(|_| !notes.is_empty());
            log
        })
    })?;
    if let Some(page) = page {
        page::close(page);
    }
    if let Some(foxglove) = foxglove {
        arguments.foxglove.close(foxglove)?;
    }
    if let Some(published) = published {
        published.close();
    }
    if let Some(path) = &arguments.turns {
        write_whole(path, turns::csv(&log.turns).as_bytes())?;
    }
    Ok(log)
}

/// The groups of --fields.
fn groups(arguments: &Arguments) -> anyhow::Result<Selection> {
    let groups = match arguments.fields.as_str() {
        "all" => return Ok(Selection::ALL),
        "none" => Selection::NONE,
        list => list.split(',').try_fold(Selection::NONE, |groups, name| {
            let index = GROUP_NAMES.iter().position(|known| *known == name.trim());
            let index = index.with_context(|| {
                format!(
                    "--fields knows no group '{name}': take of {}, or all, or none",
                    GROUP_NAMES.join(", ")
                )
            })?;
            anyhow::Ok(groups.with(index))
        })?,
    };
    ensure!(
        arguments.field_hz == 0.0 || groups == Selection::ALL,
        "--field-hz hands on the full field, which --fields {} leaves out in part",
        arguments.fields
    );
    Ok(groups)
}

/// A bar with the time left, on standard error, where there is no dashboard.
fn progress(length: Duration, finished: impl Fn() -> bool) {
    let bar = ProgressBar::new(length.as_millis().try_into().unwrap_or(u64::MAX));
    if let Ok(style) = ProgressStyle::with_template("running {wide_bar} {eta} left") {
        bar.set_style(style);
    }
    while !finished() {
        bar.set_position(bar.elapsed().as_millis().try_into().unwrap_or(u64::MAX));
        std::thread::sleep(Duration::from_millis(50));
    }
    bar.finish_and_clear();
}
