//! The worker's loop: receive, turn, log, show; it blocks on nothing but the camera.

use super::log::{Log, Logged};
use crate::commanded_motion::Told;
use crate::identify as recognise;
use crate::identify::Standing;
use crate::live::flight_recorder::{Flight, Ring};
use crate::publish;
use crate::snapshot as look;
use meniscus::runtime::{Estimator, Eye, Tracker, Turn};
use meniscus::surface;
use meniscus::surface::Rectifier;
use meniscus_platform::allocations::allocations_of_this_thread;
use meniscus_platform::clock::Monotonic;
use meniscus_usb::link::{Delivery, Received, WorkerEnd};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Silence after which the next interval's turn is taken without a frame: one and a half intervals.
const PATIENCE: Duration = Duration::from_micros(25_000);

/// Before the first frame, and for a worker that is patient.
const LONG: Duration = Duration::from_secs(3600);

/// One frame interval.
const INTERVAL: Duration = Duration::from_micros(16_667);

/// What the run shows while it goes: written by the worker when nobody is reading, never waited for.
#[derive(Debug, Default)]
pub struct Watch {
    /// Set by anyone who wants the run to end.
    pub stop: AtomicBool,
    /// The last turn.
    pub last: Mutex<Option<Logged>>,
    /// Which liquid it is, as the thread that recognises has it; nothing without one.
    pub recognised: Mutex<Option<Standing>>,
    /// Silence is waited out instead of bridged by a turn without a frame: for a camera that waits, too.
    pub patient: bool,
    /// Who tells how the glass moves, if not its edges.
    pub told: Option<Told>,
    /// What makes the outline's image, where the camera sends it in colour.
    pub rectifier: Option<Rectifier>,
}

/// The infrared image of the liveliest moment of a run.
#[derive(Clone, Debug, Default)]
pub struct Still {
    /// Y8 pixels, row-major.
    pub infrared: Vec<u8>,
    /// Its turn.
    pub turn: Option<Turn>,
    /// Largest distance of the estimated surface from rest, metres.
    pub crest_m: f32,
}

/// Where turns are handed on to, as they end.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outlets<'o> {
    /// To other programs.
    pub publish: Option<&'o publish::Outlet>,
    /// To the live page.
    pub page: Option<&'o look::Outlet>,
    /// To Foxglove.
    pub foxglove: Option<&'o look::Outlet>,
    /// To the thread that recognises the liquid.
    pub recognise: Option<&'o recognise::Outlet>,
    /// To the keeper of the last seconds before a missed deadline.
    pub flight: Option<&'o Flight>,
}

