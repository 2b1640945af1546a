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
//! UDP samples in ASCII carry their arrival time, those in binary frames ([`MotionFrame`]) their own stamp and all three
//! dimensions. A frame of the camera is placed among them at the earliest time at which it can arrive ([`ClockMap`]), less
//! the configured lag.
//!
//! Another program part may hand in stamped samples as well, as the ROS 2 node does ([`MotionInlet`]). Positions from the
//! camera's own images have its own stamps and need no map ([`CameraInlet`]).
//!
//! Who sends them is checked in `sender`, and what they say in `agreement`: a motion from the wire that the camera denies is
//! not used, and the glass is tracked instead.

mod agreement;
mod camera_filter;
mod camera_inlet;
mod datagram;
mod denial;
mod frame;
mod inlet;
mod samples;
mod sender;
mod stamped;
mod stamped_wire;
mod tag_counts;
mod wire;

pub use camera_inlet::CameraInlet;
pub(crate) use frame::in_datagram;
pub use frame::{FrameFault, MOTION_FRAME_VERSION, MotionFrame, StampClock};
pub use inlet::{InletMotion, MotionInlet, SampleFault, SenderId};
pub use sender::{ExpectedSender, Say};
pub use stamped_wire::{StampedCounters, StampedCounts};
pub use tag_counts::{TagCounts, TagTravel};

use crate::clock_map::ClockMap;
use agreement::{Agreement, Trust};
use meniscus::runtime::InputSource;
use meniscus::units::{FRAME_INTERVAL_S, Micros};
use samples::{Accelerations, Samples};
use stamped::StampedSamples;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;
use wire::Listener;

/// Sampling rate of a table, Hz.
const TABLE_HZ: f64 = 1000.0;

/// Origin of the samples, and the relation of the two clocks.
#[derive(Debug)]
enum Source {
    /// A table over the seconds since the first turn, with the time of that turn.
    Table(Option<Micros>),
    /// UDP samples over the seconds of the clock map.
    Wire { clock: Box<ClockMap>, lag_s: f64 },
    /// Samples over the seconds of the camera's clock.
    Camera,
}

#[derive(Debug)]
struct Inner {
    /// Samples of a table or of datagrams in ASCII.
    samples: Samples,
    /// Samples of binary frames.
    stamped: StampedSamples,
    /// Whether the newest sample was of a frame.
    is_stamped: bool,
    source: Source,
}

/// Counters of a commanded motion.
#[derive(Debug, Default)]
pub struct MotionCounters {
    /// Turns with a commanded motion.
    pub commanded: AtomicU64,
    /// Turns without a sample, which used the tracked position of the glass.
    pub tracked: AtomicU64,
    /// Turns whose commanded motion the camera denied. One from the wire is not used in them, a table is.
    pub contradicted: AtomicU64,
    /// Times that the camera denied the commanded motion.
    pub contradictions: AtomicU64,
    /// Samples that were taken from datagrams.
    pub samples: AtomicU64,
    /// Datagrams that are no acceleration, lack the token, or come twice.
    pub refused: AtomicU64,
    /// Datagrams of other senders.
    pub strangers: AtomicU64,
    /// Datagrams beyond the rate of a sender.
    pub flooded: AtomicU64,
    /// Counters of the stamped samples.
    pub stamped: StampedCounters,
    /// Counters of a tag's images; `None` of another motion.
    pub tag: Mutex<Option<TagCounts>>,
    /// The camera agrees again, which is not reported yet.
    reconciled: AtomicBool,
}

/// Turns by the origin of their motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionTurns {
    /// Turns with a commanded motion.
    pub commanded: u64,
    /// Turns that used the tracked position of the glass.
    pub tracked: u64,
    /// Turns whose commanded motion the camera denied.
    pub contradicted: u64,
    /// Times that the camera denied the commanded motion.
    pub contradictions: u64,
    /// Datagrams that were not taken.
    pub refused: u64,
    /// Stamped samples.
    pub stamped: StampedCounts,
    /// Images of a tag; `None` of another motion.
    pub tag: Option<TagCounts>,
}

/// Settings of a motion over UDP.
#[derive(Clone, Debug, PartialEq)]
pub struct WireMotion {
    /// Address to listen at.
    pub address: SocketAddr,
    /// Extra latency of camera frames over samples, s: of samples in ASCII beyond their own, of stamped ones all of it.
    pub lag_s: f64,
    /// Direction of the line of the model, the camera's x, in the axes of stamped samples; any length but zero.
    pub line: [f64; 3],
    /// Sender that is expected.
    pub expected: ExpectedSender,
}

/// The sender's x axis is the camera's.
pub const LINE_ALONG_X: [f64; 3] = [1.0, 0.0, 0.0];

/// A source of accelerations that the estimator takes instead of the tracked motion.
#[derive(Debug)]
pub struct CommandedMotion {
    inner: Arc<Mutex<Inner>>,
    /// Its counters.
    pub counters: Arc<MotionCounters>,
    ended: Arc<AtomicBool>,
    /// Comparison with the camera. Only the worker uses it.
    agreement: Mutex<Agreement>,
    /// Whether a motion that the camera denies is left out. A table is a person's own: it is used, and the denial counted.
    enforced: bool,
}

impl CommandedMotion {
    fn new(samples: Samples, source: Source) -> Self {
        let enforced = !matches!(source, Source::Table(_));
        let stamped = StampedSamples::room(LINE_ALONG_X);
        let inner = Arc::new(Mutex::new(Inner { samples, stamped, is_stamped: false, source }));
        let agreement = Mutex::default();
        Self { inner, counters: Arc::default(), ended: Arc::default(), agreement, enforced }
    }

