//! Tests of the clock map: drift, restarts, queues, host time.

use super::steps::STEP_FRAMES;
use super::*;

/// Least latency of the simulated camera, s.
const LEAST_S: f64 = 0.008;

/// A camera at 60 Hz with a clock of its own, in front of a map.
struct Camera {
    map: ClockMap,
    /// Camera time at host time 0, s.
    ahead_s: f64,
    /// Share by which its clock runs too fast.
    drift: f64,
    frame: u64,
}

impl Camera {
    fn new(drift: f64) -> Self {
        Self { map: ClockMap::new(), ahead_s: 1000.0, drift, frame: 0 }
    }

    /// Takes one more frame that queues for `delay_s`. Returns its camera time and its host time in seconds.
    fn shoot(&mut self, delay_s: f64) -> (Micros, f64) {
        self.frame += 1;
        let exposed_s = self.frame as f64 * FRAME_INTERVAL_S;
        let camera = Micros((1e6 * (self.ahead_s + exposed_s * (1.0 + self.drift))) as u64);
        let arrival_s = exposed_s + LEAST_S + delay_s;
        self.map.observe(camera, self.map.begun + Duration::from_secs_f64(arrival_s));
        (camera, exposed_s)
    }

    /// Exponential delay of mean 2 ms for the next frame, from a sequence that fills the unit interval evenly.
    fn queue_s(&self) -> f64 {
        let share = (self.frame as f64 * 0.618_033_988_749_895).fract();
        -0.002 * (1.0 - share).ln()
    }

    /// Error of the map at the frame of `camera`, s; the least latency is no part of it.
    fn error_s(&self, camera: Micros, exposed_s: f64) -> f64 {
        self.map.earliest_arrival_s(camera).expect("a frame came") - LEAST_S - exposed_s
    }
}

#[test]
fn a_drifting_clock_is_followed_to_a_third_of_a_millisecond() {
    for drift in [-1e-4, -3e-5, 0.0, 3e-5, 1e-4] {
        let mut camera = Camera::new(drift);
        // Ten minutes: without following, 100 ppm would be 60 ms.
        for frame in 0..36_000 {
            let (time, exposed_s) = camera.shoot(camera.queue_s());
            let error_s = camera.error_s(time, exposed_s);
            assert!(frame < 600 || error_s.abs() < 3.5e-4, "{drift}: {error_s} s at {exposed_s} s");
        }
        assert_eq!(camera.map.restarts(), 0);
    }
}

#[test]
fn a_load_that_rises_is_no_drift() {
    let mut camera = Camera::new(0.0);
    for frame in 0..1_200_u32 {
        // From the fifth second to the twelfth, every frame waits half a millisecond longer than those a second before.
        let load_s = 5e-4 * f64::from((frame / 60).clamp(4, 12) - 4);
        let (time, exposed_s) = camera.shoot(load_s);
        let error_s = camera.error_s(time, exposed_s);
        // Taken for drift, it is 3 ms at the end.
        assert!(error_s.abs() < 1e-3, "{error_s} s at {exposed_s} s");
    }
}

#[test]
fn a_restarted_clock_is_found_within_half_a_second_in_both_directions() {
    for ahead_s in [0.0, 5000.0] {
        let mut camera = Camera::new(2e-5);
        for _ in 0..600 {
            camera.shoot(camera.queue_s());
        }
        camera.ahead_s = ahead_s;
        for _ in 0..=STEP_FRAMES {
            camera.shoot(camera.queue_s());
        }
        let (time, exposed_s) = camera.shoot(0.0);
        assert!(camera.error_s(time, exposed_s).abs() < 2e-3);
        assert_eq!(camera.map.restarts(), 1);
    }
}

#[test]
fn a_host_that_stood_still_for_three_seconds_keeps_its_map() {
    let mut camera = Camera::new(0.0);
    for _ in 0..600 {
        camera.shoot(camera.queue_s());
    }
    // A queue of four frames is all that waits for a worker that stood still; the camera's other frames are lost.
    for waiting in 0..4 {
        camera.shoot(3.0 - f64::from(waiting) * FRAME_INTERVAL_S);
    }
    camera.frame += 180;
    let (time, exposed_s) = camera.shoot(0.0);
    assert!(camera.error_s(time, exposed_s).abs() < 1e-3);
    assert_eq!(camera.map.restarts(), 0);
}

#[test]
fn host_time_is_the_wall_clock_and_its_uncertainty_covers_the_unseen_latency() {
    let mut map = ClockMap::new();
    assert!(map.host_time(Micros(0)).is_none(), "no frame, no host time");
    let wall_ns = || SystemTime::now().duration_since(UNIX_EPOCH).expect("after 1970").as_nanos() as u64;
    let before = wall_ns();
    map.observe(Micros(77_000_000), Instant::now());
    let host = map.host_time(Micros(77_000_000)).expect("a frame came");
    let after = wall_ns();
    // The frame arrived between the two readings, a frame interval after its exposure as far as is known.
    let interval_ns = (1e9 * FRAME_INTERVAL_S) as u64;
    assert!((before - 1_000..=after).contains(&(host.unix_ns + interval_ns)), "{host:?}");
    assert!((9_600_000..9_700_000).contains(&host.std_ns), "{host:?}");
    assert!(host.latency_us >= 16_666, "{host:?}");
}

#[test]
fn a_step_of_either_sign_is_counted_and_followed() {
    for ahead_s in [1000.2, 999.97] {
        let mut camera = Camera::new(8e-5);
        for _ in 0..3_000 {
            camera.shoot(camera.queue_s());
        }
        camera.ahead_s = ahead_s;
        for _ in 0..200 {
            camera.shoot(camera.queue_s());
        }
        let (time, exposed_s) = camera.shoot(0.0);
        assert!(
            camera.error_s(time, exposed_s).abs() < 3.5e-4,
            "{ahead_s}: {}",
            camera.error_s(time, exposed_s)
        );
        assert_eq!((camera.map.steps(), camera.map.restarts()), (1, 0), "{ahead_s}");
        assert!((camera.map.drift_ppm() + 80.0).abs() < 5.0, "the drift is kept: {}", camera.map.drift_ppm());
    }
}

#[test]
fn a_busy_host_and_one_false_stamp_are_no_steps() {
    let mut camera = Camera::new(0.0);
    for frame in 0..3_600_u32 {
        // Every tenth second all frames wait for 5 to 40 ms, and a queue drains.
        let busy = frame / 60 % 10 == 3;
        let queue_s = if busy { 0.040 - 6e-4 * f64::from(frame % 60) } else { camera.queue_s() };
        camera.shoot(queue_s);
        if frame == 2_000 {
            camera.ahead_s += 0.02;
            camera.shoot(0.0);
            camera.ahead_s -= 0.02;
        }
    }
    let (time, exposed_s) = camera.shoot(0.0);
    assert!(camera.error_s(time, exposed_s).abs() < 3.5e-4);
    assert_eq!((camera.map.steps(), camera.map.restarts()), (0, 0));
}
