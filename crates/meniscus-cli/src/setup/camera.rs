//! The camera that sits before the glass: on a bus, its newest images kept; or a recording, whose first ones are.

use super::Job;
use crate::doctor::{Camera, camera_findings};
#[cfg(feature = "bags")]
use crate::outline::Outline;
#[cfg(feature = "bags")]
use anyhow::ensure;
use meniscus::surface::{Optics, OutlineAssembler, Rectifier};
#[cfg(feature = "bags")]
use meniscus::usb::uvc::Stream;
#[cfg(feature = "bags")]
use meniscus_bags as bag;
#[cfg(feature = "bags")]
use meniscus_bags::Image;
use meniscus_service::camera_facts::camera_line;
use meniscus_service::live::CameraImages;
use meniscus_service::setup::{Finding, Gather, Pair, Recent, StatedCamera};
use meniscus_usb::camera::{LinkSink, NoteBook, OutlineImage, Session, Settings};
use meniscus_usb::link::{Received, WorkerEnd, link};
use meniscus_usb::transport::Transport;
#[cfg(feature = "bags")]
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Payload buffers between camera and eye.
pub(super) const BUFFERS: usize = 8;
/// Pairs before those that count: the exposure settles.
const SETTLING: u64 = 30;
/// Longest wait for pairs, and pause between two looks.
const PATIENCE: Duration = Duration::from_secs(20);
const LOOK: Duration = Duration::from_millis(20);
/// Longer than anybody looks at a glass.
pub(super) const HOURS: Duration = Duration::from_secs(24 * 3600);
/// Most pairs that are kept, as --pairs.
pub(super) const KEPT: usize = 600;

/// View of the camera.
pub(super) struct Scene {
    /// Of the images.
    pub(super) optics: Optics,
    /// Lens and place of a webcam.
    pub(super) stated: Option<StatedCamera>,
    /// The image in which the outline is traced.
    pub(super) outline: OutlineImage,
    /// The camera in words.
    pub(super) name: String,
    pub(super) recent: Mutex<Recent>,
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

    pub(super) fn rate_hz(&self) -> f64 {
        self.recent.lock().unwrap_or_else(PoisonError::into_inner).rate_hz()
    }

    fn push(&self, pair: Pair) {
        self.recent.lock().unwrap_or_else(PoisonError::into_inner).push(pair);
    }
}

/// Something that brings pairs.
pub(super) trait Sitting {
    /// Waits for that many new pairs (no longer than is worth it); returns the findings of the camera, if it is one.
    fn wait(&self, scene: &Scene, pairs: usize) -> Vec<Finding>;
    /// Whether more pairs will come.
    fn lives(&self) -> bool;
}

/// A camera that streams.
pub(super) struct Live<'a> {
    /// Findings of the camera at a rate in hertz.
    pub(super) findings: &'a dyn Fn(f64) -> Vec<Finding>,
    /// Whether it has ended.
    pub(super) ended: &'a AtomicBool,
}

impl Sitting for Live<'_> {
    fn wait(&self, scene: &Scene, pairs: usize) -> Vec<Finding> {
        let bar = crate::bars::bar(pairs as u64).with_message("looking");
        let (begun, settled) = (Instant::now(), scene.total().max(SETTLING));
        let wanted = settled + pairs as u64;
        while scene.total() < wanted && begun.elapsed() < PATIENCE && self.lives() {
            bar.set_position(scene.total().saturating_sub(settled));
            std::thread::sleep(LOOK);
        }
        bar.finish_and_clear();
        (self.findings)(scene.rate_hz())
    }

    fn lives(&self) -> bool {
        !self.ended.load(Ordering::Relaxed)
    }
}

/// A recording, read already.
#[cfg(feature = "bags")]
struct Read;

#[cfg(feature = "bags")]
impl Sitting for Read {
    fn wait(&self, _: &Scene, _: usize) -> Vec<Finding> {
        Vec::new()
    }

    fn lives(&self) -> bool {
        false
    }
}

