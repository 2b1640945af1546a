//! The eye: payloads of two streams in, one profile an instant out.

use super::budget::Clock;
use crate::frame::{DepthFrame, InfraredFrame, Stamp};
use crate::surface::{self, NotSeen, SurfaceProfile, extract};
use crate::uvc::{Assembler, Losses, Outcome, Pairer, Solitary, Stream};

/// The camera's frame interval, microseconds.
const INTERVAL_US: u32 = 16_667;

/// What the eye saw at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Stamp of the depth frame.
    pub stamp: Stamp,
    /// The profile, or why there is none.
    pub profile: Result<SurfaceProfile, NotSeen>,
    /// Time from whole images to profile, microseconds.
    pub surface_us: u64,
}

/// Assembles, pairs and extracts; buffers are the caller's.
#[derive(Debug)]
pub struct Eye<'b> {
    config: surface::Config,
    depth: Assembler<'b>,
    infrared: Assembler<'b>,
    pairer: Pairer,
    state: surface::State,
}

impl<'b> Eye<'b> {
    /// An eye whose frames have exactly the lengths of the buffers (two bytes a depth pixel).
    #[must_use]
    pub fn new(config: surface::Config, depth: &'b mut [u8], infrared: &'b mut [u8]) -> Self {
        Self {
            config,
            depth: Assembler::new(depth),
            infrared: Assembler::new(infrared),
            pairer: Pairer::new(INTERVAL_US),
            state: surface::State::new(),
        }
    }

    /// What was lost on the way, depth then infrared.
    #[must_use]
    pub fn losses(&self) -> (Losses, Losses) {
        (self.depth.losses(), self.infrared.losses())
    }

    /// Frames whose partner never came.
    #[must_use]
    pub fn solitary(&self) -> Solitary {
        self.pairer.solitary()
    }

    /// The last whole infrared image.
    #[must_use]
    pub fn infrared(&self) -> &[u8] {
        self.infrared.pixels()
    }

    /// Takes one payload; gives what was seen if it completes a pair of images.
    pub fn accept<C: Clock>(&mut self, stream: Stream, payload: &[u8], clock: &mut C) -> Option<Sight> {
        let assembler = match stream {
            Stream::Depth => &mut self.depth,
            Stream::Infrared => &mut self.infrared,
        };
        let Outcome::Frame(frame) = assembler.push(payload) else { return None };
        let pair = self.pairer.offer(stream, frame.stamp)?;
        let start_us = clock.now_us();
        let (width, height) = self.config.image_size();
        let depth = DepthFrame { bytes: self.depth.pixels(), width, height, stamp: pair.depth };
        let infrared = InfraredFrame { bytes: self.infrared.pixels(), width, height, stamp: pair.infrared };
        let profile = extract(&self.config, &mut self.state, depth, infrared);
        let surface_us = clock.now_us().saturating_sub(start_us);
        Some(Sight { stamp: pair.depth, profile, surface_us })
    }
}
