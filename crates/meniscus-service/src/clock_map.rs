//! Offset between a device's clock and this computer's, and its drift, from arrival times alone.
//!
//! A frame of camera time `c` arrives at the host time
//!
//! ```text
//! a = (1 + e) c + o + l + d     o offset, e drift, l least latency from mid-exposure to arrival, d >= 0 delay by queues
//! ```
//!
//! The lower envelope of `a - c` is `e c + o + l` (`envelope`). A step of the clock is recognised, counted, and the
//! envelope begun anew with the drift that it had (`steps`). `l` cannot be observed from here, and nobody has measured it
//! on a D435 for us. Unless it is stated, it is assumed to be uniform between 0 and two frame intervals, and its standard
//! deviation of 9.6 ms is most of the stated uncertainty.

mod envelope;
mod steps;

use envelope::{Drift, Envelope, Point};
use meniscus::runtime::output::HostTime;
use meniscus::units::{FRAME_INTERVAL_S, Micros};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
pub(crate) use steps::STEP_S;
use steps::{Compared, Suspicion, Verdict};

/// Least latency l from the instant of a stamp to its arrival.
///
/// ```
/// use meniscus_service::clock_map::LeastLatency;
///
/// // As measured with a light that the program switches.
/// let measured = LeastLatency { mean_s: 0.0213, std_s: 0.0005 };
/// assert!(measured.std_s < LeastLatency::UNKNOWN_CAMERA.std_s);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastLatency {
    /// Its mean, s.
    pub mean_s: f64,
    /// Its standard deviation, s.
    pub std_s: f64,
}

impl LeastLatency {
    /// Of a camera that was not measured: uniform from 0 to two frame intervals.
    pub const UNKNOWN_CAMERA: Self =
        Self { mean_s: FRAME_INTERVAL_S, std_s: 2.0 * FRAME_INTERVAL_S * 0.288_675_134_594_812_9 };

    /// Of a sender on this machine or on its network, whose least latency counts as none.
    pub const NONE: Self = Self { mean_s: 0.0, std_s: 0.000_5 };
}

/// Findings of a map about the two clocks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClockFindings {
    /// Drift of this computer's clock against the device's, ppm.
    pub drift_ppm: f64,
    /// Steps of the device's clock by less than a second.
    pub steps: u64,
    /// Restarts of it: steps of a second or more.
    pub restarts: u64,
}

/// Map from camera time to host time. Its memory is fixed and it never allocates.
#[derive(Clone, Copy, Debug)]
pub struct ClockMap {
    begun: Instant,
    latency: LeastLatency,
    envelope: Option<Envelope>,
    suspicion: Suspicion,
    restarts: u64,
    steps: u64,
}

impl ClockMap {
    /// Returns a map that has seen no frame.
    #[must_use]
    pub fn new() -> Self {
        Self::starting_at(Instant::now())
    }

    /// Returns a map that has seen no frame and counts seconds from `begun`, before any arrival.
    #[must_use]
    pub fn starting_at(begun: Instant) -> Self {
        let latency = LeastLatency::UNKNOWN_CAMERA;
        Self { begun, latency, envelope: None, suspicion: Suspicion::default(), restarts: 0, steps: 0 }
    }

    /// States the least latency, where it is known.
    #[must_use]
    pub fn with_latency(self, latency: LeastLatency) -> Self {
        Self { latency, ..self }
    }

    /// Takes the arrival of the frame of camera time `camera`.
    pub fn observe(&mut self, camera: Micros, arrived: Instant) {
        self.take(camera, arrived, true);
    }

    /// Takes the arrival of a frame that follows the last one by the camera's own frame counter, so that its clock cannot have
    /// restarted in between: a frame that is far behind has waited.
    pub fn observe_next(&mut self, camera: Micros, arrived: Instant) {
        self.take(camera, arrived, false);
    }

