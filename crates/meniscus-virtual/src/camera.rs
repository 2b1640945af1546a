//! The simulated camera in process: a recording, rendered and packed into USB payloads at 60 Hz.
//!
//! It stands where the USB camera will stand, at the far end of the [`link`](meniscus_usb::link), and
//! everything behind the link is the real reader.

use crate::looped_recording::repeated;
use crate::render::{Images, Liquid, Scene, SceneSettings};
use meniscus::units::Micros;
use meniscus::usb::uvc::Stream;
use meniscus_data::recording::Recording;
use meniscus_hil::{Camera, CameraSettings, FaultInjector, FaultList, Payload, Shot, Source};
use meniscus_usb::link::CameraEnd;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Device time at which frame 0 is captured.
pub const START: Micros = Micros(1_000_000);

/// Bytes that hold any payload of a 640 x 480 Z16 image, header and a fault's excess included.
pub const PAYLOAD_ROOM: usize = 640 * 480 * 2 + 8192;

/// A camera in front of a recorded glass.
#[derive(Debug)]
pub struct SimulatedCamera<'r> {
    recording: &'r Recording,
    scene: Scene,
    images: Images,
    wire: FaultInjector<Camera>,
    pending: Vec<Payload>,
    repeats: bool,
    patient: bool,
}

impl<'r> SimulatedCamera<'r> {
    /// A camera that looks at `recording` under `scene`, with `faults` on its wire.
    #[must_use]
    pub fn new(recording: &'r Recording, scene: SceneSettings, faults: FaultList) -> Self {
        let wire = FaultInjector::new(Camera::new(CameraSettings::default()), faults, scene.seed);
        Self {
            recording,
            images: Images::new(&scene),
            scene: Scene::new(scene),
            wire,
            pending: Vec::new(),
            repeats: false,
            patient: false,
        }
    }

    /// The same camera, which waits for the worker and not for the clock: no frame is late or dropped for want of time,
    /// however busy the machine.
    #[must_use]
    pub fn patient(self) -> Self {
        Self { patient: true, ..self }
    }

    /// The same camera, for which the recording begins again where it ends ([`repeated`]).
    #[must_use]
    pub fn repeating(self) -> Self {
        Self { repeats: true, ..self }
    }

    /// Capture time of `frame`: 1/60 s apart, to the microsecond.
    fn captured_us(frame: usize) -> u64 {
        START.0 + (frame as u64 * 1_000_000 + 30) / 60
    }

    /// Plays `frames` frames of the recording (or all there are, unless it repeats) in real time; ends early when
    /// `stop` is set or the worker has gone.
    pub fn play(mut self, frames: usize, end: &CameraEnd, stop: &AtomicBool) {
        let begun = Instant::now();
        let last = if self.repeats { frames } else { frames.min(self.recording.frames()) };
        for frame in 0..last {
            self.expose(frame);
            let until_us = Self::captured_us(frame + 1);
            if stop.load(Ordering::Relaxed) || !self.deliver(until_us, begun, end) {
                return;
            }
        }
        self.deliver(u64::MAX, begun, end);
    }

    /// Sends every payload of every frame at once, in order of arrival, to `each`.
    pub fn send_all(self, each: impl FnMut(Stream, &[u8])) {
        let frames = self.recording.frames();
        self.send_first(frames, each);
    }

    /// The same of the first `frames` frames, or of all there are.
    pub fn send_first(mut self, frames: usize, mut each: impl FnMut(Stream, &[u8])) {
        for frame in 0..frames.min(self.recording.frames()) {
            self.expose(frame);
            let until_us = Self::captured_us(frame + 1);
            let due = self.pending.iter().take_while(|payload| payload.arrival_us < until_us).count();
            self.pending.drain(..due).for_each(|payload| each(stream_of(&payload), &payload.bytes));
        }
        self.pending.drain(..).for_each(|payload| each(stream_of(&payload), &payload.bytes));
    }

    /// Renders a frame and packs it; its payloads wait for their time.
    fn expose(&mut self, frame: usize) {
        let (recording, shot) = (self.recording, frame as u64);
        let liquid = if self.repeats { repeated(recording, shot) } else { Liquid::of(recording, frame) };
        self.scene.render(&liquid, shot, &mut self.images);
        let (depth, infrared) = (self.images.depth.as_slice(), self.images.infrared.as_slice());
        let shot = Shot::infrared(depth, infrared, Self::captured_us(frame));
        self.pending.extend(self.wire.expose(&shot));
        self.pending.sort_by_key(|payload| payload.arrival_us);
    }

    /// Sends every payload that arrives before `until_us`, each at its time; `false` when the worker
    /// has gone.
    fn deliver(&mut self, until_us: u64, begun: Instant, end: &CameraEnd) -> bool {
        let due = self.pending.iter().take_while(|payload| payload.arrival_us < until_us).count();
        for payload in self.pending.drain(..due) {
            let stream = stream_of(&payload);
            let sent = if self.patient {
                end.send_patiently(stream, &payload.bytes)
            } else {
                let at = begun + Duration::from_micros(payload.arrival_us.saturating_sub(START.0));
                std::thread::sleep(at.saturating_duration_since(Instant::now()));
                end.send(stream, &payload.bytes)
            };
            if !sent {
                return false;
            }
        }
        true
    }
}

/// The reader's name for the stream of `payload`.
fn stream_of(payload: &Payload) -> Stream {
    match payload.stream {
        meniscus_hil::Stream::Depth => Stream::Depth,
        meniscus_hil::Stream::Infrared | meniscus_hil::Stream::Colour => Stream::Outline,
    }
}
