//! Probe and commit: what the host asks of a stream, what the camera answers, and whether the two agree.
//!
//! | offset | size | field | offset | size | field |
//! |---|---|---|---|---|---|
//! | 0 | 2 | bmHint | 18 | 4 | dwMaxVideoFrameSize |
//! | 2 | 1 | bFormatIndex | 22 | 4 | dwMaxPayloadTransferSize |
//! | 3 | 1 | bFrameIndex | 26 | 4 | dwClockFrequency |
//! | 4 | 4 | dwFrameInterval, 100 ns | 30..48 | | fields of UVC 1.1 and 1.5, sent as they came |
//!
//! The record has 26 bytes in UVC 1.0, 34 in 1.1, 48 in 1.5. Source: USB Video Class 1.5, table 4-75.

use super::bytes::{put, u32_at};

/// Bytes of the longest record.
pub const PROBE_MAX: usize = 48;

/// Length of the record in a version of the class.
///
/// ```
/// use meniscus::usb::uvc::probe_length;
///
/// assert_eq!([0x0100, 0x0110, 0x0150].map(probe_length), [26, 34, 48]);
/// ```
#[must_use]
pub fn probe_length(version: u16) -> usize {
    match version {
        0x0110 => 34,
        0x0150.. => PROBE_MAX,
        _ => 26,
    }
}

/// Fault of a probe answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProbeError {
    /// The answer has a length that no version of the class has, or not that of this camera's.
    Length {
        /// Length of the answer.
        got: usize,
        /// Length in this camera's version of the class.
        wanted: usize,
    },
    /// Another format or frame index.
    Mode {
        /// Format and frame index of the answer.
        got: (u8, u8),
        /// The requested ones.
        wanted: (u8, u8),
    },
    /// Another frame interval.
    Interval {
        /// Of the answer, 100 ns.
        got: u32,
        /// Requested, 100 ns.
        wanted: u32,
    },
    /// Another frame size.
    FrameSize {
        /// dwMaxVideoFrameSize of the answer.
        got: u32,
        /// Bytes of an image of the mode.
        wanted: u32,
    },
}

impl core::fmt::Display for ProbeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Length { got, wanted } => write!(f, "the probe answer has {got} bytes instead of {wanted}"),
            Self::Mode { got, wanted } => write!(
                f,
                "the camera answers with format {} frame {} instead of format {} frame {}",
                got.0, got.1, wanted.0, wanted.1
            ),
            Self::Interval { got, wanted } => write!(
                f,
                "the camera answers with an interval of {got} x 100 ns ({} Hz) instead of {wanted} ({} Hz)",
                super::format::rate_of(*got),
                super::format::rate_of(*wanted)
            ),
            Self::FrameSize { got, wanted } => {
                write!(f, "the camera announces frames of {got} bytes instead of {wanted}")
            }
        }
    }
}

impl core::error::Error for ProbeError {}

/// The record, with the fields of later versions kept as they came.
///
/// ```
/// use meniscus::usb::uvc::{Probe, ProbeError};
///
/// // The camera offers a record; the host asks for format 1, frame 3 at 60 Hz.
/// let asked = Probe::read(&[0; 34], 34)?.ask((1, 3), 166_666);
/// let mut answer = [0; 34];
/// answer.copy_from_slice(asked.bytes());
/// answer[18..22].copy_from_slice(&614_400_u32.to_le_bytes());
/// Probe::read(&answer, 34)?.agrees(&asked, 614_400)?;
///
/// answer[3] = 4;
/// let refused = Probe::read(&answer, 34)?.agrees(&asked, 614_400);
/// assert_eq!(refused, Err(ProbeError::Mode { got: (1, 4), wanted: (1, 3) }));
/// # Ok::<(), ProbeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Probe {
    bytes: [u8; PROBE_MAX],
    length: usize,
}

