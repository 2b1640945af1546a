//! Commanded motion of the glass: a table of its course, or accelerations of an IMU or a robot over UDP.
//!
//! A turn at the instant `t` needs the acceleration at `t` and the one a frame interval `h` earlier, as the positions of
//! three frames would give it:
//!
//! ```text
//! now = a(t)
//! before = (X(t) - 2 X(t - h) + X(t - 2h)) / h^2 = 1/h int_{-h}^{h} (1 - |s| / h) a(t - h + s) ds
//! ```
//!
//! Both are taken from samples `(t_k, a_k)`: `now` by interpolation between the two nearest ones, `before` as their
//! mean with these weights.
//!
//! UDP samples carry their arrival time. A frame is placed among them at the earliest time at which it can arrive
//! ([`ClockMap`]), less the configured lag.

use crate::clock_map::ClockMap;
use meniscus::runtime::InputSource;
use meniscus::units::{FRAME_INTERVAL_S, Micros};
use std::collections::VecDeque;
use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Sampling rate of a table, Hz.
const TABLE_HZ: f64 = 1000.0;
/// UDP samples that are kept: a quarter of a second at 1 kHz.
const KEPT: usize = 256;
/// Time for which the newest sample is extrapolated, seconds; after it the tracked position of the glass is used.
const HOLD_S: f64 = 0.025;
/// Largest acceleration that is accepted, m/s2: twenty times gravity.
const LARGEST: f64 = 200.0;
/// Interval at which the listener checks whether it is still wanted.
const PAUSE: Duration = Duration::from_millis(100);

/// Samples, oldest first: time in seconds, acceleration in m/s2.
#[derive(Debug, Default)]
struct Samples(VecDeque<(f64, f64)>);

impl Samples {
    /// Acceleration between the samples around `time_s`; `None` before the first and beyond the last one's hold.
    fn now(&self, time_s: f64) -> Option<f64> {
        let after = self.0.partition_point(|(t, _)| *t <= time_s);
        let (t0, a0) = *self.0.get(after.checked_sub(1)?)?;
        match self.0.get(after) {
            Some((t1, a1)) => Some(a0 + (a1 - a0) * (time_s - t0) / (t1 - t0)),
            None => (time_s - t0 <= HOLD_S).then_some(a0),
        }
    }

    /// The mean around `time_s` with the weights of the second difference; as [`Self::now`] where no sample lies there.
    fn around(&self, time_s: f64) -> Option<f64> {
        let h = FRAME_INTERVAL_S;
        let first = self.0.partition_point(|(t, _)| *t <= time_s - h);
        let near = self.0.range(first..).take_while(|(t, _)| *t < time_s + h);
        let (sum, weights) = near.fold((0.0, 0.0), |(sum, weights), (t, a)| {
            let weight = 1.0 - (t - time_s).abs() / h;
            (sum + weight * a, weights + weight)
        });
        if weights > 0.0 { Some(sum / weights) } else { self.now(time_s) }
    }
}

/// Origin of the samples, and the relation of the two clocks.
#[derive(Debug)]
enum Source {
    /// A table over the seconds since the first turn, with the time of that turn.
    Table(Option<Micros>),
    /// UDP samples over the seconds of the clock map.
    Wire { clock: ClockMap, lag_s: f64 },
}

#[derive(Debug)]
struct Inner {
    samples: Samples,
    source: Source,
}

/// Counters of a commanded motion.
#[derive(Debug, Default)]
pub struct MotionCounters {
    /// Turns with a commanded motion.
    pub commanded: AtomicU64,
    /// Turns without a sample, which used the tracked position of the glass.
    pub tracked: AtomicU64,
    /// Datagrams that are not an acceleration.
    pub refused: AtomicU64,
}

/// Turns by the origin of their motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MotionTurns {
    /// Turns with a commanded motion.
    pub commanded: u64,
    /// Turns that used the tracked position of the glass.
    pub tracked: u64,
}

/// A source of accelerations that the estimator takes instead of the tracked motion.
#[derive(Debug)]
pub struct CommandedMotion {
    inner: Arc<Mutex<Inner>>,
    /// Its counters.
    pub counters: Arc<MotionCounters>,
    ended: Arc<AtomicBool>,
}

impl CommandedMotion {
    fn new(samples: Samples, source: Source) -> Self {
        let inner = Arc::new(Mutex::new(Inner { samples, source }));
        Self { inner, counters: Arc::default(), ended: Arc::default() }
    }

    /// Returns a motion from a table: `acceleration` (m/s2) over the first `seconds` after the first turn.
    #[must_use]
    pub fn by_table(seconds: f64, acceleration: impl Fn(f64) -> f64) -> Self {
        // From two intervals before the first turn on, whose motion counts for it.
        let first = -(2.0 * FRAME_INTERVAL_S * TABLE_HZ).ceil() as i64;
        let last = (seconds * TABLE_HZ).ceil() as i64;
        let at = |k: i64| k as f64 / TABLE_HZ;
        Self::new(
            Samples((first..=last).map(|k| (at(k), acceleration(at(k)))).collect()),
            Source::Table(None),
        )
    }

