//! The camera that sits before the glass: on a bus, its newest images kept; or a recording, whose first ones are.

use super::Job;
use crate::doctor::Camera;
use anyhow::ensure;
use meniscus::surface::{Optics, OutlineAssembler, Rectifier};
use meniscus::usb::uvc::Stream;
use meniscus_bags as bag;
use meniscus_bags::Image;
use meniscus_service::camera_facts::camera_line;
use meniscus_service::setup::{Gather, Pair, Recent};
use meniscus_usb::camera::{LinkSink, NoteBook, OutlineImage, Session, Settings};
use meniscus_usb::link::{Received, WorkerEnd, link};
use meniscus_usb::transport::Transport;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Payload buffers between camera and eye.
const BUFFERS: usize = 8;
/// Pairs before those that count: the exposure settles.
const SETTLING: u64 = 30;
/// Longest wait for pairs, and pause between two looks.
const PATIENCE: Duration = Duration::from_secs(20);
const LOOK: Duration = Duration::from_millis(20);
/// Longer than anybody looks at a glass.
const HOURS: Duration = Duration::from_secs(24 * 3600);
/// Most pairs that are kept, as --pairs.
const KEPT: usize = 600;

/// View of the camera.
pub(super) struct Scene {
    /// Of the images.
    pub(super) optics: Optics,
    /// The image in which the outline is traced.
    pub(super) outline: OutlineImage,
    /// The camera in words.
    pub(super) name: String,
    recent: Mutex<Recent>,
}

impl Scene {
    /// The newest pairs.
    pub(super) fn newest(&self, count: usize) -> Vec<Pair> {
        self.recent.lock().unwrap_or_else(PoisonError::into_inner).newest(count)
    }

    /// Pairs so far.
    pub(super) fn total(&self) -> u64 {
        self.recent.lock().unwrap_or_else(PoisonError::into_inner).total()
    }

    fn rate_hz(&self) -> f64 {
        self.recent.lock().unwrap_or_else(PoisonError::into_inner).rate_hz()
    }

    fn push(&self, pair: Pair) {
        self.recent.lock().unwrap_or_else(PoisonError::into_inner).push(pair);
    }
}

/// Something that brings pairs.
pub(super) trait Sitting {
    /// Waits for that many new pairs (no longer than is worth it); the camera, if it is one.
    fn wait(&self, scene: &Scene, pairs: usize) -> Option<Camera>;
    /// Whether more pairs will come.
    fn lives(&self) -> bool;
}

/// A camera on a bus.
struct Live<'a> {
    camera: &'a dyn Fn(f64) -> Camera,
    ended: &'a AtomicBool,
}

impl Sitting for Live<'_> {
    fn wait(&self, scene: &Scene, pairs: usize) -> Option<Camera> {
        let bar = crate::bars::bar(pairs as u64).with_message("looking");
        let (begun, settled) = (Instant::now(), scene.total().max(SETTLING));
        let wanted = settled + pairs as u64;
        while scene.total() < wanted && begun.elapsed() < PATIENCE && self.lives() {
            bar.set_position(scene.total().saturating_sub(settled));
            std::thread::sleep(LOOK);
        }
        bar.finish_and_clear();
        Some((self.camera)(scene.rate_hz()))
    }

    fn lives(&self) -> bool {
        !self.ended.load(Ordering::Relaxed)
    }
}

/// A recording, read already.
struct Read;

impl Sitting for Read {
    fn wait(&self, _: &Scene, _: usize) -> Option<Camera> {
        None
    }

    fn lives(&self) -> bool {
        false
    }
}

