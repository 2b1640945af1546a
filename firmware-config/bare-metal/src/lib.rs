//! The job of the board: recorded payloads in, a line for each turn out, the same code on the emulated
//! Cortex-M7 (`bin/board.rs`) and on the host (`bin/twin.rs`).
//!
//! A line holds checksums of everything that leaves the camera side: the postcard packet of the turn and the
//! bits of the full field. The board's lines and the twin's have to be the same.
//!
//! The payload file: for each payload its stream (0 depth, 1 infrared) and its length, little-endian 32 bits
//! each, then its bytes.
#![no_std]

use core::fmt::{self, Write};
use core::marker::PhantomData;
use crc::{CRC_64_XZ, Crc};
use meniscus::blob::{Model, Variant};
use meniscus::runtime::output::{OUTPUT_MAX, Packet};
use meniscus::runtime::{Clock, Estimator, InputSource, Mode, ProfileSensor, Stages, Tracker, Turn};
use meniscus::surface::{Config, Intrinsics, Settings};
use meniscus::usb::uvc::Stream;

/// Variant of the estimator.
pub const VARIANT: Variant = if cfg!(feature = "small") { Variant::Small } else { Variant::Full };

/// Pixels of an image.
pub const PIXELS: usize = 640 * 480;
/// Room for a payload of a depth image with its header and a fault's excess.
pub const PAYLOAD: usize = 2 * PIXELS + 8192;
/// Room for the full field of the shipped model.
pub const FIELD: usize = 65_536;

/// Interface of the job to the machine that it runs on.
pub trait Place {
    /// Fills `into` from the payload file; `false` at its end.
    fn read(&mut self, into: &mut [u8]) -> bool;
    /// Writes a line.
    fn line(&mut self, line: fmt::Arguments<'_>);
    /// Instructions so far, or 0 where they are not counted.
    fn instructions() -> u64;
}

/// The buffers of the camera side, as a board would place them.
#[derive(Debug)]
pub struct Room {
    /// Z16 pixels.
    pub depth: [u8; 2 * PIXELS],
    /// Y8 pixels.
    pub infrared: [u8; PIXELS],
    /// One payload.
    pub payload: [u8; PAYLOAD],
    /// The full field.
    pub field: [f32; FIELD],
}

impl Room {
    /// Empty buffers.
    #[must_use]
    pub const fn new() -> Self {
        Self { depth: [0; 2 * PIXELS], infrared: [0; PIXELS], payload: [0; PAYLOAD], field: [0.0; FIELD] }
    }
}

impl Default for Room {
    fn default() -> Self {
        Self::new()
    }
}

/// Instructions in place of time: a stage's "microseconds" are its instructions. The packets hold none of them.
struct Counter<P>(PhantomData<P>);

impl<P: Place> Clock for Counter<P> {
    fn now_us(&mut self) -> u64 {
        P::instructions()
    }
}

/// Why the job cannot be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobError {
    /// The blob is refused.
    Model,
    /// The camera cannot see the model's glass.
    Glass,
    /// The field does not fit into its buffer.
    Field,
    /// A payload's head is damaged.
    Payload,
}

/// Result of the job.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Done {
    /// Turns.
    pub turns: u32,
    /// Turns that used a measurement.
    pub tracked: u32,
    /// Instructions of all payloads.
    pub all: u64,
    /// Instructions of the payloads that complete a frame.
    pub completing: u64,
    /// Instructions of the longest of these.
    pub longest: u64,
    /// Frames of one turn that used them.
    pub frames: u32,
    /// Instructions of these frames, every payload included.
    pub tracking: u64,
    /// Instructions of the stages of the turns that used a measurement.
    pub stages: Stages,
}

impl Done {
    fn count(&mut self, turn: &Turn) {
        if turn.estimate.mode != Mode::Tracking {
            return;
        }
        self.tracked += 1;
        let (sum, one) = (&mut self.stages, &turn.estimate.stages);
        sum.surface_us += one.surface_us;
        sum.predict_us += one.predict_us;
        sum.encode_us += one.encode_us;
        sum.correct_us += one.correct_us;
        sum.field_us += one.field_us;
    }
}

/// Runs the camera side over all payloads.
///
/// # Errors
/// [`JobError`].
pub fn run<P: Place>(place: &mut P, blob: &[u8], room: &mut Room) -> Result<Done, JobError> {
    // By reference: a second copy of the model would take as much of the stack again.
    let mut loaded = Model::load(blob);
    let model = loaded.as_mut().map_err(|_| JobError::Model)?;
    model.header.variant = VARIANT;
    turns(place, model, room)
}