/// Runs until the camera has gone or `watch.stop` is set; `still` receives the image of the highest crest, and every
/// turn goes to the `outlets`.
pub fn watch(
    estimator: Estimator<'_>,
    config: surface::Config,
    end: &WorkerEnd,
    watch: &Watch,
    outlets: Outlets<'_>,
    mut log: Log,
    still: &mut Still,
) -> Log {
    let (width, height) = config.image_size();
    let (mut depth, mut grey) = (vec![0; 2 * width * height], vec![0; width * height]);
    let mut colour = vec![0; watch.rectifier.as_ref().map_or(0, Rectifier::colour_bytes)];
    let mut field = vec![0.0; estimator.field_len()];
    let eye = match watch.rectifier {
        Some(rectifier) => Eye::in_colour(config, &mut depth, rectifier, &mut colour, &mut grey),
        None => Eye::new(config, &mut depth, &mut grey),
    };
    let mut tracker = Tracker::new(estimator, eye);
    still.infrared.resize(width * height, 0);
    let mut ring = outlets.flight.map(Ring::new);
    let mut clock = Monotonic::start();
    let patience = if watch.patient { LONG } else { PATIENCE };
    let mut next_turn = Instant::now() + LONG;
    while !watch.stop.load(Ordering::Relaxed) {
        match end.receive(next_turn) {
            Received::Closed => break,
            Received::Silence => {
                let started = Instant::now();
                let before = allocations_of_this_thread();
                let drive = |at| Told::drive(watch.told.as_ref(), at, started);
                let turn = tracker.silence(drive, &mut clock, &mut field);
                let (allocations, turn_us) = (allocations_of_this_thread() - before, micros_since(started));
                next_turn += INTERVAL;
                if let Some(turn) = turn {
                    let logged =
                        Logged { turn, ended: Instant::now(), latency_us: turn_us, turn_us, allocations };
                    log.push(logged);
                    ring.iter_mut().for_each(|ring| ring.push(logged, logged.latency_us));
                    if let Some(outlet) = outlets.publish {
                        outlet.offer(&logged.turn, &field);
                    }
                    show(watch, outlets, &tracker, logged);
                }
            }
            Received::Payload(delivery) => {
                if let Some(logged) =
                    take(&mut tracker, &delivery, watch, outlets.publish, &mut clock, &mut field, &mut log)
                {
                    next_turn = delivery.arrived + patience;
                    ring.iter_mut().for_each(|ring| ring.push(logged, logged.latency_us));
                    keep_still(&tracker, &logged, estimator.model().header.fill_m as f32, still);
                    show(watch, outlets, &tracker, logged);
                }
                end.give_back(delivery.payload);
            }
        }
    }
    ring.iter_mut().for_each(Ring::close);
    log.health = tracker.memory.health;
    log.losses = tracker.eye.losses();
    log.solitary = tracker.eye.solitary();
    log.payloads_dropped = end.dropped();
    log.told = watch.told.as_ref().map(Told::turns);
    log
}

/// One payload; the last turn that it led to. A log that is full changes nothing of that.
fn take(
    tracker: &mut Tracker<'_, '_>,
    delivery: &Delivery,
    watch: &Watch,
    outlet: Option<&publish::Outlet>,
    clock: &mut Monotonic,
    field: &mut [f32],
    log: &mut Log,
) -> Option<Logged> {
    let started = Instant::now();
    let before = allocations_of_this_thread();
    let mut last = None;
    let arrived = delivery.arrived;
    let drive = |at| Told::drive(watch.told.as_ref(), at, arrived);
    tracker.accept(delivery.stream, &delivery.payload, drive, clock, field, |turn, field| {
        let allocations = allocations_of_this_thread() - before;
        let (latency_us, turn_us) = (micros_since(arrived), micros_since(started));
        let logged = Logged { turn: *turn, ended: Instant::now(), latency_us, turn_us, allocations };
        if let Some(outlet) = outlet {
            outlet.offer(turn, field);
        }
        log.push(logged);
        last = Some(logged);
    });
    last
}

/// Shows a turn to whoever looks, unless they are looking right now.
fn show(watch: &Watch, outlets: Outlets<'_>, tracker: &Tracker<'_, '_>, logged: Logged) {
    for outlet in [outlets.page, outlets.foxglove].into_iter().flatten() {
        outlet.offer(&logged, &tracker.memory, tracker.eye.outline());
    }
    if let Some(outlet) = outlets.recognise {
        outlet.offer(&logged.turn);
    }
    if let Ok(mut last) = watch.last.try_lock() {
        *last = Some(logged);
    }
}

/// Keeps the image if the surface has never stood higher or lower.
fn keep_still(tracker: &Tracker<'_, '_>, logged: &Logged, fill_m: f32, still: &mut Still) {
    let away = |z: &f32| (z - fill_m).abs();
    let crest_m = logged.turn.estimate.surface_m.iter().map(away).fold(0.0, f32::max);
    if crest_m > still.crest_m && matches!(logged.turn.sight, Some(Ok(_))) {
        still.infrared.copy_from_slice(tracker.eye.outline());
        still.turn = Some(logged.turn);
        still.crest_m = crest_m;
    }
}

fn micros_since(start: Instant) -> u64 {
    u64::try_from(start.elapsed().as_micros()).unwrap_or(u64::MAX)
}
