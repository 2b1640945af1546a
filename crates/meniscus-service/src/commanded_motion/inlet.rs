//! Stamped samples from another part of this program, as the ROS 2 node: the same source as that of UDP frames, with the same
//! rule of one sender, counters and verdict of the camera.

use super::datagram::Datagram;
use super::denial::Denials;
use super::frame::{FrameFault, MotionFrame};
use super::samples::Samples;
use super::sender::{Floor, Say};
use super::stamped_wire::{StampedSink, StampedWire, count};
use super::{CommandedMotion, Inner, MotionCounters, Source};
use crate::clock_map::ClockMap;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// Identifier of a sender: that of a DDS writer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SenderId(pub [u8; 16]);

/// Fault of a message that should have had a sample.
#[derive(Clone, Debug, PartialEq)]
pub enum SampleFault {
    /// Its bytes or numbers are no sample, for this reason.
    Malformed(String),
    /// Its stamp is zero.
    Unstamped,
    /// Its quaternion has this length instead of one.
    Rotation(f64),
    /// It is of a second sender of the same thing.
    SecondSender(String),
    /// Nothing has come for seconds, for this reason.
    Absent(String),
}

impl std::fmt::Display for SampleFault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Malformed(why) => write!(f, "a sample of the motion was refused: {why}"),
            Self::Unstamped => f.write_str(
                "a sample of the motion was refused: its stamp is zero. Its publisher has to fill in header.stamp with the time of \
                 the measurement",
            ),
            Self::Rotation(length) => write!(
                f,
                "a sample of the motion was refused: its quaternion has the length {length:.3}, not 1. Without a rotation it is \
                 x = y = z = 0, w = 1"
            ),
            Self::SecondSender(what) => {
                write!(f, "{what} has a second publisher: it is left out until the first is silent for a second")
            }
            Self::Absent(why) => f.write_str(why),
        }
    }
}

/// Settings of a motion by messages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InletMotion {
    /// Latency of camera frames, s.
    pub lag_s: f64,
    /// Direction of the line of the model, the camera's x, in the axes of the samples; any length but zero.
    pub line: [f64; 3],
}

/// The sender's end of a motion by messages.
pub struct MotionInlet {
    floor: Floor<SenderId>,
    stamped: StampedWire,
    denials: Denials,
    clock: ClockMap,
    inner: Arc<Mutex<Inner>>,
    counters: Arc<MotionCounters>,
    say: Say,
    /// The last reason for which nothing came.
    absent: String,
}

impl std::fmt::Debug for MotionInlet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MotionInlet").field("counters", &self.counters).finish_non_exhaustive()
    }
}

impl CommandedMotion {
    /// Returns a motion from stamped samples that another part of the program hands in at the inlet.
    #[must_use]
    pub fn by_inlet(settings: InletMotion, say: Say) -> (Self, MotionInlet) {
        let clock = ClockMap::new();
        let source = Source::Wire { clock: Box::new(clock), lag_s: settings.lag_s };
        let motion = Self::new(Samples::room(), source).along(settings.line);
        let inlet = MotionInlet {
            floor: Floor::default(),
            stamped: StampedWire::new(clock),
            denials: Denials::default(),
            clock,
            inner: Arc::clone(&motion.inner),
            counters: Arc::clone(&motion.counters),
            say,
            absent: String::new(),
        };
        (motion, inlet)
    }
}

impl MotionInlet {
    /// Takes a sample of `from`.
    pub fn take(&mut self, from: SenderId, frame: &MotionFrame) {
        let now_s = self.clock.seconds(Instant::now());
        let heard = frame.check().map(|()| (*frame, self.floor.hear(from, &Datagram::WITHOUT_NUMBER, now_s)));
        let sink = StampedSink { inner: &self.inner, counters: &self.counters, say: &self.say };
        self.stamped.take(&sink, heard);
    }

    /// Counts a message without a sample; the first of each kind, and every new reason for which nothing comes, is reported.
    pub fn refuse(&mut self, fault: &SampleFault) {
        let stamped = &self.counters.stamped;
        let counter = match fault {
            SampleFault::Malformed(_) => &stamped.malformed,
            SampleFault::Unstamped => &stamped.unstamped,
            SampleFault::Rotation(_) => &stamped.unsound,
            SampleFault::SecondSender(_) => &self.counters.strangers,
            SampleFault::Absent(why) => {
                stamped.absent.fetch_add(1, Ordering::Relaxed);
                if *why != self.absent {
                    (self.say)(why);
                    self.absent.clone_from(why);
                }
                return;
            }
        };
        count(counter, &self.say, || fault.to_string());
    }

    /// Reports something that is no fault.
    pub fn say(&self, line: &str) {
        (self.say)(line);
    }

    /// Notices that the samples have stopped and that the camera has judged; to be called several times a second.
    pub fn look(&mut self) {
        self.stamped.look(&self.counters.stamped, &self.say);
        if self.denials.look(&self.counters, &self.say) {
            self.floor.deny(self.clock.seconds(Instant::now()));
        }
    }
}

impl From<FrameFault> for SampleFault {
    fn from(fault: FrameFault) -> Self {
        Self::Malformed(fault.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::super::frame::StampClock;
    use super::*;
    use std::time::{SystemTime, UNIX_EPOCH};

    fn sample(position_m: f64) -> MotionFrame {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).expect("after 1970");
        MotionFrame {
            clock: StampClock::Host,
            sequence: 1,
            stamp_ns: now.as_nanos() as u64,
            position_m: [position_m, 0.0, 0.0],
            velocity_m_s: None,
            acceleration_m_s2: None,
        }
    }

    #[test]
    fn every_fault_has_its_counter_and_is_reported_once() {
        let said: Arc<Mutex<Vec<String>>> = Arc::default();
        let heard = Arc::clone(&said);
        let say: Say = Box::new(move |line| heard.lock().expect("nobody panicked").push(line.into()));
        let settings = InletMotion { lag_s: 0.0, line: [0.0, 2.0, 0.0] };
        let (motion, mut inlet) = CommandedMotion::by_inlet(settings, say);
        for _ in 0..2 {
            inlet.refuse(&SampleFault::Malformed("x".into()));
            inlet.refuse(&SampleFault::Unstamped);
            inlet.refuse(&SampleFault::Rotation(0.5));
            inlet.refuse(&SampleFault::SecondSender("/odom".into()));
            inlet.refuse(&SampleFault::Absent("no message".into()));
        }
        inlet.refuse(&SampleFault::Absent("no transform".into()));
        inlet.take(SenderId([1; 16]), &sample(f64::NAN));
        inlet.take(SenderId([1; 16]), &sample(0.1));
        inlet.take(SenderId([2; 16]), &sample(0.2));
        let counts = motion.turns().stamped;
        assert_eq!((counts.malformed, counts.unstamped, counts.unsound, counts.absent), (3, 2, 2, 3));
        assert_eq!((counts.taken, motion.counters.strangers.load(Ordering::Relaxed)), (1, 3));
        let said = said.lock().expect("nobody panicked");
        assert_eq!(said.len(), 6, "{said:?}");
        assert!(said[5].contains("no transform") && said[2].contains("length 0.500"), "{said:?}");
    }
}
