//! Stamped samples from the wire: their instants on the clock of the run, counters, and a sentence for each kind of fault.

use super::frame::{FrameFault, MotionFrame, StampClock};
use super::sender::{Heard, Say};
use super::stamped::Taken;
use super::stamped_counters::StampedCounters;
use super::{Inner, MotionCounters};
use crate::clock_map::{ClockMap, LeastLatency};
use meniscus::units::Micros;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// Silence after which a stream of stamped samples has stopped, s.
pub(super) const STOPPED_S: f64 = 0.25;

/// Counts one more. The first one of its kind is worth a sentence.
pub(super) fn count(counter: &AtomicU64, say: &Say, sentence: impl FnOnce() -> String) {
    if counter.fetch_add(1, Ordering::Relaxed) == 0 {
        say(&sentence());
    }
}

/// Where the listener puts samples, counts and sentences.
pub(super) struct StampedSink<'l> {
    pub(super) inner: &'l Mutex<Inner>,
    pub(super) counters: &'l MotionCounters,
    pub(super) say: &'l Say,
}

/// State of the stream of stamped samples, in the listener's thread.
#[derive(Debug)]
pub(super) struct StampedWire {
    /// Clock of the run.
    clock: ClockMap,
    /// Map from the sender's clock to it.
    sender: ClockMap,
    /// Steps and restarts of it so far.
    steps: u64,
    sequence: Option<u32>,
    /// When the newest sample came, s; `None` where the stream has stopped.
    heard_s: Option<f64>,
}

impl StampedWire {
    pub(super) fn new(clock: ClockMap) -> Self {
        let sender = clock.with_latency(LeastLatency::NONE);
        Self { clock, sender, steps: 0, sequence: None, heard_s: None }
    }

    /// Takes a frame and what was heard of its sender.
    pub(super) fn take(&mut self, sink: &StampedSink<'_>, heard: Result<(MotionFrame, Heard), FrameFault>) {
        let StampedSink { inner, counters: all, say } = *sink;
        let counters = &all.stamped;
        let (frame, heard) = match heard {
            Ok(heard) => heard,
            Err(fault) => {
                return count(&counters.malformed, say, || format!("a motion frame was refused: {fault}"));
            }
        };
        match heard {
            Heard::Sample => {}
            Heard::Stranger => {
                return count(&all.strangers, say, || {
                    "motion frames are left out: another sender is heard until it is silent for a second, or the camera has \
                     contradicted this one"
                        .into()
                });
            }
            Heard::Repeated | Heard::Flood => {
                all.flooded.fetch_add(1, Ordering::Relaxed);
                return;
            }
        }
        let arrived = Instant::now();
        let now_s = self.clock.seconds(arrived);
        let Some(time_s) = self.instant_s(&frame, arrived, SystemTime::now()) else { return };
        let steps = self.sender.steps() + self.sender.restarts();
        let stepped = steps > self.steps;
        self.steps = steps;
        // A turn does not wait for the lock: it has no motion while a sample is put in. What there is to say comes behind it.
        let Ok(mut inner) = inner.lock() else { return };
        if stepped {
            inner.stamped.clear();
        }
        let taken = inner.stamped.take(&frame, time_s, now_s);
        inner.is_stamped |= matches!(taken, Taken::InOrder | Taken::Late);
        let across = inner.stamped.is_across(&frame);
        drop(inner);
        if stepped {
            count(&counters.clock_steps, say, || {
                "the clock of the motion's sender has stepped: it is mapped anew".into()
            });
        }
        let ahead_s = time_s - now_s;
        if taken != Taken::Repeated {
            // A refused sample is not a lost one.
            self.follow(&frame, counters);
        }
        match taken {
            Taken::InOrder => {}
            Taken::Late => {
                counters.late.fetch_add(1, Ordering::Relaxed);
            }
            Taken::Repeated => {
                counters.repeated.fetch_add(1, Ordering::Relaxed);
                return;
            }
            Taken::Stale => {
                return count(&counters.stale, say, || {
                    format!(
                        "a motion sample stamped {:.3} s ago was refused: compare the sender's clock",
                        -ahead_s
                    )
                });
            }
            Taken::Future => {
                return count(&counters.future, say, || {
                    format!(
                        "a motion sample stamped {ahead_s:.3} s ahead was refused: compare the sender's clock"
                    )
                });
            }
        }
        if across {
            count(&counters.across, say, || {
                "the motion leaves the line that the model knows: its part along the line is used, see --motion-line".into()
            });
        }
        counters.taken.fetch_add(1, Ordering::Relaxed);
        all.samples.fetch_add(1, Ordering::Relaxed);
        self.heard_s = Some(now_s);
    }

    /// Returns the instant of a sample on the clock of the run, s.
    fn instant_s(&mut self, frame: &MotionFrame, arrived: Instant, wall: SystemTime) -> Option<f64> {
        match frame.clock {
            StampClock::Host => {
                let wall_ns = wall.duration_since(UNIX_EPOCH).ok()?.as_nanos() as i128;
                let age_s = 1e-9 * (wall_ns - i128::from(frame.stamp_ns)) as f64;
                Some(self.clock.seconds(arrived) - age_s)
            }
            StampClock::Sender => {
                let stamp = Micros(frame.stamp_ns / 1000);
                self.sender.observe(stamp, arrived);
                Some(self.sender.instant_s(stamp)? + 1e-9 * (frame.stamp_ns % 1000) as f64)
            }
        }
    }

    /// Counts the sequence numbers that are missing before `frame`, and one less when it comes late.
    fn follow(&mut self, frame: &MotionFrame, counters: &StampedCounters) {
        let Some(last) = self.sequence else {
            self.sequence = Some(frame.sequence);
            return;
        };
        let ahead = frame.sequence.wrapping_sub(last).cast_signed();
        if ahead > 0 {
            self.sequence = Some(frame.sequence);
            // A sender that was started again begins anew, and nothing was lost.
            let missing = u64::from(ahead.unsigned_abs() - 1);
            counters.lost.fetch_add(if missing < 1000 { missing } else { 0 }, Ordering::Relaxed);
        } else if ahead > -64 {
            let _found =
                counters.lost.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |lost| lost.checked_sub(1));
        } else {
            self.sequence = Some(frame.sequence);
        }
    }

    /// Notices that the stream has stopped.
    pub(super) fn look(&mut self, counters: &StampedCounters, say: &Say) {
        let now_s = self.clock.seconds(Instant::now());
        if self.heard_s.take_if(|heard_s| now_s - *heard_s > STOPPED_S).is_some() {
            count(&counters.stops, say, || {
                "the stamped motion has stopped: the glass is tracked by the camera until it goes on".into()
            });
        }
    }
}