/// Before a camera on `transport`.
pub(super) fn from_bus(transport: impl Transport + Send, job: &Job<'_>) -> anyhow::Result<()> {
    let wanted = Settings {
        serial: job.arguments.serial.clone(),
        outline: job.arguments.outline.image(),
        patience: Duration::from_secs(10),
        ..Settings::default()
    };
    let mut session = Session::connect(transport, wanted)?;
    let connected = session.connected().clone();
    let scene = Scene {
        optics: connected.optics(),
        stated: None,
        outline: job.arguments.outline.image(),
        name: camera_line(&connected),
        recent: Mutex::new(Recent::with_room(job.pairs.min(KEPT))),
    };
    let transfers: usize = session.plan().streams.iter().map(|stream| 4 * stream.transfer_bytes()).sum();
    let findings = |rate_hz| {
        let camera = Camera {
            connected: Some(connected.clone()),
            rate_hz,
            transfers_mb: transfers as f64 / f64::from(1 << 20),
            ..Camera::default()
        };
        camera_findings(&camera).into_iter().map(|(check, remedy)| Finding { check, remedy }).collect()
    };
    let streaming = Streaming {
        images: CameraImages::DepthAndOutline,
        rectifier: connected.rectifier(),
        buffer_bytes: session.buffer_bytes(),
        findings: &findings,
    };
    hold_before(job, &scene, streaming, move |sink| session.stream(sink))
}

/// A camera that is ready to stream.
pub(super) struct Streaming<'f> {
    /// Images that it sends.
    pub(super) images: CameraImages,
    /// Rectification of its outline image, where that is in colour.
    pub(super) rectifier: Option<Rectifier>,
    /// Bytes of its payloads.
    pub(super) buffer_bytes: usize,
    /// Findings of the camera at a rate in hertz.
    pub(super) findings: &'f dyn Fn(f64) -> Vec<Finding>,
}

/// Holds the dialogue while `stream` brings images.
pub(super) fn hold_before<E: Into<anyhow::Error> + Send>(
    job: &Job<'_>,
    scene: &Scene,
    camera: Streaming<'_>,
    stream: impl FnOnce(&mut LinkSink<'_>) -> Result<(), E> + Send,
) -> anyhow::Result<()> {
    let Streaming { images, rectifier, buffer_bytes, findings } = camera;
    let (camera_end, worker_end) = link(BUFFERS, buffer_bytes);
    let (stop, ended, notes) = (AtomicBool::new(false), AtomicBool::new(false), NoteBook::default());
    let (held, streamed) = std::thread::scope(|scope| {
        let (stop, ended, notes) = (&stop, &ended, &notes);
        let streaming = scope.spawn(move || {
            let until = Instant::now() + HOURS;
            let streamed = stream(&mut LinkSink { end: camera_end, stop, until, notes });
            ended.store(true, Ordering::Relaxed);
            streamed
        });
        scope.spawn(move || gather(&worker_end, images, rectifier, scene));
        let held = job.hold(scene, &Live { findings, ended });
        stop.store(true, Ordering::Relaxed);
        (held, streaming.join())
    });
    // A camera that failed says more than a glass that was therefore not seen.
    let streamed =
        streamed.map_err(|_| anyhow::anyhow!("the camera's thread stopped on an error of its own"))?;
    streamed.map_err(Into::into)?;
    held
}

/// Payloads to pairs until the camera has gone.
fn gather(end: &WorkerEnd, images: CameraImages, rectifier: Option<Rectifier>, scene: &Scene) {
    let size = (scene.optics.intrinsics.width, scene.optics.intrinsics.height);
    let pixels = size.0 * size.1;
    // Two images of each: a stream may lag by a frame.
    let (mut depth, mut grey) = (vec![0; 4 * pixels], vec![0; 2 * pixels]);
    let mut colour = vec![0; rectifier.as_ref().map_or(0, Rectifier::colour_bytes)];
    let outline = match rectifier {
        Some(rectifier) => OutlineAssembler::colour_keeping_two(rectifier, &mut colour, &mut grey),
        None => OutlineAssembler::infrared_keeping_two(&mut grey),
    };
    let mut gather = match images {
        CameraImages::DepthAndOutline => Gather::new(size, &mut depth, outline),
        CameraImages::OutlineAlone => Gather::of_outline(size, outline),
    };
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
#[cfg(feature = "bags")]
pub(super) fn from_recording(path: &Path, job: &Job<'_>) -> anyhow::Result<()> {
    let recording = bag::open(path)?;
    let calibration = recording.calibration.clone();
    ensure!(
        job.arguments.outline != Outline::Clear || calibration.outline == OutlineImage::Infrared,
        "{} has its outline in the colour image, and a clear liquid is seen in the infrared one: record with --outline clear",
        path.display()
    );
    let scene = Scene {
        optics: calibration.optics(),
        stated: None,
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
                scene.push(Pair { depth: Some(depth.pixels), outline: image.pixels, stamp: depth.stamp });
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
