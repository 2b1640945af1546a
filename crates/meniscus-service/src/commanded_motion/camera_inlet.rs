//! Positions of the glass from the camera's own images, as those of a tag: the stamped samples of a camera's clock.
//!
//! They have the stamps of the frames whose turns take them, so that no map between clocks and no latency enters. Counters and the
//! camera's verdict are those of the other stamped samples. The acceleration is that of a filter ([`super::camera_filter`]): there
//! is one position a frame, and none after it.

use super::camera_filter::CameraFilter;
use super::denial::Denials;
use super::frame::{MotionFrame, StampClock};
use super::samples::{Accelerations, Samples};
use super::sender::Say;
use super::stamped_wire::{STOPPED_S, count};
use super::{CommandedMotion, Inner, MotionCounters, Source, TagCounts};
use meniscus::units::Micros;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};

/// Time without a position after which the reason is reported, s.
const ABSENT_S: f64 = 3.0;

/// The end of a motion by images at which positions are handed in.
pub struct CameraInlet {
    inner: Arc<Mutex<Inner>>,
    counters: Arc<MotionCounters>,
    denials: Denials,
    say: Say,
    /// Direction of the line, of length one.
    line: [f64; 3],
    /// Motion along it; `None` before the first position.
    filter: Option<CameraFilter>,
    /// Time of the newest image, s.
    looked_s: Option<f64>,
    /// Time of the newest position, s; `None` where the stream has stopped.
    heard_s: Option<f64>,
    /// Time of the newest position or report, s.
    reported_s: Option<f64>,
    /// The last reason for which nothing came.
    absent: String,
}

impl std::fmt::Debug for CameraInlet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("CameraInlet").field("counters", &self.counters).finish_non_exhaustive()
    }
}

impl CommandedMotion {
    /// Returns a motion from positions in the camera's own images. `line` is the direction of the line of the model, the
    /// camera's x, in the axes of the positions; any length but zero.
    #[must_use]
    pub fn by_camera(line: [f64; 3], say: Say) -> (Self, CameraInlet) {
        let motion = Self::new(Samples::room(), Source::Camera).along(line);
        let length = line.iter().map(|n| n * n).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        let inlet = CameraInlet {
            line: line.map(|n| n / length),
            filter: None,
            inner: Arc::clone(&motion.inner),
            counters: Arc::clone(&motion.counters),
            denials: Denials::default(),
            say,
            looked_s: None,
            heard_s: None,
            reported_s: None,
            absent: String::new(),
        };
        (motion, inlet)
    }
}

impl CameraInlet {
    /// Takes the position in the image of `at`, whose standard deviation along the line is `std_m`, m; to be called before the
    /// worker has that image.
    pub fn take(&mut self, at: Micros, position_m: [f64; 3], std_m: f64) {
        let time_s = self.look(at);
        let frame = MotionFrame {
            clock: StampClock::Sender,
            sequence: 0,
            stamp_ns: 1000 * at.0,
            position_m,
            velocity_m_s: None,
            acceleration_m_s2: None,
        };
        let stamped = &self.counters.stamped;
        if let Err(fault) = frame.check() {
            return count(&stamped.malformed, &self.say, || {
                format!("a position of the tag was refused: {fault}")
            });
        }
        if self.heard_s == Some(time_s) {
            stamped.repeated.fetch_add(1, Ordering::Relaxed);
            return;
        }
        let along_m = self.line.iter().zip(&position_m).map(|(n, x)| n * x).sum();
        let accelerations = match &mut self.filter {
            Some(filter) => filter.take(time_s, along_m, std_m),
            None => {
                self.filter = Some(CameraFilter::begin(time_s, along_m, std_m));
                None
            }
        };
        let Ok(mut inner) = self.inner.lock() else { return };
        if let Some(Accelerations { before, now }) = accelerations {
            inner.samples.correct_newest(before);
            inner.samples.push((time_s, now));
        }
        let across = inner.stamped.is_across(&frame);
        drop(inner);
        if across {
            count(&stamped.across, &self.say, || {
                "the tag leaves the line that the model knows: its part along the line is used".into()
            });
        }
        stamped.taken.fetch_add(1, Ordering::Relaxed);
        self.counters.samples.fetch_add(1, Ordering::Relaxed);
        (self.heard_s, self.reported_s) = (Some(time_s), Some(time_s));
    }

    /// Notes that the image of `at` has no position, for this reason: a stream that stops is counted, and the reason of three
    /// seconds without a position is reported.
    pub fn lack(&mut self, at: Micros, reason: &str) {
        let time_s = self.look(at);
        let stamped = &self.counters.stamped;
        if self.heard_s.take_if(|heard_s| time_s - *heard_s > STOPPED_S).is_some() {
            count(&stamped.stops, &self.say, || {
                format!(
                    "the tag is lost ({reason}): the glass is tracked by its edges until it is seen again"
                )
            });
        }
        let since_s = *self.reported_s.get_or_insert(time_s);
        if time_s - since_s >= ABSENT_S {
            self.reported_s = Some(time_s);
            stamped.absent.fetch_add(1, Ordering::Relaxed);
            if reason != self.absent {
                (self.say)(&format!("no position of the tag for {ABSENT_S} s: {reason}"));
                reason.clone_into(&mut self.absent);
            }
        }
    }

