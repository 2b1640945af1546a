//! Payloads to frames: one payload a frame is the D400's rule, several are joined by their
//! frame identifier and time.
//!
//! A frame comes out only with exactly the expected number of pixel bytes. Everything else is booked
//! in [`Losses`] under its cause. A full frame that lacks the end-of-frame bit, or repeats the frame
//! identifier although its time is new, is whole all the same: it comes out, and the oddity is booked.

use super::continuity::Continuity;
use super::device_clock::DeviceClock;
use super::header::PayloadHeader;
use super::losses::{Cause, Losses};
use super::places::Places;
use crate::usb::frame::Stamp;

/// A whole frame, its pixels in place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Exactly the expected number of bytes.
    pub pixels: &'a [u8],
    /// Frame counter and mid-exposure time.
    pub stamp: Stamp,
}

/// Result of one payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AssemblyOutcome<'a> {
    /// More payloads of this frame are to come.
    Partial,
    /// The frame is whole.
    Frame(Frame<'a>),
    /// A frame was lost; it is booked.
    Lost(Cause),
}

/// A frame that has begun: its identifier and time, and its stamp unless it is lost already.
#[derive(Clone, Copy, Debug)]
struct Open {
    fid: bool,
    pts: Option<u32>,
    stamp: Option<Stamp>,
    filled: usize,
}

impl Open {
    fn new(header: &PayloadHeader<'_>, stamp: Option<Stamp>) -> Self {
        Self { fid: header.frame_id(), pts: header.pts(), stamp, filled: 0 }
    }

    /// Returns whether a payload belongs to this frame. All payloads of a frame carry the same time; without
    /// that, the frame after the next one, which has the same identifier, could be taken for the rest.
    fn goes_on(&self, header: &PayloadHeader<'_>) -> bool {
        self.fid == header.frame_id() && (self.pts == header.pts() || header.pts().is_none())
    }
}

/// Joins the payloads of one stream in a buffer of the caller's.
///
/// ```
/// use meniscus::usb::uvc::{Assembler, AssemblyOutcome, DeviceClock};
///
/// let mut buffer = [0; 4];
/// let (mut assembler, mut clock) = (Assembler::new(&mut buffer), DeviceClock::default());
/// // Length 6, flags PTS | EOF, PTS = 1000 us, four pixels.
/// let payload = [6, 0b110, 0xe8, 3, 0, 0, 1, 2, 3, 4];
/// assert!(matches!(assembler.push(&payload, &mut clock), AssemblyOutcome::Frame(frame) if frame.pixels == [1, 2, 3, 4]));
/// assert!(matches!(assembler.push(&payload[..9], &mut clock), AssemblyOutcome::Lost(_)));
/// ```
#[derive(Debug)]
pub struct Assembler<'b> {
    places: Places<'b>,
    open: Option<Open>,
    continuity: Continuity,
    losses: Losses,
}

impl<'b> Assembler<'b> {
    /// An assembler of frames of exactly `buffer.len()` bytes.
    #[must_use]
    pub fn new(buffer: &'b mut [u8]) -> Self {
        Self::into(Places::one(buffer))
    }

    /// An assembler of frames of half of `buffer`: the last two are kept.
    #[must_use]
    pub fn keeping_two(buffer: &'b mut [u8]) -> Self {
        Self::into(Places::two(buffer))
    }

    fn into(places: Places<'b>) -> Self {
        Self { places, open: None, continuity: Continuity::default(), losses: Losses::default() }
    }

    /// Number of frames that are kept.
    #[must_use]
    pub fn kept(&self) -> usize {
        self.places.count()
    }

    /// The books so far.
    #[must_use]
    pub fn losses(&self) -> Losses {
        self.losses
    }

    /// The pixels of the last frame that [`push`](Self::push) gave, until the next payload.
    #[must_use]
    pub fn pixels(&self) -> &[u8] {
        self.places.last()
    }

    /// The pixels of the frame of `stamp`, while it is kept.
    #[must_use]
    pub fn pixels_of(&self, stamp: Stamp) -> Option<&[u8]> {
        self.places.of(stamp)
    }

