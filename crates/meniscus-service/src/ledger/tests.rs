//! Tests of the ledger: gaps, wrapped and restarted counters, repeated frames, restarted clocks, a host that stood still.

use super::*;
use crate::clock_map::ClockMap;
use std::time::{Duration, Instant};

/// Least latency of the camera, s.
const LEAST_S: f64 = 0.008;

/// A camera at 60 Hz before a clock map and a ledger.
struct Camera {
    begun: Instant,
    map: ClockMap,
    ledger: FrameLedger,
    set_aside: SetAside,
    /// Frames taken so far.
    frame: u64,
    /// Camera time at host time 0, s.
    ahead_s: f64,
    /// Frame counter of frame 0; `None` for a camera without one.
    counter: Option<u32>,
}

impl Camera {
    fn new() -> Self {
        let begun = Instant::now();
        Self {
            begun,
            map: ClockMap::starting_at(begun),
            ledger: FrameLedger::default(),
            set_aside: SetAside::default(),
            frame: 0,
            ahead_s: 1000.0,
            counter: Some(7),
        }
    }

    /// Takes `frames` frames of which the host learns nothing.
    fn skip(&mut self, frames: u64) {
        self.frame += frames;
    }

    /// Host time at which the newest frame is due, s.
    fn due_s(&self) -> f64 {
        self.frame as f64 * FRAME_INTERVAL_S + LEAST_S
    }

    /// Takes a frame that waits for `delay_s` and has a turn of 1 ms.
    fn shoot(&mut self, delay_s: f64) {
        self.frame += 1;
        self.show(delay_s);
    }

    /// Shows the newest frame.
    fn show(&mut self, delay_s: f64) {
        let captured = Micros((1e6 * (self.ahead_s + self.frame as f64 * FRAME_INTERVAL_S)) as u64);
        let arrived = self.begun + Duration::from_secs_f64(self.due_s() + delay_s);
        let number = self.counter.map(|counter| counter.wrapping_add(self.frame as u32));
        if number.is_some_and(|number| self.ledger.is_next(number, captured)) {
            self.map.observe_next(captured, arrived);
        } else {
            self.map.observe(captured, arrived);
        }
        let arrived_s = self.map.seconds(arrived);
        self.ledger.handle(&HandledFrame {
            number,
            captured,
            due_s: self.map.earliest_arrival_s(captured).expect("a frame came"),
            by_clock: true,
            arrived_s,
            ended_s: arrived_s + 0.001,
            clock_restarts: self.map.restarts(),
            set_aside: self.set_aside,
        });
    }

    fn shoot_many(&mut self, frames: u64) {
        (0..frames).for_each(|_| self.shoot(0.0));
    }

    /// In time, late, lost, never handled.
    fn accounts(&self) -> [u64; 4] {
        let counts = self.ledger.counts();
        assert_eq!(counts.taken(), self.frame, "every frame has one account: {counts}");
        let over_s = self.frame as f64 * FRAME_INTERVAL_S;
        assert!((counts.over_s - over_s).abs() < 0.02, "{counts} and not over {over_s} s");
        [counts.in_time, counts.late, counts.lost, counts.never_handled]
    }
}

#[test]
fn a_gap_is_lost_with_and_without_a_counter() {
    for counter in [Some(7), None] {
        let mut camera = Camera { counter, ..Camera::new() };
        camera.shoot_many(100);
        camera.skip(5);
        camera.shoot_many(100);
        assert_eq!(camera.accounts(), [200, 0, 5, 0]);
    }
}

#[test]
fn a_counter_that_wraps_or_begins_anew_makes_no_frames() {
    let mut camera = Camera { counter: Some(u32::MAX - 50), ..Camera::new() };
    camera.shoot_many(100);
    camera.skip(3);
    camera.counter = Some(0);
    camera.shoot_many(10);
    camera.counter = Some(u32::MAX - 1000);
    camera.shoot_many(10);
    // A counter that skips while time does not: no frame can have been taken in between.
    camera.counter = Some(5000);
    camera.shoot_many(10);
    assert_eq!(camera.accounts(), [130, 0, 3, 0]);
}

#[test]
fn a_slower_camera_lacks_nothing() {
    let mut ledger = FrameLedger::default();
    let mut map = ClockMap::new();
    for frame in 0..90_u32 {
        let captured = Micros(1_000_000 + u64::from(frame) * 33_333);
        let arrived = Instant::now() + Duration::from_micros(u64::from(frame) * 33_333);
        map.observe(captured, arrived);
        let due_s = map.earliest_arrival_s(captured).expect("a frame came");
        let set_aside = SetAside::default();
        let (arrived_s, ended_s) = (due_s, due_s + 0.001);
        let number = Some(frame);
        ledger.handle(&HandledFrame {
            number,
            captured,
            due_s,
            by_clock: true,
            arrived_s,
            ended_s,
            clock_restarts: 0,
            set_aside,
        });
    }
    let counts = ledger.counts();
    assert_eq!((counts.taken(), counts.in_time), (90, 90));
    assert!((counts.over_s - 3.0).abs() < 0.04, "{counts}");
}

