//! Depth and outline of one instant, paired by their time; the newest wins, no frame is used twice.
//!
//! The two streams have counters of their own, which may differ by a constant; the time is the key.
//! Frames stay in the caller's buffers, only stamps are handled here.

use crate::usb::frame::Stamp;
use serde::{Deserialize, Serialize};

/// Image stream of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// Z16.
    Depth,
    /// The image in which the outline is traced: Y8 of the left infrared imager, or YUY2 of the colour imager.
    Outline,
}

/// Two frames of one exposure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair {
    /// Stamp of the depth frame.
    pub depth: Stamp,
    /// Stamp of the outline's frame.
    pub outline: Stamp,
}

/// Counters of frames whose partner never came.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Solitary {
    /// Depth frames without a frame of the outline.
    pub depth: u32,
    /// Frames of the outline, infrared or colour, without a depth frame.
    pub infrared: u32,
}

/// Waits for partners.
///
/// ```
/// use meniscus::units::Micros;
/// use meniscus::usb::frame::Stamp;
/// use meniscus::usb::uvc::{Pairer, Stream};
///
/// let stamp = |sequence, us| Stamp { sequence, captured: Micros(us) };
/// let mut pairer = Pairer::new(16_667);
/// assert_eq!(pairer.offer(Stream::Depth, stamp(1, 1_000)), None);
/// let pair = pairer.offer(Stream::Outline, stamp(7, 1_200)).unwrap();
/// assert_eq!((pair.depth.sequence, pair.outline.sequence), (1, 7));
///
/// // The partner of depth frame 2 is lost.
/// pairer.offer(Stream::Depth, stamp(2, 17_667));
/// pairer.offer(Stream::Depth, stamp(3, 34_334));
/// assert_eq!(pairer.solitary().depth, 1);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Pairer {
    tolerance_us: u64,
    waiting: Option<(Stream, Stamp)>,
    solitary: Solitary,
}

impl Pairer {
    /// Frames pair when their times differ by less than half of `interval_us`, the frame interval.
    #[must_use]
    pub fn new(interval_us: u32) -> Self {
        Self { tolerance_us: u64::from(interval_us / 2), waiting: None, solitary: Solitary::default() }
    }

    /// Counters so far.
    #[must_use]
    pub fn solitary(&self) -> Solitary {
        self.solitary
    }

    /// Takes the next frame of either stream; gives a pair if its partner is waiting. The frame that
    /// waits is always the newest one, so one kept buffer a stream is enough.
    pub fn offer(&mut self, stream: Stream, stamp: Stamp) -> Option<Pair> {
        let Some((other, waiting)) = self.waiting else {
            self.waiting = Some((stream, stamp));
            return None;
        };
        let apart_us = stamp.captured.0.abs_diff(waiting.captured.0);
        if other != stream && apart_us <= self.tolerance_us {
            self.waiting = None;
            return Some(match stream {
                Stream::Depth => Pair { depth: stamp, outline: waiting },
                Stream::Outline => Pair { depth: waiting, outline: stamp },
            });
        }
        // The older of the two can have no partner any more: both streams only move forward.
        let alone = if stamp.captured >= waiting.captured {
            self.waiting = Some((stream, stamp));
            other
        } else {
            stream
        };
        let counter = match alone {
            Stream::Depth => &mut self.solitary.depth,
            Stream::Outline => &mut self.solitary.infrared,
        };
        *counter = counter.saturating_add(1);
        None
    }
}
