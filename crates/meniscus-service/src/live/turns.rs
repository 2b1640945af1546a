//! Turns of the worker: those of the payload at hand, with their cost and the accounts of the camera's frames.

use super::silence::Silence;
use crate::clock_map::ClockMap;
use crate::commanded_motion::CommandedMotion;
use crate::ledger::{FrameCounts, FrameLedger, HandledFrame, SetAside, SpanEnd};
use crate::sink::{StateAfter, TurnRecord, TurnSink};
use crate::timed_turn::TimedTurn;
use meniscus::runtime::{InputSource, Tracker};
use meniscus_platform::allocations::allocations_of_this_thread;
use meniscus_platform::clock::Monotonic;
use meniscus_usb::link::Delivery;
use std::time::{Duration, Instant};

/// Time between two looks of the worker at its camera from which on the host stood still: while frames come or are bridged,
/// it looks every one and a half intervals.
const STANDSTILL: Duration = Duration::from_micros(50_000);

/// Tracker, ledger and the turns of the payload at hand.
pub(super) struct Turns<'w, 'm, 'b> {
    pub(super) tracker: Tracker<'m, 'b>,
    pub(super) clock: Monotonic,
    pub(super) clock_map: ClockMap,
    pub(super) ledger: FrameLedger,
    pub(super) field: Vec<f32>,
    pub(super) motion: Option<&'w CommandedMotion>,
    pub(super) silence: Silence,
    /// End of what the camera takes.
    pub(super) span_end: SpanEnd,
    /// Turns that the sinks have not had yet. It never grows: the tracker bounds the turns of a payload.
    pub(super) batch: Vec<TimedTurn>,
    /// Payloads that were dropped so far because no buffer was spare.
    pub(super) dropped: u64,
    /// Frames so far that came without the camera's number: depth, or of the outline alone.
    pub(super) numberless: u32,
}

impl Turns<'_, '_, '_> {
    /// Notes a standstill of the host between two looks at the camera. A camera that waits for the worker misses nothing.
    pub(super) fn look(&mut self, before: Instant, now: Instant) {
        if self.silence == Silence::Bridge && now - before > STANDSTILL {
            self.ledger.stood_still(self.clock_map.seconds(before), self.clock_map.seconds(now));
        }
    }

    /// Returns the accounts of the camera's frames at `now`.
    pub(super) fn frames_at(&self, now: Instant, end: SpanEnd) -> FrameCounts {
        let set_aside =
            SetAside { stale: self.tracker.memory.health.frames_stale, payloads_dropped: self.dropped };
        // The time of a camera that waits for the worker says nothing about frames that it has not sent.
        let end = if self.silence == Silence::WaitOut { SpanEnd::LastFrame } else { end };
        self.ledger.counts_at(self.clock_map.seconds(now), set_aside, end)
    }

    /// Takes a turn without a frame; none before the first frame.
    pub(super) fn take_silence(&mut self, started: Instant) {
        let before = allocations_of_this_thread();
        let motion = self.motion;
        let drive = |at| motion.map_or(InputSource::Tracked, |motion| motion.drive(at, started));
        let turn = self.tracker.silence(drive, &mut self.clock, &mut self.field);
        let (allocations, turn_us) = (allocations_of_this_thread() - before, micros_since(started));
        if let Some(turn) = turn {
            if let Some(motion) = motion {
                motion.compare(turn.time, None);
            }
            let ended = Instant::now();
            let host = self.clock_map.host_time(turn.time);
            let frames = self.frames_at(ended, self.span_end);
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

    /// Takes a payload and the turns that it leads to. Returns whether it completed a frame that is used: the next one is due an
    /// interval later. A late frame has no turn of its own.
    // `cargo xtask under-attack` counts the instructions of a turn: callgrind finds it and `hand_on` by their names.
    #[inline(never)]
    pub(super) fn take_payload(&mut self, delivery: &Delivery, started: Instant) -> bool {
        let before = allocations_of_this_thread();
        let caught_up = self.tracker.memory.health.frames_caught_up;
        // Payloads that were dropped while this one waited belong to later frames.
        self.dropped = delivery.dropped_before;
        let Self { tracker, clock, clock_map, ledger, field, motion, batch, .. } = self;
        let (motion, arrived) = (*motion, delivery.arrived);
        let drive = |at| motion.map_or(InputSource::Tracked, |motion| motion.drive(at, arrived));
        let numbered = tracker.sensor.losses_of_numbered().counter_missing == 0;
        tracker.accept(delivery.stream, &delivery.payload, drive, clock, field, |turn, _| {
            let allocations = allocations_of_this_thread() - before;
            let (latency_us, turn_us) = (micros_since(arrived), micros_since(started));
            if let Some(motion) = motion {
                let profile = turn.profile.as_ref().and_then(|profile| profile.as_ref().ok());
                motion.compare(turn.time, profile.and_then(|profile| profile.glass_x_m));
            }
            if let Some(stamp) = turn.stamp {
                if numbered && ledger.is_next(stamp.sequence, stamp.captured) {
                    clock_map.observe_next(turn.time, arrived);
                } else {
                    clock_map.observe(turn.time, arrived);
                }
            }
            let (host, ended) = (clock_map.host_time(turn.time), Instant::now());
            let frames = ledger.counts();
            batch.push(TimedTurn { turn: *turn, host, ended, latency_us, turn_us, allocations, frames });
        });
        self.settle(arrived);
        !self.batch.is_empty() || self.tracker.memory.health.frames_caught_up > caught_up
    }

    /// Books the frame of the payload at hand, if it completed one, and the frames that are missing before it.
    fn settle(&mut self, arrived: Instant) {
        let Some(logged) = self.batch.last_mut() else { return };
        let Some(stamp) = logged.turn.stamp else { return };
        let (map, arrived_s) = (&self.clock_map, self.clock_map.seconds(arrived));
        let numberless = self.tracker.sensor.losses_of_numbered().counter_missing;
        let number = (numberless == self.numberless).then_some(stamp.sequence);
        self.numberless = numberless;
        let in_real_time = self.silence == Silence::Bridge;
        // A camera that waits for the worker sends a frame when it is wanted: then it is due.
        let due_s = map.earliest_arrival_s(stamp.captured).filter(|_| in_real_time).unwrap_or(arrived_s);
        self.ledger.handle(&HandledFrame {
            number,
            captured: stamp.captured,
            due_s,
            by_clock: in_real_time,
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
    #[inline(never)]
    pub(super) fn hand_on(&mut self, sinks: &mut [&mut dyn TurnSink]) -> u64 {
        let before = allocations_of_this_thread();
        let newest = self.batch.len().saturating_sub(1);
        for (index, logged) in self.batch.iter().enumerate() {
            // Field and memory are those of the newest turn; earlier ones stand for missing frames and have none.
            let sensor = &self.tracker.sensor;
            let (memory, outline, depth) = (&self.tracker.memory, sensor.outline(), sensor.depth());
            let after = (index == newest).then_some(StateAfter { memory, outline, depth });
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