    /// Replaces the counters of the images.
    pub fn count(&self, counts: TagCounts) {
        if let Ok(mut tag) = self.counters.tag.lock() {
            *tag = Some(counts);
        }
    }

    /// Returns the direction of the line of the model in the axes of the positions, of length one.
    #[must_use]
    pub fn line(&self) -> [f64; 3] {
        self.line
    }

    /// Reports something to the person at the terminal.
    pub fn say(&self, line: &str) {
        (self.say)(line);
    }

    /// Forgets all samples: the positions that follow do not go on from them.
    pub fn begin_anew(&mut self) {
        self.filter = None;
        if let Ok(mut inner) = self.inner.lock() {
            inner.samples.clear();
        }
    }

    /// Looks after the state of the source at the image of `at`; returns its time in seconds.
    fn look(&mut self, at: Micros) -> f64 {
        self.denials.look(&self.counters, &self.say);
        let time_s = at.0 as f64 * 1e-6;
        if self.looked_s.is_some_and(|looked_s| time_s < looked_s) {
            self.begin_anew();
            (self.heard_s, self.reported_s) = (None, Some(time_s));
            count(&self.counters.stamped.clock_steps, &self.say, || {
                "the camera's clock has stepped back: the motion of the tag begins anew".into()
            });
        }
        self.looked_s = Some(time_s);
        time_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::runtime::InputSource;
    use meniscus::units::FRAME_INTERVAL_S;
    use std::time::Instant;

    fn at(n: u64) -> Micros {
        Micros(5_000_000 + n * 1_000_000 / 60)
    }

    fn opened() -> (CommandedMotion, CameraInlet, Arc<Mutex<Vec<String>>>) {
        let said: Arc<Mutex<Vec<String>>> = Arc::default();
        let heard = Arc::clone(&said);
        let say: Say = Box::new(move |line| heard.lock().expect("nobody panicked").push(line.into()));
        let (mut motion, inlet) = CommandedMotion::by_camera([1.0, 0.0, 0.0], say);
        motion.enforced = false;
        (motion, inlet, said)
    }

    /// X(t) = 0.01 sin(14 t): the turn of a frame has the acceleration of this frame, and of the one before.
    #[test]
    fn the_turn_of_a_frame_takes_the_position_in_its_own_image() {
        let (motion, mut inlet, _) = opened();
        let swing = |n: u64| (14.0 * n as f64 * FRAME_INTERVAL_S).sin();
        for n in 0..120 {
            inlet.take(at(n), [0.01 * swing(n), 0.0, 0.4], 1e-6);
            let drive = motion.drive(at(n), Instant::now());
            if n < 8 {
                assert_eq!(drive, InputSource::Tracked, "the acceleration is not known yet");
            }
            let InputSource::Measured { before, now } = drive else { continue };
            if n > 30 {
                let due = |n: u64| -0.01 * 14.0 * 14.0 * swing(n);
                assert!((before - due(n - 1)).abs() < 0.05, "{n}: {before} for {}", due(n - 1));
                assert!((now - due(n)).abs() < 0.15, "{n}: {now} for {}", due(n));
            }
        }
        let turns = motion.turns();
        assert_eq!((turns.stamped.taken, turns.stamped.across, turns.commanded), (120, 0, 112));
    }

    #[test]
    fn a_lost_tag_is_counted_reported_once_and_the_edges_are_used() {
        let (motion, mut inlet, said) = opened();
        (0..10).for_each(|n| inlet.take(at(n), [0.0, 0.0, 0.4], 1e-5));
        (10..400).for_each(|n| inlet.lack(at(n), "no tag"));
        assert_eq!(motion.drive(at(400), Instant::now()), InputSource::Tracked);
        let counts = motion.turns().stamped;
        assert_eq!((counts.stops, counts.absent), (1, 2), "{counts:?}");
        let said = said.lock().expect("nobody panicked");
        assert_eq!(said.len(), 2, "{said:?}");
        assert!(
            said[0].contains("the tag is lost (no tag)") && said[1].contains("for 3 s: no tag"),
            "{said:?}"
        );
    }

    #[test]
    fn a_camera_clock_that_steps_back_begins_anew() {
        let (motion, mut inlet, _) = opened();
        (100..110).for_each(|n| inlet.take(at(n), [0.0, 0.0, 0.4], 1e-5));
        (0..9).for_each(|n| inlet.take(at(n), [0.0, 0.0, 0.4], 1e-5));
        assert_eq!(motion.turns().stamped.clock_steps, 1);
        assert!(matches!(motion.drive(at(8), Instant::now()), InputSource::Measured { .. }));
    }
}
