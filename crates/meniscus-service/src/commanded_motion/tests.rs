//! Motions of a table and of datagrams against the same in closed form.

use super::*;
use std::time::Duration;

/// X(t) = 0.01 sin(20 t) and its acceleration.
fn place(t: f64) -> f64 {
    0.01 * (20.0 * t).sin()
}

fn acceleration(t: f64) -> f64 {
    -4.0 * (20.0 * t).sin()
}

fn at(seconds: f64) -> Micros {
    Micros((seconds * 1e6).round() as u64)
}

#[test]
fn a_table_gives_the_second_difference_of_three_positions() {
    let motion = CommandedMotion::by_table(2.0, acceleration);
    let arrived = Instant::now();
    let _first = motion.drive(at(5.0), arrived);
    for n in 1..100 {
        let t = f64::from(n) * FRAME_INTERVAL_S;
        let InputSource::Measured { before, now } = motion.drive(at(5.0 + t), arrived) else {
            std::panic!("no motion at {t}")
        };
        let h = FRAME_INTERVAL_S;
        let places = (place(t) - 2.0 * place(t - h) + place(t - 2.0 * h)) / (h * h);
        assert!((before - places).abs() < 5e-3, "{t}: {before} {places}");
        assert!((now - acceleration(t)).abs() < 1e-3, "{t}: {now}");
    }
    assert_eq!(motion.drive(at(5.0 + 2.1), arrived), InputSource::Tracked, "behind its end");
    assert_eq!(motion.counters.tracked.load(Ordering::Relaxed), 1);
}

/// Datagrams as an IMU would send them, 500 a second, and frames that arrive 8 ms behind their exposure and a
/// jitter later. The clocks are apart by any number.
#[test]
fn udp_samples_give_the_same_across_unsynchronised_clocks() {
    let begun = Instant::now();
    let source = Source::Wire { clock: Box::new(ClockMap::starting_at(begun)), lag_s: 0.008 };
    let mut motion = CommandedMotion::new(Samples::room(), source);
    motion.enforced = false;
    let (mut sent, mut worst, mut asked) = (0, 0.0_f64, 0);
    for n in 10..60 {
        let t = f64::from(n) * FRAME_INTERVAL_S;
        let jitter = if n % 3 == 0 { 0.0 } else { 0.004 };
        let arrived_s = t + 0.008 + jitter;
        while f64::from(sent) / 500.0 <= arrived_s {
            let s = f64::from(sent) / 500.0;
            motion.inner.lock().expect("nobody panicked").samples.push((s, acceleration(s)));
            sent += 1;
        }
        let arrived = begun + Duration::from_secs_f64(arrived_s);
        let drive = motion.drive(at(1234.5 + t), arrived);
        // The first frames teach the least distance of the clocks.
        if n > 15 {
            let InputSource::Measured { now, .. } = drive else { std::panic!("frame {n}: {drive:?}") };
            worst = worst.max((now - acceleration(t)).abs());
            asked += 1;
        }
    }
    assert!(asked > 40 && worst < 0.05, "{worst}");
    assert_eq!(motion.turns().stamped, StampedCounts::default());
    // Stamped samples of the same instants give the same, though they all came 15 ms late.
    let mut inner = motion.inner.lock().expect("nobody panicked");
    for k in 0..520 {
        let s = f64::from(k) / 500.0;
        let frame = MotionFrame {
            clock: StampClock::Host,
            sequence: 0,
            stamp_ns: 0,
            position_m: [place(s), 0.0, 0.0],
            velocity_m_s: None,
            acceleration_m_s2: None,
        };
        inner.stamped.take(&frame, s, s + 0.015);
    }
    inner.is_stamped = true;
    drop(inner);
    let t = 60.0 * FRAME_INTERVAL_S;
    let InputSource::Measured { before, now } =
        motion.drive(at(1234.5 + t), begun + Duration::from_secs_f64(t + 0.008))
    else {
        std::panic!("no stamped motion")
    };
    let h = FRAME_INTERVAL_S;
    let places = (place(t) - 2.0 * place(t - h) + place(t - 2.0 * h)) / (h * h);
    assert!((before - places).abs() < 0.1 && (now - acceleration(t)).abs() < 0.1, "{before} {places} {now}");
    // Silence: the tracked position is used again.
    let late = begun + Duration::from_secs_f64(1.5);
    assert_eq!(motion.drive(at(1234.5 + 1.492), late), InputSource::Tracked);
}
