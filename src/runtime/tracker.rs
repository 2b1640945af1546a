//! The whole camera side: payloads in, one turn a frame interval out, whatever the camera does.
//!
//! A frame that never came is a turn without a measurement. A frame that comes after its turn has been taken has no turn of
//! its own. If no other turn was taken since, the estimate starts again from before that turn, with the frame, and the next
//! turn follows from it; else the frame is not used. Time is the camera's; its frame counter may skip or restart.

use super::budget::Clock;
use super::estimate::Estimate;
use super::estimator::Estimator;
use super::memory::Memory;
use super::mode::COAST_LIMIT;
use super::turn_input::{InputSource, TurnInput};
use crate::runtime::health::{Health, count};
use crate::runtime::profile_sensor::{FrameObservation, ProfileSensor};
use crate::surface::{ExtractionError, SurfaceProfile};
use crate::units::Micros;
use crate::usb::frame::Stamp;
use crate::usb::uvc::Stream;

/// Frame interval, microseconds.
const INTERVAL_US: u64 = 16_667;

/// Stale frames in a row after which the camera's time replaces ours.
const STALE_LIMIT: u32 = 3;

/// One turn, as it is handed on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Instant of the turn: mid-exposure of its frame, or where that of a missing frame would lie.
    pub time: Micros,
    /// Stamp of the frame, if one came.
    pub stamp: Option<Stamp>,
    /// Profile of the frame, or the reason that there is none; `None` without a frame.
    pub profile: Option<Result<SurfaceProfile, ExtractionError>>,
    /// Estimate of the liquid.
    pub estimate: Estimate,
}

/// Profile sensor, estimator and their memory.
///
/// ```
/// # #[repr(align(64))]
/// # struct Aligned<T: ?Sized>(T);
/// # static BLOB: &Aligned<[u8]> =
/// #     &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/models/glycerine.blob")));
/// # struct NoClock;
/// # impl meniscus::runtime::Clock for NoClock {
/// #     fn now_us(&mut self) -> u64 {
/// #         0
/// #     }
/// # }
/// # let model = meniscus::blob::Model::load(&BLOB.0)?;
/// use meniscus::runtime::{Estimator, InputSource, ProfileSensor, Tracker};
/// use meniscus::surface::{Config, Settings};
/// use meniscus::usb::uvc::Stream;
///
/// let (mut depth, mut infrared) = (vec![0; 640 * 480 * 2], vec![0; 640 * 480]);
/// let config = Config::new(Settings::default()).expect("a D435 before the glass");
/// let sensor = ProfileSensor::new(config, &mut depth, &mut infrared);
/// let mut tracker = Tracker::new(Estimator::new(&model), sensor);
///
/// // Two pairs of images, three frame intervals apart: two frames were lost between them.
/// let mut times_us = Vec::new();
/// for (number, captured_us) in [1_000_000_u32, 1_050_001].into_iter().enumerate() {
///     // The lowest bit of the flags toggles from frame to frame.
///     let head = [&[6, 0b110 | number as u8][..], &captured_us.to_le_bytes()].concat();
///     for (stream, bytes) in [(Stream::Depth, 640 * 480 * 2), (Stream::Outline, 640 * 480)] {
///         let payload = [&head[..], &vec![128; bytes]].concat();
///         tracker.accept(stream, &payload, InputSource::tracked, &mut NoClock, &mut [], |turn, _| {
///             times_us.push(turn.time.0);
///         });
///     }
/// }
/// assert_eq!(times_us, [1_000_000, 1_016_667, 1_033_334, 1_050_001]);
/// assert_eq!((tracker.memory.health.turns, tracker.memory.health.frames_missing), (4, 2));
/// # Ok::<(), meniscus::blob::LoadError>(())
/// ```
#[derive(Debug)]
pub struct Tracker<'m, 'b> {
    estimator: Estimator<'m>,
    /// Payloads to profiles.
    pub sensor: ProfileSensor<'b>,
    /// Memory of the estimator, with its counters.
    pub memory: Memory,
    now: Option<Micros>,
    stale: u32,
    silent: Option<SilentTurn>,
}

/// Newest turn, where it was taken in silence.
#[derive(Debug)]
struct SilentTurn {
    /// Memory before it.
    before: Memory,
    /// Motion of the glass that it took.
    source: InputSource,
}

impl<'m, 'b> Tracker<'m, 'b> {
    /// A tracker that has seen nothing yet.
    #[must_use]
    pub fn new(estimator: Estimator<'m>, sensor: ProfileSensor<'b>) -> Self {
        Self { estimator, sensor, memory: Memory::default(), now: None, stale: 0, silent: None }
    }