/// The turns of `model`. Its memory has a frame of its own, because the model takes as much of the stack while it is loaded, and
/// both at once would not fit.
#[inline(never)]
fn turns<P: Place>(place: &mut P, model: &Model<'_>, room: &mut Room) -> Result<Done, JobError> {
    let header = &model.header;
    // The clock counts instructions, and no turn is late for them.
    let estimator = Estimator::new(model).within(u64::MAX);
    // The intrinsics of the simulated camera, and the depth unit that a session asks for.
    let intrinsics = Intrinsics { width: 640, height: 480, fx: 384.21, fy: 384.21, ppx: 319.48, ppy: 236.35 };
    let config = Config::new(Settings {
        intrinsics,
        depth_unit_m: 1e-4,
        radius_m: header.radius_m as f32,
        fill_m: header.fill_m as f32,
        rim_m: header.rim_m as f32,
        ..Settings::default()
    })
    .map_err(|_| JobError::Glass)?;
    let field = room.field.get_mut(..estimator.field_len()).ok_or(JobError::Field)?;
    let sensor = ProfileSensor::new(config, &mut room.depth, &mut room.infrared);
    let mut tracker = Tracker::new(estimator, sensor);
    let (mut done, mut frame) = (Done::default(), 0);
    let mut head = [0; 8];
    while place.read(&mut head) {
        let (words, _) = head.as_chunks::<4>();
        let word = |at: usize| words.get(at).map_or(0, |word| u32::from_le_bytes(*word));
        let stream = if word(0) == 0 { Stream::Depth } else { Stream::Outline };
        let payload = room.payload.get_mut(..word(1) as usize).ok_or(JobError::Payload)?;
        if !place.read(payload) {
            return Err(JobError::Payload);
        }
        let before = P::instructions();
        // What the report costs is no part of the turn.
        let (turns, mut reporting, mut tracking) = (done.turns, 0, false);
        let count = &mut Counter::<P>(PhantomData);
        tracker.accept(stream, payload, InputSource::tracked, count, field, |turn, field| {
            let before = P::instructions();
            done.turns += 1;
            tracking = turn.estimate.mode == Mode::Tracking;
            done.count(turn);
            let mut packet = Packet::of(turn, u64::from(done.turns), header);
            packet.estimate.stages = Stages::default();
            tell(place, done.turns, &packet, field);
            reporting += P::instructions().saturating_sub(before);
        });
        let spent = P::instructions().saturating_sub(before).saturating_sub(reporting);
        done.all += spent;
        frame += spent;
        if done.turns > turns {
            if done.turns == turns + 1 && tracking {
                done.tracking += frame;
                done.frames += 1;
            }
            frame = 0;
            done.completing += spent;
            done.longest = done.longest.max(spent);
        }
    }
    let (depth, infrared) = tracker.sensor.losses();
    let health = &tracker.memory.health;
    place.line(format_args!("health {health:?}"));
    place.line(format_args!("lost {} depth, {} infrared", depth.frames(), infrared.frames()));
    Ok(done)
}

/// The line of a turn.
fn tell(place: &mut impl Place, number: u32, packet: &Packet, field: &[f32]) {
    const CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);
    let mut buffer = [0; OUTPUT_MAX];
    let crc = packet.write(&mut buffer).map_or(0, |bytes| CRC.checksum(bytes));
    let mut bits = CRC.digest();
    field.iter().for_each(|value| bits.update(&value.to_le_bytes()));
    let mode = packet.estimate.mode;
    place.line(format_args!("turn {number} {mode:?} packet {crc:016x} field {:016x}", bits.finalize()));
}

/// A line in memory that is there already; what does not fit is cut.
#[derive(Debug)]
pub struct Line {
    bytes: [u8; 1024],
    length: usize,
}

impl Line {
    /// The line that `arguments` make.
    #[must_use]
    pub fn of(arguments: fmt::Arguments<'_>) -> Self {
        let mut line = Self { bytes: [0; 1024], length: 0 };
        // Cut at its room.
        let _cut = line.write_fmt(arguments);
        line
    }

    /// Its bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&[])
    }
}

impl Write for Line {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let left = self.bytes.get_mut(self.length..).ok_or(fmt::Error)?;
        let taken = text.len().min(left.len());
        left.iter_mut().zip(text.as_bytes()).for_each(|(to, from)| *to = *from);
        self.length += taken;
        if taken == text.len() { Ok(()) } else { Err(fmt::Error) }
    }
}
