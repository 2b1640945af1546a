//! The worker's loop: receive, turn, hand on. It blocks on nothing but the camera.

use super::silence::Silence;
use super::turns::Turns;
use crate::clock_map::{ClockMap, LeastLatency};
use crate::commanded_motion::CommandedMotion;
use crate::ledger::{FrameLedger, SpanEnd};
use crate::sink::{RunCounters, TurnSink};
use meniscus::runtime::{COAST_LIMIT, Estimator, ProfileSensor, Tracker};
use meniscus::surface::{Config, Rectifier};
use meniscus_platform::clock::Monotonic;
use meniscus_usb::link::{Received, WorkerEnd};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Silence after which the next interval's turn is taken without a frame: one and a half intervals.
const PATIENCE: Duration = Duration::from_micros(25_000);

/// Before the first frame, and for a worker that waits silence out.
const LONG: Duration = Duration::from_secs(3600);

/// One frame interval.
const INTERVAL: Duration = Duration::from_micros(16_667);

/// Most turns of one payload: one for each missing frame up to the limit of the tracker, then its own.
const MOST_TURNS: usize = COAST_LIMIT as usize + 2;

/// Images that a camera sends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CameraImages {
    /// Depth images and the outline's.
    #[default]
    DepthAndOutline,
    /// The outline's alone.
    OutlineAlone,
}

/// Everything that turns payloads into turns.
#[derive(Debug)]
pub struct Worker<'m> {
    /// The estimator with its model.
    pub estimator: Estimator<'m>,
    /// The reader of the images.
    pub config: Config,
    /// Images of the camera.
    pub images: CameraImages,
    /// Rectification of the outline's image, where the camera sends it in colour.
    pub rectifier: Option<Rectifier>,
    /// Commanded motion of the glass, taken instead of the tracked one.
    pub motion: Option<CommandedMotion>,
    /// Least latency from mid-exposure to arrival.
    pub latency: LeastLatency,
    /// Reaction to a camera that sends nothing.
    pub silence: Silence,
    /// End of what the camera takes, where the run ends with its link.
    pub span_end: SpanEnd,
}

impl<'m> Worker<'m> {
    /// Returns a worker for a camera that sends depth and infrared images, and a glass whose motion is tracked.
    #[must_use]
    pub fn new(estimator: Estimator<'m>, config: Config) -> Self {
        let (silence, span_end) = (Silence::default(), SpanEnd::LastFrame);
        let latency = LeastLatency::UNKNOWN_CAMERA;
        let images = CameraImages::default();
        Self { estimator, config, images, rectifier: None, motion: None, latency, silence, span_end }
    }

    /// Runs until the camera has gone or `stop` is set. Every turn goes to every sink, in the order of `sinks`.
    pub fn run(self, end: &WorkerEnd, stop: &AtomicBool, sinks: &mut [&mut dyn TurnSink]) {
        let (width, height) = self.config.image_size();
        // Two images of each: a stream may lag by a frame.
        let (mut depth, mut grey) = (vec![0; 4 * width * height], vec![0; 2 * width * height]);
        let mut colour = vec![0; self.rectifier.as_ref().map_or(0, Rectifier::colour_bytes)];
        let (config, one_grey) = (self.config, width * height);
        let sensor = match (self.images, self.rectifier) {
            (CameraImages::DepthAndOutline, Some(rectifier)) => {
                ProfileSensor::with_colour(config, &mut depth, rectifier, &mut colour, &mut grey)
            }
            (CameraImages::DepthAndOutline, None) => ProfileSensor::new(config, &mut depth, &mut grey),
            (CameraImages::OutlineAlone, Some(rectifier)) => {
                ProfileSensor::of_outline(config, rectifier, &mut colour, &mut grey[..one_grey])
            }
            (CameraImages::OutlineAlone, None) => {
                ProfileSensor::of_grey_outline(config, &mut grey[..one_grey])
            }
        };
        let field = vec![0.0; self.estimator.field_len()];
        let tracker = Tracker::new(self.estimator, sensor);
        let (clock, batch) = (Monotonic::start(), Vec::with_capacity(MOST_TURNS));
        let motion = self.motion.as_ref();
        let (clock_map, ledger) = (ClockMap::new().with_latency(self.latency), FrameLedger::default());
        let silence = self.silence;
        let mut turns = Turns {
            tracker,
            clock,
            clock_map,
            ledger,
            field,
            motion,
            silence,
            span_end: self.span_end,
            batch,
            dropped: 0,
            numberless: 0,
        };
        let patience = match silence {
            Silence::Bridge => PATIENCE,
            Silence::WaitOut => LONG,
        };
        let mut sink_allocations = 0;
        let (mut looked, mut span_end) = (Instant::now(), SpanEnd::RunsOn);
        let mut next_turn = looked + LONG;
        while !stop.load(Ordering::Relaxed) {
            let received = end.receive(next_turn);
            let now = Instant::now();
            turns.look(looked, now);
            looked = now;
            match received {
                Received::Closed => {
                    span_end = self.span_end;
                    break;
                }
                Received::Silence => {
                    turns.dropped = end.dropped();
                    turns.take_silence(now);
                    next_turn += INTERVAL;
                    sink_allocations += turns.hand_on(sinks);
                }
                Received::Payload(delivery) => {
                    if turns.take_payload(&delivery, now) {
                        next_turn = delivery.arrived + patience;
                        sink_allocations += turns.hand_on(sinks);
                    }
                    end.give_back(delivery.payload);
                }
            }
        }
        turns.dropped = end.dropped();
        let counters = RunCounters {
            health: turns.tracker.memory.health,
            losses: turns.tracker.sensor.losses(),
            solitary: turns.tracker.sensor.solitary(),
            payloads_dropped: end.dropped(),
            frames: turns.frames_at(Instant::now(), span_end),
            motion: turns.motion.map(CommandedMotion::turns),
            clock: turns.clock_map.findings(),
            sink_allocations,
        };
        sinks.iter_mut().for_each(|sink| sink.finish(&counters));
    }
}
