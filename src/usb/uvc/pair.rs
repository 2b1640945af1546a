//! Depth and outline of one instant, paired by their time; no frame is used twice.
//!
//! The two streams have counters of their own, which may differ by a constant; the time is the key.
//! Frames stay in the caller's buffers, only stamps are handled here.

use crate::usb::frame::Stamp;
use serde::{Deserialize, Serialize};

/// Largest number of frames of a stream that wait.
const MOST_WAITING: usize = 2;

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
/// let mut pairer = Pairer::new(16_667, 1);
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
    room: usize,
    /// Frames of each stream that wait, the oldest first; depth, then outline.
    waiting: [Waiting; 2],
    solitary: Solitary,
}

/// Frames of one stream that wait.
type Waiting = [Option<Stamp>; MOST_WAITING];

impl Pairer {
    /// Frames pair when their times differ by less than half of `interval_us`, the frame interval. Up to `room` frames of a
    /// stream wait, 1 or 2: as many as buffers are kept of it. With 2, a stream may come after the other's next frame.
    #[must_use]
    pub fn new(interval_us: u32, room: usize) -> Self {
        Self {
            tolerance_us: u64::from(interval_us / 2),
            room: room.clamp(1, MOST_WAITING),
            waiting: [[None; MOST_WAITING]; 2],
            solitary: Solitary::default(),
        }
    }

    /// Counters so far.
    #[must_use]
    pub fn solitary(&self) -> Solitary {
        self.solitary
    }

    /// Takes the next frame of either stream; gives a pair if its partner is waiting. What is older than a pair, or older than
    /// any frame of the other stream that can still come, waits no longer.
    pub fn offer(&mut self, stream: Stream, stamp: Stamp) -> Option<Pair> {
        let [depth, outline] = &mut self.waiting;
        let (own, others) = match stream {
            Stream::Depth => (depth, outline),
            Stream::Outline => (outline, depth),
        };
        let tolerance_us = self.tolerance_us;
        let near = |other: &Stamp| other.captured.0.abs_diff(stamp.captured.0) <= tolerance_us;
        let partner = others.iter().flatten().copied().find(near);
        // Both streams only move forward: nothing that comes fits to what is older. The partner itself goes with the older ones.
        let others_end_us = match partner {
            Some(partner) => partner.captured.0.saturating_add(1),
            None => stamp.captured.0.saturating_sub(tolerance_us),
        };
        let gone = drop_before(others, others_end_us);
        let (others_alone, alone) = if partner.is_some() {
            (gone.saturating_sub(1), drop_before(own, u64::MAX))
        } else if others.iter().any(Option::is_some) {
            // The other stream is ahead, and what fitted has gone.
            (gone, 1)
        } else {
            (gone, wait(own, self.room, stamp))
        };
        let (depth_alone, outline_alone) = match stream {
            Stream::Depth => (alone, others_alone),
            Stream::Outline => (others_alone, alone),
        };
        self.solitary.depth = self.solitary.depth.saturating_add(depth_alone);
        self.solitary.infrared = self.solitary.infrared.saturating_add(outline_alone);
        let partner = partner?;
        Some(match stream {
            Stream::Depth => Pair { depth: stamp, outline: partner },
            Stream::Outline => Pair { depth: partner, outline: stamp },
        })
    }
}

/// Lets `stamp` wait behind the others, of which up to `room` may; returns how many waited in vain.
fn wait(waiting: &mut Waiting, room: usize, stamp: Stamp) -> u32 {
    let [first, second] = waiting;
    match (*first, *second) {
        (None, _) => *first = Some(stamp),
        (Some(_), None) if room > 1 => *second = Some(stamp),
        (Some(_), None) => {
            *first = Some(stamp);
            return 1;
        }
        (Some(_), Some(newer)) => {
            (*first, *second) = (Some(newer), Some(stamp));
            return 1;
        }
    }
    0
}

/// Takes out what was captured before `end_us`; returns how many there were.
fn drop_before(waiting: &mut Waiting, end_us: u64) -> u32 {
    let before = |stamp: &Option<Stamp>| stamp.is_some_and(|stamp| stamp.captured.0 < end_us);
    let [first, second] = waiting;
    match (before(first), before(second)) {
        (_, true) => {
            let gone = u32::from(first.is_some()) + 1;
            (*first, *second) = (None, None);
            gone
        }
        (true, false) => {
            (*first, *second) = (second.take(), None);
            1
        }
        (false, false) => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Micros;

    const INTERVAL_US: u32 = 16_667;

    /// Frame `n` of `stream`, taken `late_us` after its instant.
    fn frame(n: u64, late_us: u64) -> Stamp {
        Stamp { sequence: n as u32, captured: Micros(n * u64::from(INTERVAL_US) + late_us) }
    }

    /// The pairs of frames that come in `order`, as their numbers.
    fn pairs(pairer: &mut Pairer, order: &[(Stream, u64)]) -> [Option<(u32, u32)>; 64] {
        let mut found = [None; 64];
        for (place, (stream, n)) in found.iter_mut().zip(order) {
            let pair = pairer.offer(*stream, frame(*n, if *stream == Stream::Outline { 300 } else { 0 }));
            *place = pair.map(|pair| (pair.depth.sequence, pair.outline.sequence));
        }
        found
    }

    #[test]
    fn a_stream_that_always_comes_after_the_others_next_frame_pairs_where_two_frames_wait() {
        use Stream::{Depth, Outline};
        for [early, late] in [[Depth, Outline], [Outline, Depth]] {
            let mut pairer = Pairer::new(INTERVAL_US, 2);
            let order = [(early, 1), (early, 2), (late, 1), (early, 3), (late, 2), (early, 4), (late, 3)];
            let found = pairs(&mut pairer, &order);
            assert_eq!([found[2], found[4], found[6]], [1, 2, 3].map(|n| Some((n, n))));
            assert_eq!(pairer.solitary(), Solitary::default());
            // With room for one it never does: what it has no buffer for, it does not pair.
            let mut narrow = Pairer::new(INTERVAL_US, 1);
            assert!(pairs(&mut narrow, &order).iter().all(Option::is_none));
            assert!(narrow.solitary().depth > 0 && narrow.solitary().infrared > 0);
        }
    }

    #[test]
    fn every_frame_pairs_or_is_counted_whatever_is_lost() {
        for room in [1, 2] {
            // Each bit of the mask loses one of ten frames, depth and outline in turn.
            for mask in 0_u32..1 << 10 {
                let mut pairer = Pairer::new(INTERVAL_US, room);
                let (mut offered, mut paired) = (0, 0);
                for k in 0..10 {
                    if mask & (1 << k) == 0 {
                        let stream = if k % 2 == 0 { Stream::Depth } else { Stream::Outline };
                        offered += 1;
                        if let Some(pair) = pairer.offer(stream, frame(k / 2, 0)) {
                            assert_eq!(pair.depth.sequence, pair.outline.sequence, "{mask:b}");
                            paired += 1;
                        }
                    }
                }
                let whole = (0..5).filter(|n| mask >> (2 * n) & 3 == 0).count();
                assert_eq!(paired, whole, "{mask:b}");
                // The last ones still wait.
                let Solitary { depth, infrared } = pairer.solitary();
                let left = offered - 2 * paired as u32 - depth - infrared;
                assert!(left <= room as u32, "{mask:b}: {left} of {offered} are nowhere");
            }
        }
    }
}