    /// Takes the next payload and copies its pixels behind those of its frame; `clock` is that of all streams of the camera. If it
    /// also shows that an earlier frame never ended, that loss is booked and the outcome speaks of this payload.
    pub fn push(&mut self, payload: &[u8], clock: &mut DeviceClock) -> AssemblyOutcome<'_> {
        let (header, pixels) = match self.read(payload) {
            Ok(parts) => parts,
            Err(cause) => return AssemblyOutcome::Lost(cause),
        };
        let mut open = match self.open.take() {
            Some(open) if open.goes_on(&header) => open,
            unended => {
                if unended.is_some_and(|open| open.stamp.is_some()) {
                    self.losses.book(Cause::FrameUnended);
                }
                match self.begin(&header, clock) {
                    Ok(stamp) => {
                        self.places.begin();
                        Open::new(&header, Some(stamp))
                    }
                    Err(cause) => return self.refuse(&header, cause),
                }
            }
        };
        let Some(stamp) = open.stamp else {
            // The rest of a frame that is booked as lost.
            self.open = Some(open).filter(|_| !header.end_of_frame());
            return AssemblyOutcome::Partial;
        };
        if header.error() {
            return self.refuse(&header, Cause::ErrorBit);
        }
        let end = open.filled.saturating_add(pixels.len());
        let Some(place) = self.places.room().get_mut(open.filled..end) else {
            return self.refuse(&header, Cause::OverlongFrame);
        };
        copy(place, pixels);
        open.filled = end;
        if end == self.places.bytes() {
            self.remark_eof(&header);
            self.places.keep(stamp);
            return AssemblyOutcome::Frame(Frame { pixels: self.places.last(), stamp });
        }
        if header.end_of_frame() {
            self.losses.book(Cause::ShortFrame);
            return AssemblyOutcome::Lost(Cause::ShortFrame);
        }
        self.open = Some(open);
        AssemblyOutcome::Partial
    }

    /// Takes a payload that should be a whole frame, and lends its pixels where they lie, without a
    /// copy. A payload that is only a part of a frame is a short frame here.
    pub fn whole<'p>(&mut self, payload: &'p [u8], clock: &mut DeviceClock) -> AssemblyOutcome<'p> {
        let placed = self.read(payload).and_then(|(header, pixels)| {
            let stamp = self.begin(&header, clock).inspect_err(|&cause| self.losses.book(cause))?;
            Ok((header, Frame { pixels, stamp }))
        });
        let (header, frame) = match placed {
            Ok(placed) => placed,
            Err(cause) => return AssemblyOutcome::Lost(cause),
        };
        let cause = match frame.pixels.len().cmp(&self.places.bytes()) {
            _ if header.error() => Cause::ErrorBit,
            core::cmp::Ordering::Less => Cause::ShortFrame,
            core::cmp::Ordering::Greater => Cause::OverlongFrame,
            core::cmp::Ordering::Equal => {
                self.remark_eof(&header);
                return AssemblyOutcome::Frame(frame);
            }
        };
        self.losses.book(cause);
        AssemblyOutcome::Lost(cause)
    }

    /// Splits and books what cannot be split. A payload without pixels belongs to no frame, unless
    /// it carries the end or the error of one.
    fn read<'p>(&mut self, payload: &'p [u8]) -> Result<(PayloadHeader<'p>, &'p [u8]), Cause> {
        let cause = match PayloadHeader::split(payload) {
            Ok((header, pixels)) if !pixels.is_empty() || header.error() => return Ok((header, pixels)),
            Ok((header, pixels)) if header.end_of_frame() && self.open.is_some() => {
                return Ok((header, pixels));
            }
            Ok(_) if self.open.is_some() => Cause::EmptyPayload,
            Err(_) if !payload.is_empty() => {
                self.continuity.lost_unidentified();
                Cause::BadHeader
            }
            Ok(_) | Err(_) => {
                self.continuity.lost_unidentified();
                Cause::EmptyPayload
            }
        };
        self.losses.book(cause);
        Err(cause)
    }

    /// Places a new frame in the order of frames.
    fn begin(&mut self, header: &PayloadHeader<'_>, clock: &mut DeviceClock) -> Result<Stamp, Cause> {
        self.continuity.place(header, clock, &mut self.losses)
    }

    /// Books a lost frame; the rest of its payloads will be swallowed without a second count.
    fn refuse(&mut self, header: &PayloadHeader<'_>, cause: Cause) -> AssemblyOutcome<'static> {
        self.losses.book(cause);
        if !header.end_of_frame() {
            self.open = Some(Open::new(header, None));
        }
        AssemblyOutcome::Lost(cause)
    }

    fn remark_eof(&mut self, header: &PayloadHeader<'_>) {
        if !header.end_of_frame() {
            self.losses.eof_missing = self.losses.eof_missing.saturating_add(1);
        }
    }
}

/// Copies `from` to the front of `to`, in chunks: a processor without vectors takes a fifth of the instructions of single bytes,
/// and no length is compared on the way that could be wrong.
fn copy(to: &mut [u8], from: &[u8]) {
    let ((to, to_rest), (from, from_rest)) = (to.as_chunks_mut::<CHUNK>(), from.as_chunks::<CHUNK>());
    to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
    to_rest.iter_mut().zip(from_rest).for_each(|(to, from)| *to = *from);
}

/// Bytes that are copied at once.
const CHUNK: usize = 32;
