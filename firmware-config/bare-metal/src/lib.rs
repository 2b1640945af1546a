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
use crc::{CRC_64_XZ, Crc};
use meniscus::blob::Model;
use meniscus::runtime::output::{OUTPUT_MAX, Packet};
use meniscus::runtime::{Clock, Estimator, InputSource, ProfileSensor, Tracker};
use meniscus::surface::{Config, Intrinsics, Settings};
use meniscus::usb::uvc::Stream;

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
    fn instructions(&mut self) -> u64;
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

/// No time passes: what a turn costs is counted from outside, and the packets hold no time of a machine.
struct NoClock;

impl Clock for NoClock {
    fn now_us(&mut self) -> u64 {
        0
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
    /// Instructions of the turns with a frame: all together, and of the longest.
    pub instructions: (u64, u64),
}

/// Runs the camera side over all payloads.
///
/// # Errors
/// [`JobError`].
pub fn run(place: &mut impl Place, blob: &[u8], room: &mut Room) -> Result<Done, JobError> {
    // By reference: a second copy of the model would take as much of the stack again.
    let loaded = Model::load(blob);
    turns(place, loaded.as_ref().map_err(|_| JobError::Model)?, room)
}

/// The turns of `model`. Its memory has a frame of its own, because the model takes as much of the stack while it is loaded, and
/// both at once would not fit.
#[inline(never)]
fn turns(place: &mut impl Place, model: &Model<'_>, room: &mut Room) -> Result<Done, JobError> {
    let header = &model.header;
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
    let field = room.field.get_mut(..model.field_len()).ok_or(JobError::Field)?;
    let sensor = ProfileSensor::new(config, &mut room.depth, &mut room.infrared);
    let mut tracker = Tracker::new(Estimator::new(model), sensor);
    let mut done = Done::default();
    let mut head = [0; 8];
    while place.read(&mut head) {
        let (words, _) = head.as_chunks::<4>();
        let word = |at: usize| words.get(at).map_or(0, |word| u32::from_le_bytes(*word));
        let stream = if word(0) == 0 { Stream::Depth } else { Stream::Outline };
        let payload = room.payload.get_mut(..word(1) as usize).ok_or(JobError::Payload)?;
        if !place.read(payload) {
            return Err(JobError::Payload);
        }
        let before = place.instructions();
        // What the telling costs is no part of the turn.
        let (turns, mut told) = (done.turns, 0);
        tracker.accept(stream, payload, InputSource::tracked, &mut NoClock, field, |turn, field| {
            done.turns += 1;
            let before = place.instructions();
            let packet = Packet::of(turn, u64::from(done.turns), header);
            tell(place, done.turns, &packet, field);
            told += place.instructions().saturating_sub(before);
        });
        if done.turns > turns {
            let spent = place.instructions().saturating_sub(before).saturating_sub(told);
            done.instructions.0 += spent;
            done.instructions.1 = done.instructions.1.max(spent);
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