    /// Returns a motion from datagrams at `address`, each one ASCII number: the acceleration of the glass along x, m/s2.
    /// `lag_s` is the extra latency of camera frames over UDP samples.
    ///
    /// # Errors
    /// What the system says of the address.
    pub fn by_wire(address: SocketAddr, lag_s: f64) -> std::io::Result<Self> {
        let socket = UdpSocket::bind(address)?;
        socket.set_read_timeout(Some(PAUSE))?;
        let clock = ClockMap::new();
        let motion = Self::new(Samples(VecDeque::with_capacity(KEPT)), Source::Wire { clock, lag_s });
        let (inner, counters, ended) =
            (Arc::clone(&motion.inner), Arc::clone(&motion.counters), Arc::clone(&motion.ended));
        std::thread::spawn(move || {
            let mut room = [0; 64];
            while !ended.load(Ordering::Relaxed) {
                let Ok(length) = socket.recv(&mut room) else { continue };
                let arrived_s = clock.seconds(Instant::now());
                match number(room.get(..length).unwrap_or(&[])) {
                    Some(acceleration) => push(&inner, (arrived_s, acceleration)),
                    None => _ = counters.refused.fetch_add(1, Ordering::Relaxed),
                }
            }
        });
        Ok(motion)
    }

    /// Returns the number of turns with a commanded motion and without one.
    #[must_use]
    pub fn turns(&self) -> MotionTurns {
        let of = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        MotionTurns { commanded: of(&self.counters.commanded), tracked: of(&self.counters.tracked) }
    }

    /// Returns the motion of the turn at `at`, whose frame came at `arrived`; [`InputSource::Tracked`] without a sample.
    pub(super) fn drive(&self, at: Micros, arrived: Instant) -> InputSource {
        // The lock is held only while a sample is put in. The worker never waits for it: one turn without a commanded
        // motion costs less than a late turn.
        let drive = self.inner.try_lock().ok().and_then(|mut inner| inner.drive(at, arrived));
        let counter = if drive.is_some() { &self.counters.commanded } else { &self.counters.tracked };
        counter.fetch_add(1, Ordering::Relaxed);
        drive.unwrap_or_default()
    }
}

impl Drop for CommandedMotion {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
    }
}

impl Inner {
    fn drive(&mut self, at: Micros, arrived: Instant) -> Option<InputSource> {
        let time_s = match &mut self.source {
            Source::Table(first) => {
                let first = *first.get_or_insert(at);
                at.0 as f64 * 1e-6 - first.0 as f64 * 1e-6
            }
            Source::Wire { clock, lag_s } => {
                clock.observe(at, arrived);
                clock.earliest_arrival_s(at)? - *lag_s
            }
        };
        let before = self.samples.around(time_s - FRAME_INTERVAL_S)?;
        Some(InputSource::Measured { before, now: self.samples.now(time_s)? })
    }
}

fn push(inner: &Mutex<Inner>, sample: (f64, f64)) {
    // The worker never panics with it in its hands.
    let Ok(mut inner) = inner.lock() else { return };
    let samples = &mut inner.samples.0;
    if samples.back().is_some_and(|(t, _)| sample.0 <= *t) {
        return;
    }
    if samples.len() == KEPT {
        samples.pop_front();
    }
    samples.push_back(sample);
}

/// The number of a datagram.
fn number(bytes: &[u8]) -> Option<f64> {
    let number: f64 = std::str::from_utf8(bytes).ok()?.trim().parse().ok()?;
    (number.abs() <= LARGEST).then_some(number)
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let source = Source::Wire { clock: ClockMap::starting_at(begun), lag_s: 0.008 };
        let motion = CommandedMotion::new(Samples(VecDeque::with_capacity(KEPT)), source);
        let (mut sent, mut worst, mut asked) = (0, 0.0_f64, 0);
        for n in 10..60 {
            let t = f64::from(n) * FRAME_INTERVAL_S;
            let jitter = if n % 3 == 0 { 0.0 } else { 0.004 };
            let arrived_s = t + 0.008 + jitter;
            while f64::from(sent) / 500.0 <= arrived_s {
                let s = f64::from(sent) / 500.0;
                push(&motion.inner, (s, acceleration(s)));
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
        // Silence: the tracked position is used again.
        let late = begun + Duration::from_secs_f64(1.5);
        assert_eq!(motion.drive(at(1234.5 + 1.492), late), InputSource::Tracked);
    }

    #[test]
    fn a_datagram_is_a_finite_number_in_range() {
        let motion = CommandedMotion::by_wire("127.0.0.1:0".parse().expect("an address"), 0.0);
        assert!(motion.is_ok());
        assert_eq!(number(b" -1.25\n"), Some(-1.25));
        for wrong in [&b"nan"[..], b"inf", b"1e9", b"", b"1.0 2.0", &[0xff, 0xfe]] {
            assert_eq!(number(wrong), None, "{wrong:?}");
        }
    }
}