#[test]
fn a_repeated_frame_is_counted_once() {
    let mut camera = Camera::new();
    camera.shoot_many(10);
    camera.show(0.001);
    camera.show(0.002);
    camera.shoot_many(10);
    assert_eq!(camera.accounts(), [20, 0, 0, 0]);
}

#[test]
fn a_frame_that_waited_is_late_though_its_turn_was_short() {
    let mut camera = Camera::new();
    camera.shoot_many(100);
    camera.shoot(0.030);
    camera.shoot(0.014);
    camera.shoot(0.015_8);
    camera.set_aside.stale += 2;
    camera.skip(2);
    camera.shoot(0.0);
    assert_eq!(camera.accounts(), [102, 4, 0, 0]);
}

#[test]
fn first_frames_that_waited_are_late_once_the_least_latency_is_known() {
    let mut camera = Camera::new();
    [0.054, 0.053, 0.042, 0.036].into_iter().for_each(|delay_s| camera.shoot(delay_s));
    assert_eq!(camera.accounts(), [2, 2, 0, 0], "as far as anybody knows");
    camera.shoot_many(100);
    assert_eq!(camera.accounts(), [100, 4, 0, 0]);
}

#[test]
fn frames_of_a_standstill_are_late_or_never_handled() {
    let mut camera = Camera::new();
    camera.shoot_many(100);
    let begin_s = camera.due_s();
    camera.ledger.stood_still(begin_s, begin_s + 3.0);
    for waiting in 1..=4 {
        camera.shoot(3.0 - f64::from(waiting) * FRAME_INTERVAL_S);
    }
    camera.skip(176);
    camera.shoot_many(100);
    camera.skip(6);
    camera.shoot(0.0);
    assert_eq!(camera.accounts(), [201, 4, 6, 176]);
}

#[test]
fn frames_that_queue_in_hundreds_are_late_and_no_restart_of_the_clock() {
    let mut camera = Camera::new();
    camera.shoot_many(100);
    // After a standstill of 3 s everything comes, a frame every 10 ms, but for some that found no buffer.
    for queued in 0..300 {
        camera.shoot(3.0 - f64::from(queued) * (FRAME_INTERVAL_S - 0.010));
        if queued % 10 == 0 {
            camera.set_aside.payloads_dropped += 2;
            camera.skip(1);
        }
    }
    assert_eq!(camera.map.restarts(), 0);
    assert_eq!(camera.accounts(), [100, 300, 0, 30]);
}

#[test]
fn a_camera_that_stays_behind_without_a_break_in_its_counter_has_not_restarted() {
    let mut camera = Camera::new();
    camera.shoot_many(100);
    camera.skip(2);
    (0..200).for_each(|_| camera.shoot(2.5));
    assert_eq!(camera.map.restarts(), 0);
    assert_eq!(camera.accounts(), [100, 200, 2, 0]);
}

#[test]
fn a_clock_that_restarts_takes_the_time_away_with_it() {
    for ahead_s in [5000.0, -1.0] {
        let mut camera = Camera::new();
        camera.shoot_many(100);
        // The camera is away for two seconds, and its clock goes on as if it had been one frame, or jumps far ahead.
        camera.skip(120);
        camera.ahead_s = if ahead_s > 0.0 { ahead_s } else { camera.ahead_s - 2.0 };
        camera.counter = Some(0);
        camera.shoot_many(200);
        assert_eq!(camera.map.restarts(), 1);
        let [in_time, late, lost, never_handled] = camera.accounts();
        assert_eq!((late, never_handled), (0, 0), "ahead by {ahead_s} s");
        assert_eq!((in_time, lost), (300, 120));
    }
}

#[test]
fn the_end_counts_what_was_due_and_no_frame_that_still_has_time() {
    let mut camera = Camera::new();
    camera.shoot_many(60);
    let (due_s, none) = (camera.due_s(), SetAside::default());
    let at = |after_s: f64, set_aside, end| camera.ledger.counts_at(due_s + after_s, set_aside, end);
    assert_eq!(at(0.02, none, SpanEnd::RunsOn).taken(), 60, "the next frame may still be in time");
    let silent = at(1.02, none, SpanEnd::RunsOn);
    assert_eq!((silent.lost, silent.taken()), (60, 120));
    assert!((silent.over_s - 2.0).abs() < 1e-6, "{silent}");
    assert_eq!(at(1.02, none, SpanEnd::LastFrame).taken(), 60, "a recording that has ended takes no more");
    let dropped = SetAside { stale: 1, payloads_dropped: 7 };
    let counts = at(1.02, dropped, SpanEnd::LastFrame);
    assert_eq!((counts.late, counts.never_handled, counts.lost), (1, 4, 0));
    assert_eq!(FrameLedger::default().counts_at(9.0, none, SpanEnd::RunsOn), FrameCounts::default());
}