/// Before a camera on `transport`.
pub(super) fn from_bus(transport: impl Transport + Send, job: &Job<'_>) -> anyhow::Result<()> {
    let wanted = Settings {
        serial: job.arguments.serial.clone(),
        outline: job.arguments.outline,
        patience: Duration::from_secs(10),
        ..Settings::default()
    };
    let mut session = Session::connect(transport, wanted)?;
    let connected = session.connected().clone();
    let scene = Scene {
        optics: connected.optics(),
        outline: job.arguments.outline,
        name: camera_line(&connected),
        recent: Mutex::new(Recent::with_room(job.pairs.min(KEPT))),
    };
    let transfers: usize = session.plan().streams.iter().map(|stream| 4 * stream.transfer_bytes()).sum();
    let camera = |rate_hz| Camera {
        connected: Some(connected.clone()),
        rate_hz,
        transfers_mb: transfers as f64 / f64::from(1 << 20),
        ..Camera::default()
    };
    let (camera_end, worker_end) = link(BUFFERS, session.buffer_bytes());
    let (stop, ended, notes) = (AtomicBool::new(false), AtomicBool::new(false), NoteBook::default());
    let (held, streamed) = std::thread::scope(|scope| {
        let (stop, ended, notes, scene) = (&stop, &ended, &notes, &scene);
        let streaming = scope.spawn(move || {
            let until = Instant::now() + HOURS;
            let streamed = session.stream(&mut LinkSink { end: camera_end, stop, until, notes });
            ended.store(true, Ordering::Relaxed);
            streamed
        });
        let rectifier = connected.rectifier();
        scope.spawn(move || gather(&worker_end, rectifier, scene));
        let held = job.hold(scene, &Live { camera: &camera, ended });
        stop.store(true, Ordering::Relaxed);
        (held, streaming.join())
    });
    // A camera that failed says more than a glass that was therefore not seen.
    streamed.map_err(|_| anyhow::anyhow!("the camera's thread stopped on an error of its own"))??;
    held
}

/// Payloads to pairs until the camera has gone.
fn gather(end: &WorkerEnd, rectifier: Option<Rectifier>, scene: &Scene) {
    let size = (scene.optics.intrinsics.width, scene.optics.intrinsics.height);
    let pixels = size.0 * size.1;
    // Two images of each: a stream may lag by a frame.
    let (mut depth, mut grey) = (vec![0; 4 * pixels], vec![0; 2 * pixels]);
    let mut colour = vec![0; rectifier.as_ref().map_or(0, Rectifier::colour_bytes)];
    let outline = match rectifier {
        Some(rectifier) => OutlineAssembler::colour_keeping_two(rectifier, &mut colour, &mut grey),
        None => OutlineAssembler::infrared_keeping_two(&mut grey),
    };
    let mut gather = Gather::new(size, &mut depth, outline);
    loop {
        match end.receive(Instant::now() + Duration::from_millis(100)) {
            Received::Closed => return,
            Received::Silence => {}
            Received::Payload(delivery) => {
                if let Some(pair) = gather.take(delivery.stream, &delivery.payload) {
                    scene.push(pair);
                }
                end.give_back(delivery.payload);
            }
        }
    }
}

/// Before the first pairs of a recording.
pub(super) fn from_recording(path: &Path, job: &Job<'_>) -> anyhow::Result<()> {
    let recording = bag::open(path)?;
    let calibration = recording.calibration.clone();
    let scene = Scene {
        optics: calibration.optics(),
        outline: calibration.outline,
        name: format!("{}, in {}", calibration.camera, path.display()),
        recent: Mutex::new(Recent::with_room(job.pairs)),
    };
    let mut waiting: Option<Image> = None;
    for image in recording.images {
        let image = image?;
        let depth = waiting.take().filter(|depth| {
            let apart = depth.stamp.captured.0.abs_diff(image.stamp.captured.0);
            image.stream == Stream::Outline && apart < 8_000
        });
        match depth {
            Some(depth) => {
                scene.push(Pair { depth: depth.pixels, outline: image.pixels, stamp: depth.stamp });
            }
            None if image.stream == Stream::Depth => waiting = Some(image),
            None => {}
        }
        if scene.total() >= job.pairs as u64 {
            break;
        }
    }
    ensure!(scene.total() > 0, "{} holds no pair of a depth image and one with the outline", path.display());
    job.hold(&scene, &Read)
}
