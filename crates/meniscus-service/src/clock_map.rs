//! Offset between the camera's clock and this computer's, from arrival times alone.
//!
//! A frame of camera time `c` arrives at the host time
//!
//! ```text
//! a = c + o + l + d      o offset, l least latency from mid-exposure to arrival, d >= 0 delay by queues
//! ```
//!
//! The smallest `a - c` of late is `o + l`: its lower envelope, which rises by 100 ppm between two frames that touch it, so
//! that it follows a clock that drifts by up to that much. `l` cannot be observed from here, and nobody has measured it on a
//! D435 for us. It is assumed to be uniform between 0 and two frame intervals. Its standard deviation of 9.6 ms is most of
//! the stated uncertainty.

use meniscus::runtime::output::HostTime;
use meniscus::units::{FRAME_INTERVAL_S, Micros};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Assumed largest drift between the two clocks, as a share.
const DRIFT: f64 = 1e-4;

/// Change of the offset from which on the camera's clock has restarted, s: far above any delay of a running camera.
pub(crate) const STEP_S: f64 = 1.0;

/// Frames in a row behind the envelope by [`STEP_S`], none of which catches up, after which the clock has restarted and is
/// not merely late.
const STEP_FRAMES: u32 = 30;

/// Part of the delay that a queue makes up for in [`STEP_FRAMES`] frames at the least, s.
const DRAINED_S: f64 = FRAME_INTERVAL_S;

/// Mean of the least latency: one frame interval, the middle of 0 to 2 intervals.
const LATENCY_S: f64 = FRAME_INTERVAL_S;

/// Its standard deviation: 2 intervals over the root of 12.
const LATENCY_STD_S: f64 = 2.0 * FRAME_INTERVAL_S * 0.288_675_134_594_812_9;

/// Weight of the newest frame in the mean delay.
const MEMORY: f64 = 1.0 / 64.0;

/// Smallest offset of late.
#[derive(Clone, Copy, Debug)]
struct Envelope {
    /// `o + l` at `at_s`, s.
    offset_s: f64,
    /// Arrival of the last frame, s.
    at_s: f64,
    /// Rise since a frame last touched the envelope, s.
    risen_s: f64,
    /// Mean delay above the envelope, s.
    delay_s: f64,
}

/// Map from camera time to host time. Its memory is fixed and it never allocates.
#[derive(Clone, Copy, Debug)]
pub struct ClockMap {
    begun: Instant,
    envelope: Option<Envelope>,
    behind: u32,
    /// Offset of the first frame that was behind, s.
    behind_s: f64,
    restarts: u64,
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
        Self { begun, envelope: None, behind: 0, behind_s: 0.0, restarts: 0 }
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
        let at_s = self.seconds(arrived);
        let seen_s = at_s - seconds_of(camera);
        let fresh = Envelope { offset_s: seen_s, at_s, risen_s: 0.0, delay_s: 0.0 };
        let Some(last) = self.envelope else {
            self.envelope = Some(fresh);
            return;
        };
        let rise_s = DRIFT * (at_s - last.at_s).max(0.0);
        let risen =
            Envelope { offset_s: last.offset_s + rise_s, at_s, risen_s: last.risen_s + rise_s, ..last };
        // A clock that jumped ahead shows at once. One that began anew looks like late frames, and so does a computer that
        // stood still while frames queued; but a queue drains, so only what stays behind is a restart.
        if seen_s <= risen.offset_s + STEP_S {
            self.behind = 0;
        } else if self.behind > 0 && seen_s >= self.behind_s - DRAINED_S {
            self.behind += 1;
        } else if self.behind > 0 || may_restart {
            (self.behind, self.behind_s) = (1, seen_s);
        }
        if (may_restart && seen_s < risen.offset_s - STEP_S) || self.behind > STEP_FRAMES {
            self.restarts += 1;
            self.behind = 0;
            self.envelope = Some(fresh);
            return;
        }
        let touched = seen_s <= risen.offset_s;
        let (offset_s, risen_s) = if touched { (seen_s, 0.0) } else { (risen.offset_s, risen.risen_s) };
        let delay_s = last.delay_s + MEMORY * ((seen_s - offset_s).min(STEP_S) - last.delay_s);
        self.envelope = Some(Envelope { offset_s, at_s, risen_s, delay_s });
    }

    /// Returns the earliest instant at which the frame of `camera` can arrive, in seconds since the map was made; `None`
    /// before the first frame.
    #[must_use]
    pub fn earliest_arrival_s(&self, camera: Micros) -> Option<f64> {
        self.envelope.map(|envelope| seconds_of(camera) + envelope.offset_s)
    }

    /// Returns `instant` in seconds since the map was made.
    #[must_use]
    pub fn seconds(&self, instant: Instant) -> f64 {
        instant.saturating_duration_since(self.begun).as_secs_f64()
    }

    /// Returns how often the camera's clock has restarted.
    #[must_use]
    pub fn restarts(&self) -> u64 {
        self.restarts
    }

    /// Returns the mid-exposure time `camera` on the host's clock, with the latency until now; `None` before the first
    /// frame.
    #[must_use]
    pub fn host_time(&self, camera: Micros) -> Option<HostTime> {
        let envelope = self.envelope?;
        let exposed_s = self.earliest_arrival_s(camera)? - LATENCY_S;
        let (now, wall) = (Instant::now(), SystemTime::now());
        let latency_s = (self.seconds(now) - exposed_s).max(0.0);
        // The wall clock is read at each call and never carried on: NTP may set it at any time.
        let wall_s = wall.duration_since(UNIX_EPOCH).unwrap_or_default();
        let exposed = wall_s.saturating_sub(Duration::from_secs_f64(latency_s));
        // With exponential delays of mean d the smallest of n frames lies d / n above its bound; n is that of the memory.
        let envelope_std_s = envelope.risen_s + MEMORY * envelope.delay_s;
        let std_s = LATENCY_STD_S.hypot(envelope_std_s);
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