impl Probe {
    /// Reads an answer.
    ///
    /// # Errors
    /// [`ProbeError::Length`] unless it has exactly `wanted` bytes, one of the three lengths.
    pub fn read(answer: &[u8], wanted: usize) -> Result<Self, ProbeError> {
        if answer.len() != wanted || !matches!(wanted, 26 | 34 | PROBE_MAX) {
            return Err(ProbeError::Length { got: answer.len(), wanted });
        }
        let mut bytes = [0; PROBE_MAX];
        put(&mut bytes, 0, answer);
        Ok(Self { bytes, length: wanted })
    }

    /// The same record asking for a mode, format and frame index: the interval is to be kept (bmHint 1), and both sizes are
    /// left to the camera.
    #[must_use]
    pub fn ask(mut self, mode: (u8, u8), interval: u32) -> Self {
        let (format, frame) = mode;
        put(&mut self.bytes, 0, &[1, 0, format, frame]);
        put(&mut self.bytes, 4, &interval.to_le_bytes());
        put(&mut self.bytes, 18, &[0; 8]);
        self
    }

    /// The record as it goes on the wire.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&[])
    }

    /// Format and frame index.
    #[must_use]
    pub fn mode(&self) -> (u8, u8) {
        let [_, _, format, frame, ..] = self.bytes;
        (format, frame)
    }

    /// Frame interval, 100 ns.
    #[must_use]
    pub fn interval(&self) -> u32 {
        u32_at(&self.bytes, 4).unwrap_or(0)
    }

    /// Bytes of a frame.
    #[must_use]
    pub fn frame_size(&self) -> u32 {
        u32_at(&self.bytes, 18).unwrap_or(0)
    }

    /// Most bytes of a transfer.
    #[must_use]
    pub fn payload_size(&self) -> u32 {
        u32_at(&self.bytes, 22).unwrap_or(0)
    }

    /// Holds an answer against what was asked and against the size of the mode's image.
    ///
    /// # Errors
    /// [`ProbeError`] names the field that differs.
    pub fn agrees(&self, asked: &Self, frame_size: u32) -> Result<(), ProbeError> {
        if self.mode() != asked.mode() {
            return Err(ProbeError::Mode { got: self.mode(), wanted: asked.mode() });
        }
        if self.interval() != asked.interval() {
            return Err(ProbeError::Interval { got: self.interval(), wanted: asked.interval() });
        }
        if self.frame_size() != frame_size {
            return Err(ProbeError::FrameSize { got: self.frame_size(), wanted: frame_size });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_question_is_written_byte_for_byte() {
        let asked = Probe::read(&[0xee; 48], 48).expect("48 bytes").ask((1, 3), 166_666);
        assert_eq!(asked.bytes()[..8], [1, 0, 1, 3, 0x0a, 0x8b, 0x02, 0]);
        assert_eq!(asked.bytes()[18..26], [0; 8]);
        assert_eq!((asked.bytes()[8], asked.bytes()[26], asked.bytes().len()), (0xee, 0xee, 48));
    }

    #[test]
    fn each_difference_has_its_name() {
        let asked = Probe::read(&[0; 34], 34).expect("34 bytes").ask((1, 3), 166_666);
        let mut bytes = [0; 34];
        bytes.copy_from_slice(asked.bytes());
        bytes[18..22].copy_from_slice(&614_400_u32.to_le_bytes());
        let sound = Probe::read(&bytes, 34).expect("34 bytes");
        assert_eq!(sound.agrees(&asked, 614_400), Ok(()));
        let changed = |at: usize| {
            let mut other = bytes;
            other[at] ^= 1;
            Probe::read(&other, 34).expect("34 bytes").agrees(&asked, 614_400)
        };
        assert_eq!(changed(2), Err(ProbeError::Mode { got: (0, 3), wanted: (1, 3) }));
        assert_eq!(changed(4), Err(ProbeError::Interval { got: 166_667, wanted: 166_666 }));
        assert_eq!(changed(18), Err(ProbeError::FrameSize { got: 614_401, wanted: 614_400 }));
        assert_eq!(Probe::read(&bytes, 48), Err(ProbeError::Length { got: 34, wanted: 48 }));
        assert_eq!([0x0100, 0x0110, 0x0150].map(probe_length), [26, 34, 48]);
    }
}