    /// Takes the arrival of a frame before which the camera's clock may have restarted.
    fn take(&mut self, camera: Micros, arrived: Instant, may_restart: bool) {
        let (at_s, camera_s) = (self.seconds(arrived), seconds_of(camera));
        let point = Point { camera_s, seen_s: at_s - camera_s };
        let Some(envelope) = &mut self.envelope else {
            self.envelope = Some(Envelope::begin(point, at_s, Drift::unknown()));
            return;
        };
        let (seen_s, above_s) = (point.seen_s, point.seen_s - envelope.at(camera_s));
        let compared = Compared { seen_s, above_s, may_restart, young: envelope.is_young() };
        match self.suspicion.judge(compared) {
            Verdict::Ordinary => return envelope.take(point, at_s),
            Verdict::Doubtful => return,
            Verdict::Stepped => self.steps += 1,
            Verdict::Restarted => self.restarts += 1,
        }
        // A step is of the count, not of the crystal.
        *envelope = Envelope::begin(point, at_s, envelope.drift());
    }

    /// Returns the earliest instant at which the frame of `camera` can arrive, in seconds since the map was made; `None`
    /// before the first frame.
    #[must_use]
    pub fn earliest_arrival_s(&self, camera: Micros) -> Option<f64> {
        let camera_s = seconds_of(camera);
        self.envelope.as_ref().map(|envelope| camera_s + envelope.at(camera_s))
    }

    /// Returns the instant of the stamp `camera`, mid-exposure of a camera, in seconds since the map was made; `None` before
    /// the first frame.
    #[must_use]
    pub fn instant_s(&self, camera: Micros) -> Option<f64> {
        self.earliest_arrival_s(camera).map(|earliest_s| earliest_s - self.latency.mean_s)
    }

    /// Returns the standard deviation of [`Self::instant_s`], s; `None` before the first frame.
    #[must_use]
    pub fn std_s(&self, camera: Micros) -> Option<f64> {
        self.envelope.as_ref().map(|envelope| envelope.std_s(seconds_of(camera)).hypot(self.latency.std_s))
    }

    /// Returns the drift of this computer's clock against the device's, ppm; zero before it is known.
    #[must_use]
    pub fn drift_ppm(&self) -> f64 {
        self.envelope.as_ref().map_or(0.0, |envelope| 1e6 * envelope.drift().rate)
    }

    /// Returns the findings so far.
    #[must_use]
    pub fn findings(&self) -> ClockFindings {
        ClockFindings { drift_ppm: self.drift_ppm(), steps: self.steps, restarts: self.restarts }
    }

    /// Returns `instant` in seconds since the map was made.
    #[must_use]
    pub fn seconds(&self, instant: Instant) -> f64 {
        instant.saturating_duration_since(self.begun).as_secs_f64()
    }

    /// Returns how often the camera's clock has restarted: steps of a second or more.
    #[must_use]
    pub fn restarts(&self) -> u64 {
        self.restarts
    }

    /// Returns how often the camera's clock has stepped by less than a second.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Returns the mid-exposure time `camera` on the host's clock, with the latency until now; `None` before the first
    /// frame.
    #[must_use]
    pub fn host_time(&self, camera: Micros) -> Option<HostTime> {
        let (exposed_s, std_s) = (self.instant_s(camera)?, self.std_s(camera)?);
        let (now, wall) = (Instant::now(), SystemTime::now());
        let latency_s = (self.seconds(now) - exposed_s).max(0.0);
        // The wall clock is read at each call and never carried on: NTP may set it at any time.
        let wall_s = wall.duration_since(UNIX_EPOCH).unwrap_or_default();
        let exposed = wall_s.saturating_sub(Duration::from_secs_f64(latency_s));
        Some(HostTime {
            unix_ns: u64::try_from(exposed.as_nanos()).unwrap_or(u64::MAX),
            std_ns: (1e9 * std_s) as u64,
            latency_us: (1e6 * latency_s) as u64,
        })
    }
}

impl Default for ClockMap {
    fn default() -> Self {
        Self::new()
    }
}

fn seconds_of(camera: Micros) -> f64 {
    camera.0 as f64 * 1e-6
}

#[cfg(test)]
mod tests;