    /// Takes one payload. Every turn that it leads to goes to `turn`, with the full field if that
    /// is fresh: one for each frame that is missing before it, then its own. `source` gives the motion of the glass at the
    /// instant of each turn; [`InputSource::tracked`] where the camera alone knows it.
    pub fn accept<C: Clock>(
        &mut self,
        stream: Stream,
        payload: &[u8],
        source: impl Fn(Micros) -> InputSource,
        clock: &mut C,
        field: &mut [f32],
        mut turn: impl FnMut(&Turn, &[f32]),
    ) {
        let Some(observation) = self.sensor.accept(stream, payload, clock) else { return };
        let time = observation.stamp.captured;
        if self.is_now(time)
            && let Some(silent) = self.silent.take()
        {
            self.catch_up(silent, &observation, clock);
            return;
        }
        let Some(missing) = self.missing_before(time) else { return };
        self.silent = None;
        // Beyond the limit the estimate has halted, and one more turn changes nothing.
        for ago in (1..=missing.min(u64::from(COAST_LIMIT) + 1)).rev() {
            count(&mut self.memory.health.frames_missing);
            let time = Micros(time.0.saturating_sub(ago.saturating_mul(INTERVAL_US)));
            let input = TurnInput { source: source(time), ..TurnInput::default() };
            let estimate = self.estimator.turn(&mut self.memory, input, clock, &mut []);
            turn(&Turn { time, stamp: None, profile: None, estimate }, &[]);
        }
        self.now = Some(time);
        let estimate = self.seen(&observation, source(time), clock, field);
        turn(
            &Turn { time, stamp: Some(observation.stamp), profile: Some(observation.profile), estimate },
            field,
        );
    }

    /// Takes a turn without a frame: call it when an interval has passed in silence. Before the
    /// first frame there is nothing to predict, and `None` comes back. `source` is that of [`Self::accept`].
    pub fn silence<C: Clock>(
        &mut self,
        source: impl Fn(Micros) -> InputSource,
        clock: &mut C,
        field: &mut [f32],
    ) -> Option<Turn> {
        let time = Micros(self.now?.0.saturating_add(INTERVAL_US));
        self.now = Some(time);
        let source = source(time);
        self.silent = Some(SilentTurn { before: self.memory.clone(), source });
        count(&mut self.memory.health.frames_missing);
        let input = TurnInput { source, ..TurnInput::default() };
        let estimate = self.estimator.turn(&mut self.memory, input, clock, field);
        Some(Turn { time, stamp: None, profile: None, estimate })
    }

    /// Whether the turn of `time` is the newest one.
    fn is_now(&self, time: Micros) -> bool {
        self.now.is_some_and(|now| now.0.abs_diff(time.0) <= INTERVAL_US / 2)
    }

    /// Takes a turn in silence again, with the frame that came late. It is not handed on: one turn of this instant was. What that
    /// one counted stays counted.
    fn catch_up<C: Clock>(&mut self, silent: SilentTurn, observation: &FrameObservation, clock: &mut C) {
        count(&mut self.memory.health.frames_stale);
        count(&mut self.memory.health.frames_caught_up);
        let handed_on = self.memory.health;
        self.memory = silent.before;
        self.memory.health = handed_on;
        (self.now, self.stale) = (Some(observation.stamp.captured), 0);
        self.seen(observation, silent.source, clock, &mut []);
        let again = self.memory.health;
        self.memory.health = Health {
            turns: handed_on.turns,
            tracking: handed_on.tracking,
            coasting: handed_on.coasting,
            halted: handed_on.halted,
            filling: handed_on.filling,
            deadline_missed: handed_on.deadline_missed,
            ..again
        };
    }

    /// Frame intervals without a turn before `time`; `None` if its turn has been taken already.
    fn missing_before(&mut self, time: Micros) -> Option<u64> {
        let Some(now) = self.now else { return Some(0) };
        let intervals = time.since(now).saturating_add(INTERVAL_US / 2) / INTERVAL_US;
        if intervals >= 1 {
            self.stale = 0;
            return intervals.checked_sub(1);
        }
        count(&mut self.memory.health.frames_stale);
        self.stale = self.stale.saturating_add(1);
        if self.stale <= STALE_LIMIT {
            return None;
        }
        self.stale = 0;
        Some(0)
    }

    /// The turn of a frame.
    fn seen<C: Clock>(
        &mut self,
        observation: &FrameObservation,
        source: InputSource,
        clock: &mut C,
        field: &mut [f32],
    ) -> Estimate {
        if observation.profile.is_err() {
            count(&mut self.memory.health.not_seen);
        }
        let profile = observation.profile.as_ref().ok();
        let input = TurnInput { profile, source, surface_us: observation.surface_us };
        self.estimator.turn(&mut self.memory, input, clock, field)
    }
}
