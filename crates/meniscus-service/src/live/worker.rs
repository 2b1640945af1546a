//! The worker's loop: receive, turn, hand on. It blocks on nothing but the camera.

use crate::clock_map::ClockMap;
use crate::commanded_motion::CommandedMotion;
use crate::ledger::{FrameCounts, FrameLedger, HandledFrame, SetAside, SpanEnd};
use crate::sink::{RunCounters, StateAfter, TurnRecord, TurnSink};
use crate::timed_turn::TimedTurn;
use meniscus::runtime::{COAST_LIMIT, Estimator, InputSource, ProfileSensor, Tracker};
use meniscus::surface::{Config, Rectifier};
use meniscus_platform::allocations::allocations_of_this_thread;
use meniscus_platform::clock::Monotonic;
use meniscus_usb::link::{Delivery, Received, WorkerEnd};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Silence after which the next interval's turn is taken without a frame: one and a half intervals.
const PATIENCE: Duration = Duration::from_micros(25_000);

/// Before the first frame, and for a worker that waits silence out.
const LONG: Duration = Duration::from_secs(3600);

/// One frame interval.
const INTERVAL: Duration = Duration::from_micros(16_667);

/// Time between two looks of the worker at its camera from which on the host stood still: while frames come or are bridged,
/// it looks every one and a half intervals.
const STANDSTILL: Duration = Duration::from_micros(50_000);

/// Most turns of one payload: one for each missing frame up to the limit of the tracker, then its own.
const MOST_TURNS: usize = COAST_LIMIT as usize + 2;

/// Reaction of the worker to a camera that sends nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Silence {
    /// A turn without a frame is taken for every interval: the estimate goes on at 60 Hz.
    #[default]
    Bridge,
    /// The next frame is waited for: for a simulated camera that waits for the worker, too.
    WaitOut,
}