    /// Sets the direction of the line in the axes of stamped samples.
    fn along(self, line: [f64; 3]) -> Self {
        let length = line.iter().map(|n| n * n).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        if let Ok(mut inner) = self.inner.lock() {
            inner.stamped = StampedSamples::room(line.map(|n| n / length));
        }
        self
    }

    /// Returns a motion from a table: `acceleration` (m/s2) over the first `seconds` after the first turn.
    #[must_use]
    pub fn by_table(seconds: f64, acceleration: impl Fn(f64) -> f64) -> Self {
        // From two intervals before the first turn on, whose motion counts for it.
        let first = -(2.0 * FRAME_INTERVAL_S * TABLE_HZ).ceil() as i64;
        let last = (seconds * TABLE_HZ).ceil() as i64;
        let at = |k: i64| k as f64 / TABLE_HZ;
        Self::new(Samples::table((first..=last).map(|k| (at(k), acceleration(at(k))))), Source::Table(None))
    }

    /// Returns a motion from datagrams, each one the acceleration of the glass along x, m/s2, in ASCII, or a
    /// [`MotionFrame`].
    ///
    /// # Errors
    /// The error of the operating system on the address.
    pub fn by_wire(settings: WireMotion, say: Say) -> std::io::Result<Self> {
        let WireMotion { address, lag_s, line, expected } = settings;
        let socket = wire::bind(address)?;
        let clock = ClockMap::new();
        let motion = Self::new(Samples::room(), Source::Wire { clock: Box::new(clock), lag_s }).along(line);
        let listener = Listener {
            address,
            expected,
            clock,
            inner: Arc::clone(&motion.inner),
            counters: Arc::clone(&motion.counters),
            ended: Arc::clone(&motion.ended),
            say,
        };
        std::thread::Builder::new().name("motion".into()).spawn(move || listener.run(socket))?;
        Ok(motion)
    }

    /// Returns the number of turns with a commanded motion and without one.
    #[must_use]
    pub fn turns(&self) -> MotionTurns {
        let of = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        let counters = &self.counters;
        MotionTurns {
            commanded: of(&counters.commanded),
            tracked: of(&counters.tracked),
            contradicted: of(&counters.contradicted),
            contradictions: of(&counters.contradictions),
            refused: of(&counters.refused) + of(&counters.strangers) + of(&counters.flooded),
            stamped: counters.stamped.counts(),
            tag: counters.tag.lock().ok().and_then(|tag| *tag),
        }
    }

    /// Returns the motion of the turn at `at`, whose frame came at `arrived`; [`InputSource::Tracked`] without a sample, or
    /// where the camera denies it.
    pub(super) fn drive(&self, at: Micros, arrived: Instant) -> InputSource {
        // The lock is held only while a sample is put in. The worker never waits for it: one turn without a commanded
        // motion costs less than a late turn.
        let used = self.inner.try_lock().ok().and_then(|mut inner| {
            let time_s = inner.time_s(at, arrived)?;
            let commanded = inner.accelerations(time_s)?;
            let drive = InputSource::Measured { before: commanded.before, now: commanded.now };
            let Ok(mut agreement) = self.agreement.try_lock() else {
                return (!self.enforced).then_some(drive);
            };
            agreement.commanded(at, commanded, |ago_s| inner.accelerations(time_s - ago_s));
            let trust = agreement.trust();
            if trust == Trust::Contradicted {
                self.counters.contradicted.fetch_add(1, Ordering::Relaxed);
            }
            (!self.enforced || trust == Trust::Used).then_some(drive)
        });
        let counter = if used.is_some() { &self.counters.commanded } else { &self.counters.tracked };
        counter.fetch_add(1, Ordering::Relaxed);
        used.unwrap_or_default()
    }

    /// Takes the position of the glass in the frame of the turn at `at`, m; `None` where it was not seen.
    pub(super) fn compare(&self, at: Micros, glass_x_m: Option<f32>) {
        let Ok(mut agreement) = self.agreement.try_lock() else { return };
        let before = agreement.trust();
        agreement.tracked(at, glass_x_m.map(f64::from));
        match (before, agreement.trust()) {
            (Trust::Untried | Trust::Used, Trust::Contradicted) => {
                self.counters.contradictions.fetch_add(1, Ordering::Relaxed);
            }
            (Trust::Contradicted, Trust::Used) => self.counters.reconciled.store(true, Ordering::Relaxed),
            _ => {}
        }
    }
}

impl Drop for CommandedMotion {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
    }
}

impl Inner {
    /// Returns the time of the turn at `at` among the samples, s.
    fn time_s(&mut self, at: Micros, arrived: Instant) -> Option<f64> {
        match &mut self.source {
            Source::Table(first) => {
                let first = *first.get_or_insert(at);
                Some(at.0 as f64 * 1e-6 - first.0 as f64 * 1e-6)
            }
            Source::Wire { clock, lag_s } => {
                clock.observe(at, arrived);
                Some(clock.earliest_arrival_s(at)? - *lag_s)
            }
            Source::Camera => Some(at.0 as f64 * 1e-6),
        }
    }

    /// Returns what a turn at `time_s` takes from the samples.
    fn accelerations(&self, time_s: f64) -> Option<Accelerations> {
        let samples = if self.is_stamped { &self.stamped.samples } else { &self.samples };
        let before = samples.around(time_s - FRAME_INTERVAL_S)?;
        Some(Accelerations { before, now: samples.now(time_s)? })
    }
}

#[cfg(test)]
mod tests {
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
        assert!(
            (before - places).abs() < 0.1 && (now - acceleration(t)).abs() < 0.1,
            "{before} {places} {now}"
        );
        // Silence: the tracked position is used again.
        let late = begun + Duration::from_secs_f64(1.5);
        assert_eq!(motion.drive(at(1234.5 + 1.492), late), InputSource::Tracked);
    }
}
