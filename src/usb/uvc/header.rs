//! The payload header: a view over bytes whose lengths were checked once, then meaning without `Result`.
//!
//! | byte | field |
//! |---|---|
//! | 0 | header length, metadata included |
//! | 1 | flags: 0 FID, 1 EOF, 2 PTS present, 3 SCR present, 5 STI, 6 ERR, 7 EOH |
//! | 2..6 | PTS, microseconds of the device clock, if present |
//! | next 6 | SCR: clock (4 bytes) and bus frame number (11 bits), if present |
//! | rest | metadata blocks |
//!
//! Source: USB Video Class 1.5, section 2.4.3.3.

use super::bytes::{u16_at, u32_at};
use super::metadata::Blocks;

/// Header length and flags, the part that every payload must have.
const FIXED: usize = 2;
/// Bytes of the presentation time stamp.
const PTS: usize = 4;
/// Bytes of the source clock reference.
const SCR: usize = 6;

const FID: u8 = 1;
const EOF: u8 = 1 << 1;
const HAS_PTS: u8 = 1 << 2;
const HAS_SCR: u8 = 1 << 3;
const STI: u8 = 1 << 5;
const ERR: u8 = 1 << 6;
const EOH: u8 = 1 << 7;

/// Fault of a payload header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeaderError {
    /// The transfer brought no byte at all.
    Empty,
    /// The header says `length` bytes, fewer than the `needed` ones for the fields that its flags announce.
    TooShort {
        /// Length in byte 0.
        length: usize,
        /// Length that the flags need.
        needed: usize,
    },
    /// The header says `length` bytes, but the whole payload has only `payload`.
    BeyondPayload {
        /// Length in byte 0.
        length: usize,
        /// Length of the payload.
        payload: usize,
    },
}

impl core::fmt::Display for HeaderError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Empty => write!(f, "the payload is empty"),
            Self::TooShort { length, needed } => {
                write!(f, "the payload header says {length} bytes, its flags need {needed}")
            }
            Self::BeyondPayload { length, payload } => {
                write!(f, "the payload header says {length} bytes, the payload has {payload}")
            }
        }
    }
}

impl core::error::Error for HeaderError {}

/// A checked payload header; it exists only if every field that its flags announce lies inside it.
#[derive(Clone, Copy, Debug)]
pub struct PayloadHeader<'a> {
    flags: u8,
    pts: Option<u32>,
    source_clock: Option<(u32, u16)>,
    metadata: &'a [u8],
}

impl<'a> PayloadHeader<'a> {
    /// Splits a payload into its header and its pixels.
    ///
    /// ```
    /// use meniscus::usb::uvc::{PayloadHeader, HeaderError};
    ///
    /// // Length 6, flags PTS | EOF, PTS = 1000 us, two pixels.
    /// let (header, pixels) = PayloadHeader::split(&[6, 0b110, 0xe8, 3, 0, 0, 7, 8])?;
    /// assert_eq!((header.pts(), header.end_of_frame(), pixels), (Some(1000), true, &[7, 8][..]));
    ///
    /// let refused = PayloadHeader::split(&[2, 0b100]).map(|_| ());
    /// assert_eq!(refused, Err(HeaderError::TooShort { length: 2, needed: 6 }));
    /// # Ok::<(), HeaderError>(())
    /// ```
    ///
    /// # Errors
    /// [`HeaderError`] when the header length contradicts its flags or the payload.
    pub fn split(payload: &'a [u8]) -> Result<(Self, &'a [u8]), HeaderError> {
        let length = usize::from(*payload.first().ok_or(HeaderError::Empty)?);
        let flags = payload.get(1).copied().unwrap_or(0);
        let pts_bytes = if flags & HAS_PTS != 0 { PTS } else { 0 };
        let scr_bytes = if flags & HAS_SCR != 0 { SCR } else { 0 };
        let needed = FIXED + pts_bytes + scr_bytes;
        if length < needed {
            return Err(HeaderError::TooShort { length, needed });
        }
        let beyond = HeaderError::BeyondPayload { length, payload: payload.len() };
        let (header, pixels) = payload.split_at_checked(length).ok_or(beyond)?;
        // `needed <= length`, so neither of the two `get` can miss.
        let pts = header.get(FIXED..FIXED + pts_bytes).and_then(|bytes| u32_at(bytes, 0));
        let scr = header.get(FIXED + pts_bytes..needed).unwrap_or(&[]);
        let source_clock = u32_at(scr, 0).zip(u16_at(scr, 4));
        let metadata = header.get(needed..).unwrap_or(&[]);
        Ok((Self { flags, pts, source_clock, metadata }, pixels))
    }

    /// Frame identifier: toggles from frame to frame, the same in all payloads of one frame.
    #[must_use]
    pub fn frame_id(&self) -> bool {
        self.flags & FID != 0
    }

    /// This payload ends its frame.
    #[must_use]
    pub fn end_of_frame(&self) -> bool {
        self.flags & EOF != 0
    }

    /// The payload belongs to a still image.
    #[must_use]
    pub fn still_image(&self) -> bool {
        self.flags & STI != 0
    }

    /// The camera says that the frame is damaged.
    #[must_use]
    pub fn error(&self) -> bool {
        self.flags & ERR != 0
    }

    /// The header ends here, no second one follows.
    #[must_use]
    pub fn end_of_header(&self) -> bool {
        self.flags & EOH != 0
    }

    /// Presentation time stamp, microseconds of the camera's clock modulo 2^32.
    #[must_use]
    pub fn pts(&self) -> Option<u32> {
        self.pts
    }

    /// Source clock reference: the camera's clock, and the 11-bit number of the bus frame.
    #[must_use]
    pub fn source_clock(&self) -> Option<(u32, u16)> {
        self.source_clock.map(|(clock, bus_frame)| (clock, bus_frame & 0x07ff))
    }

    /// The metadata blocks behind the standard fields.
    #[must_use]
    pub fn blocks(&self) -> Blocks<'a> {
        Blocks::new(self.metadata)
    }
}