/// Everything that turns payloads into turns.
#[derive(Debug)]
pub struct Worker<'m> {
    /// The estimator with its model.
    pub estimator: Estimator<'m>,
    /// The reader of the images.
    pub config: Config,
    /// Rectification of the outline's image, where the camera sends it in colour.
    pub rectifier: Option<Rectifier>,
    /// Commanded motion of the glass, taken instead of the tracked one.
    pub motion: Option<CommandedMotion>,
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
        Self { estimator, config, rectifier: None, motion: None, silence, span_end }
    }

    /// Runs until the camera has gone or `stop` is set. Every turn goes to every sink, in the order of `sinks`.
    pub fn run(self, end: &WorkerEnd, stop: &AtomicBool, sinks: &mut [&mut dyn TurnSink]) {
        let (width, height) = self.config.image_size();
        let (mut depth, mut grey) = (vec![0; 2 * width * height], vec![0; width * height]);
        let mut colour = vec![0; self.rectifier.as_ref().map_or(0, Rectifier::colour_bytes)];
        let sensor = match self.rectifier {
            Some(rectifier) => {
                ProfileSensor::with_colour(self.config, &mut depth, rectifier, &mut colour, &mut grey)
            }
            None => ProfileSensor::new(self.config, &mut depth, &mut grey),
        };
        let field = vec![0.0; self.estimator.field_len()];
        let tracker = Tracker::new(self.estimator, sensor);
        let (clock, batch) = (Monotonic::start(), Vec::with_capacity(MOST_TURNS));
        let motion = self.motion.as_ref();
        let (clock_map, ledger) = (ClockMap::new(), FrameLedger::default());
        let silence = self.silence;
        let mut turns = Turns {
            tracker,
            clock,
            clock_map,
            ledger,
            field,
            motion,
            silence,
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
            turns.dropped = end.dropped();
            match received {
                Received::Closed => {
                    span_end = self.span_end;
                    break;
                }
                Received::Silence => {
                    turns.take_silence(now);
                    next_turn += INTERVAL;
                    sink_allocations += turns.hand_on(sinks);
                }
                Received::Payload(delivery) => {
                    turns.take_payload(&delivery, now);
                    if !turns.batch.is_empty() {
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
            sink_allocations,
        };
        sinks.iter_mut().for_each(|sink| sink.finish(&counters));
    }
}

/// Tracker, ledger and the turns of the payload at hand.
struct Turns<'w, 'm, 'b> {
    tracker: Tracker<'m, 'b>,
    clock: Monotonic,
    clock_map: ClockMap,
    ledger: FrameLedger,
    field: Vec<f32>,
    motion: Option<&'w CommandedMotion>,
    silence: Silence,
    /// Turns that the sinks have not had yet. It never grows: the tracker bounds the turns of a payload.
    batch: Vec<TimedTurn>,
    /// Payloads that were dropped so far because no buffer was spare.
    dropped: u64,
    /// Depth frames so far that came without the camera's number.
    numberless: u32,
}

impl Turns<'_, '_, '_> {
    /// Notes a standstill of the host between two looks at the camera. A camera that waits for the worker misses nothing.
    fn look(&mut self, before: Instant, now: Instant) {
        if self.silence == Silence::Bridge && now - before > STANDSTILL {
            self.ledger.stood_still(self.clock_map.seconds(before), self.clock_map.seconds(now));
        }
    }

    /// Returns the accounts of the camera's frames at `now`.
    fn frames_at(&self, now: Instant, end: SpanEnd) -> FrameCounts {
        let set_aside =
            SetAside { stale: self.tracker.memory.health.frames_stale, payloads_dropped: self.dropped };
        // The time of a camera that waits for the worker says nothing about frames that it has not sent.
        let end = if self.silence == Silence::WaitOut { SpanEnd::LastFrame } else { end };
        self.ledger.counts_at(self.clock_map.seconds(now), set_aside, end)
    }

    /// Takes a turn without a frame; none before the first frame.
    fn take_silence(&mut self, started: Instant) {
        let before = allocations_of_this_thread();
        let motion = self.motion;
        let drive = |at| motion.map_or(InputSource::Tracked, |motion| motion.drive(at, started));
        let turn = self.tracker.silence(drive, &mut self.clock, &mut self.field);
        let (allocations, turn_us) = (allocations_of_this_thread() - before, micros_since(started));
        if let Some(turn) = turn {
            let ended = Instant::now();
            let host = self.clock_map.host_time(turn.time);
            let frames = self.frames_at(ended, SpanEnd::RunsOn);
            self.batch.push(TimedTurn {
                turn,
                host,
                ended,
                latency_us: turn_us,
                turn_us,
                allocations,
                frames,
            });
        }
    }

    /// Takes a payload and the turns that it leads to.
    fn take_payload(&mut self, delivery: &Delivery, started: Instant) {
        let before = allocations_of_this_thread();
        let Self { tracker, clock, clock_map, ledger, field, motion, batch, .. } = self;
        let arrived = delivery.arrived;
        let drive = |at| motion.map_or(InputSource::Tracked, |motion| motion.drive(at, arrived));
        tracker.accept(delivery.stream, &delivery.payload, drive, clock, field, |turn, _| {
            let allocations = allocations_of_this_thread() - before;
            let (latency_us, turn_us) = (micros_since(arrived), micros_since(started));
            if turn.stamp.is_some() {
                clock_map.observe(turn.time, arrived);
            }
            let (host, ended) = (clock_map.host_time(turn.time), Instant::now());
            let frames = ledger.counts();
            batch.push(TimedTurn { turn: *turn, host, ended, latency_us, turn_us, allocations, frames });
        });
        self.settle(arrived);
    }

    /// Books the frame of the payload at hand, if it completed one, and the frames that are missing before it.
    fn settle(&mut self, arrived: Instant) {
        let Some(logged) = self.batch.last_mut() else { return };
        let Some(stamp) = logged.turn.stamp else { return };
        let (map, arrived_s) = (&self.clock_map, self.clock_map.seconds(arrived));
        let numberless = self.tracker.sensor.losses().0.counter_missing;
        let number = (numberless == self.numberless).then_some(stamp.sequence);
        self.numberless = numberless;
        let in_real_time = self.silence == Silence::Bridge;
        // A camera that waits for the worker sends a frame when it is wanted: then it is due.
        let due_s = map.earliest_arrival_s(stamp.captured).filter(|_| in_real_time).unwrap_or(arrived_s);
        self.ledger.handle(&HandledFrame {
            number,
            captured: stamp.captured,
            due_s,
            arrived_s,
            ended_s: map.seconds(logged.ended),
            clock_restarts: if in_real_time { map.restarts() } else { 0 },
            set_aside: SetAside {
                stale: self.tracker.memory.health.frames_stale,
                payloads_dropped: self.dropped,
            },
        });
        logged.frames = self.ledger.counts();
    }

    /// Hands the turns to every sink; returns the allocations that this cost.
    fn hand_on(&mut self, sinks: &mut [&mut dyn TurnSink]) -> u64 {
        let before = allocations_of_this_thread();
        let newest = self.batch.len().saturating_sub(1);
        for (index, logged) in self.batch.iter().enumerate() {
            // Field and memory are those of the newest turn; earlier ones stand for missing frames and have none.
            let after = (index == newest)
                .then(|| StateAfter { memory: &self.tracker.memory, outline: self.tracker.sensor.outline() });
            let field: &[f32] = if after.is_some() { &self.field } else { &[] };
            let record = TurnRecord { logged, field, after };
            sinks.iter_mut().for_each(|sink| sink.accept(&record));
        }
        self.batch.clear();
        allocations_of_this_thread() - before
    }
}

fn micros_since(start: Instant) -> u64 {
    u64::try_from(start.elapsed().as_micros()).unwrap_or(u64::MAX)
}
