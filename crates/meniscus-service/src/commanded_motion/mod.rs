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
mod counters;
mod datagram;
mod denial;
mod frame;
mod inlet;
mod samples;
mod sender;
mod stamped;
mod stamped_counters;
mod stamped_wire;
mod tag_counts;
#[cfg(test)]
mod tests;
mod wire;

pub use camera_inlet::CameraInlet;
pub use counters::{MotionCounters, MotionTurns};
pub(crate) use frame::in_datagram;
pub use frame::{FrameFault, MOTION_FRAME_VERSION, MotionFrame, StampClock};
pub use inlet::{InletMotion, MotionInlet, SampleFault, SenderId};
pub use sender::{ExpectedSender, Say};
pub use stamped_counters::{StampedCounters, StampedCounts};
pub use tag_counts::{TagCounts, TagTravel};

use crate::clock_map::ClockMap;
use agreement::{Agreement, Trust};
use meniscus::runtime::InputSource;
use meniscus::units::{FRAME_INTERVAL_S, Micros};
use samples::{Accelerations, Samples};
use stamped::StampedSamples;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
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
        self.counters.turns()
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
