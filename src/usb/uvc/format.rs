//! Streaming formats: pixel formats by GUID, frame sizes and intervals.
//!
//! | descriptor | index | width | height | frame bytes | intervals: count, first |
//! |---|---|---|---|---|---|
//! | frame, uncompressed (0x05) | 3 | 5 | 7 | 17 | 25, 26 |
//! | frame, frame-based (0x11) | 3 | 5 | 7 | bytes a line at 22 | 21, 26 |
//!
//! A frame belongs to the format descriptor before it. Intervals count 100 ns; 60 Hz is 166 666.
//! Source: USB Video Class 1.5, section 3.9; its payload documents "Uncompressed" and "Frame Based".

use super::bytes::{u16_at, u32_at};
use super::descriptor::{Descriptor, Interface};

/// Subtypes of class-specific streaming descriptors.
const INPUT_HEADER: u8 = 0x01;
const FORMAT_UNCOMPRESSED: u8 = 0x04;
const FRAME_UNCOMPRESSED: u8 = 0x05;
const FORMAT_FRAME_BASED: u8 = 0x10;
const FRAME_FRAME_BASED: u8 = 0x11;

/// Units of 100 ns in a second.
const TICKS: u32 = 10_000_000;

/// Pixel format of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelFormat {
    /// Depth, 16 bits, 0 is "none". Its GUID is `Z16 ` or, in older firmware, D16 (0x50).
    Z16,
    /// Grey, 8 bits: the left infrared image. L8 (0x32), `Y8  `, `GREY` or `RAW8`.
    Y8,
    /// Left and right grey pixels by turns.
    Y8i,
    /// Left and right in 12 bits each, for calibration.
    Y12i,
    /// Colour, Y0 U Y1 V.
    Yuy2,
    /// Anything else.
    Other,
}

impl PixelFormat {
    /// By the GUID as its 16 bytes stand on the wire.
    ///
    /// ```
    /// use meniscus::usb::uvc::format::PixelFormat;
    ///
    /// let depth = *b"Z16 \0\0\x10\0\x80\0\0\xaa\0\x38\x9b\x71";
    /// assert_eq!(PixelFormat::of(&depth), PixelFormat::Z16);
    /// assert_eq!(PixelFormat::of(&[0; 16]), PixelFormat::Other);
    /// ```
    #[must_use]
    pub fn of(guid: &[u8; 16]) -> Self {
        const TAIL: [u8; 12] = [0x00, 0x00, 0x10, 0x00, 0x80, 0x00, 0x00, 0xaa, 0x00, 0x38, 0x9b, 0x71];
        let (code, tail) = (guid.first_chunk::<4>(), guid.last_chunk::<12>());
        match code.filter(|_| tail == Some(&TAIL)) {
            Some(b"Z16 " | b"\x50\0\0\0") => Self::Z16,
            Some(b"\x32\0\0\0" | b"Y8  " | b"GREY" | b"RAW8") => Self::Y8,
            Some(b"Y8I ") => Self::Y8i,
            Some(b"Y12I") => Self::Y12i,
            Some(b"YUY2") => Self::Yuy2,
            _ => Self::Other,
        }
    }

    /// Bytes of a pixel; `None` where this program does not know.
    #[must_use]
    pub fn bytes(self) -> Option<u32> {
        match self {
            Self::Z16 | Self::Y8i | Self::Yuy2 => Some(2),
            Self::Y8 => Some(1),
            Self::Y12i => Some(3),
            Self::Other => None,
        }
    }
}

/// One image size of one format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VideoMode<'a> {
    /// bFormatIndex.
    pub format: u8,
    /// bFrameIndex.
    pub frame: u8,
    /// Pixel format.
    pub pixels: PixelFormat,
    /// Pixels in a row.
    pub width: u16,
    /// Rows.
    pub height: u16,
    /// Bytes of a frame as the descriptor states them (uncompressed), or by its bytes a line.
    pub frame_bytes: u32,
    count: u8,
    intervals: &'a [u8],
}

impl VideoMode<'_> {
    /// Frame intervals of the descriptor, units of 100 ns; a continuous range gives its two ends.
    pub fn intervals(&self) -> impl Iterator<Item = u32> {
        let numbers = if self.count == 0 { 2 } else { usize::from(self.count) };
        (0..numbers).map_while(|k| u32_at(self.intervals, 4 * k))
    }

    /// The interval of `rate_hz`, as the descriptor spells it (166 666 for 60 Hz).
    #[must_use]
    pub fn interval_of(&self, rate_hz: u32) -> Option<u32> {
        if self.count == 0 {
            let wanted = TICKS.checked_div(rate_hz)?;
            let (least, most) = (u32_at(self.intervals, 0)?, u32_at(self.intervals, 4)?);
            return (least..=most).contains(&wanted).then_some(wanted);
        }
        self.intervals().find(|interval| rate_of(*interval) == rate_hz)
    }
}

/// Frames a second of an interval, rounded; 0 for an interval of 0.
///
/// ```
/// use meniscus::usb::uvc::format::rate_of;
///
/// assert_eq!(rate_of(166_666), 60);
/// assert_eq!(rate_of(0), 0);
/// ```
#[must_use]
pub fn rate_of(interval: u32) -> u32 {
    TICKS.saturating_add(interval / 2).checked_div(interval).unwrap_or(0)
}

/// Endpoint and terminal of a streaming interface, by its input header.
///
/// ```
/// use meniscus::usb::uvc::descriptor::{Interface, VIDEO_STREAMING};
/// use meniscus::usb::uvc::format::input_header;
///
/// // bEndpointAddress stands at byte 6, bTerminalLink at byte 8.
/// let extra = [13, 0x24, 1, 1, 0, 0, 0x82, 0, 5, 0, 0, 0, 0];
/// let interface = Interface { number: 1, alternate: 0, class: VIDEO_STREAMING, extra: &extra };
/// assert_eq!(input_header(&interface), Some((0x82, 5)));
/// ```
#[must_use]
pub fn input_header(interface: &Interface<'_>) -> Option<(u8, u8)> {
    let (_, header) = interface.class_specific().find(|(subtype, _)| *subtype == INPUT_HEADER)?;
    Some((header.byte(6)?, header.byte(8)?))
}

/// Every image size of a streaming interface, in its order.
///
/// ```
/// use meniscus::usb::uvc::descriptor::{Interface, VIDEO_STREAMING};
/// use meniscus::usb::uvc::format::{PixelFormat, video_modes};
///
/// let mut extra = [0; 27 + 30];
/// // Format 1: uncompressed, Z16.
/// extra[..4].copy_from_slice(&[27, 0x24, 4, 1]);
/// extra[5..21].copy_from_slice(b"Z16 \0\0\x10\0\x80\0\0\xaa\0\x38\x9b\x71");
/// // Its frame 2: 640 x 480, one interval.
/// extra[27..36].copy_from_slice(&[30, 0x24, 5, 2, 0, 0x80, 2, 0xe0, 1]);
/// extra[27 + 25] = 1;
/// extra[27 + 26..].copy_from_slice(&166_666_u32.to_le_bytes());
/// let interface = Interface { number: 1, alternate: 0, class: VIDEO_STREAMING, extra: &extra };
///
/// let mode = video_modes(&interface).next().unwrap();
/// assert_eq!((mode.width, mode.height, mode.pixels), (640, 480, PixelFormat::Z16));
/// assert_eq!((mode.format, mode.frame, mode.interval_of(60)), (1, 2, Some(166_666)));
/// ```
pub fn video_modes<'a>(interface: &Interface<'a>) -> impl Iterator<Item = VideoMode<'a>> + use<'a> {
    let mut format = None;
    interface.class_specific().filter_map(move |(subtype, descriptor)| match subtype {
        FORMAT_UNCOMPRESSED | FORMAT_FRAME_BASED => {
            let guid = descriptor.bytes.get(5..).and_then(<[u8]>::first_chunk);
            format = descriptor.byte(3).zip(guid.map(PixelFormat::of));
            None
        }
        FRAME_UNCOMPRESSED | FRAME_FRAME_BASED => {
            let (format, pixels) = format?;
            mode(&descriptor, subtype == FRAME_FRAME_BASED, format, pixels)
        }
        _ => None,
    })
}

fn mode<'a>(
    descriptor: &Descriptor<'a>,
    frame_based: bool,
    format: u8,
    pixels: PixelFormat,
) -> Option<VideoMode<'a>> {
    let bytes = descriptor.bytes;
    let (width, height) = (u16_at(bytes, 5)?, u16_at(bytes, 7)?);
    let (frame_bytes, count) = if frame_based {
        (u32_at(bytes, 22)?.saturating_mul(u32::from(height)), descriptor.byte(21)?)
    } else {
        (u32_at(bytes, 17)?, descriptor.byte(25)?)
    };
    let intervals = bytes.get(26..)?;
    Some(VideoMode {
        format,
        frame: descriptor.byte(3)?,
        pixels,
        width,
        height,
        frame_bytes,
        count,
        intervals,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TAIL: [u8; 12] = [0, 0, 0x10, 0, 0x80, 0, 0, 0xaa, 0, 0x38, 0x9b, 0x71];

    fn guid(code: [u8; 4]) -> [u8; 16] {
        let mut guid = [0; 16];
        guid[..4].copy_from_slice(&code);
        guid[4..].copy_from_slice(&TAIL);
        guid
    }

    #[test]
    fn old_and_new_firmware_name_the_same_pixels() {
        assert_eq!(PixelFormat::of(&guid(*b"Z16 ")), PixelFormat::Z16);
        assert_eq!(PixelFormat::of(&guid([0x50, 0, 0, 0])), PixelFormat::Z16);
        assert_eq!(PixelFormat::of(&guid([0x32, 0, 0, 0])), PixelFormat::Y8);
        assert_eq!(PixelFormat::of(&guid(*b"MJPG")), PixelFormat::Other);
        assert_eq!(PixelFormat::of(&[0x50; 16]), PixelFormat::Other, "the tail counts");
    }

    /// A 640x480 frame as a D435i describes it: 1280 bytes a line, five intervals.
    fn frame_based() -> [u8; 46] {
        let mut bytes = [0; 46];
        bytes[..9].copy_from_slice(&[46, 0x24, 0x11, 3, 0, 0x80, 2, 0xe0, 1]);
        bytes[9..13].copy_from_slice(&29_491_200_u32.to_le_bytes());
        bytes[13..17].copy_from_slice(&442_368_000_u32.to_le_bytes());
        bytes[17..21].copy_from_slice(&333_333_u32.to_le_bytes());
        bytes[21] = 5;
        bytes[22..26].copy_from_slice(&1280_u32.to_le_bytes());
        for (k, interval) in [111_111_u32, 166_666, 333_333, 666_666, 1_666_665].into_iter().enumerate() {
            bytes[26 + 4 * k..30 + 4 * k].copy_from_slice(&interval.to_le_bytes());
        }
        bytes
    }

    #[test]
    fn a_frame_based_mode_has_its_intervals_where_its_own_table_puts_them() {
        let mut extra = [0; 28 + 46];
        extra[..5].copy_from_slice(&[28, 0x24, 0x10, 1, 1]);
        extra[5..21].copy_from_slice(&guid(*b"Z16 "));
        extra[28..].copy_from_slice(&frame_based());
        let interface = Interface { number: 1, alternate: 0, class: (14, 2), extra: &extra };
        let mode = video_modes(&interface).next().expect("one mode");
        assert_eq!((mode.format, mode.frame, mode.pixels), (1, 3, PixelFormat::Z16));
        assert_eq!((mode.width, mode.height, mode.frame_bytes), (640, 480, 614_400));
        assert_eq!([90, 60, 30, 15, 6].map(|rate| mode.interval_of(rate).is_some()), [true; 5]);
        assert_eq!((mode.interval_of(60), mode.interval_of(25)), (Some(166_666), None));
    }

    #[test]
    fn an_interval_count_beyond_the_descriptor_gives_what_is_there() {
        let mut extra = [0; 28 + 46];
        extra[..5].copy_from_slice(&[28, 0x24, 0x10, 1, 1]);
        extra[28..].copy_from_slice(&frame_based());
        extra[28 + 21] = 200;
        let interface = Interface { number: 1, alternate: 0, class: (14, 2), extra: &extra };
        assert_eq!(video_modes(&interface).next().expect("one mode").intervals().count(), 5);
    }

    #[test]
    fn a_rate_is_rounded() {
        let rates = [166_666, 166_667, 111_111, 1_666_665, 0].map(rate_of);
        assert_eq!(rates, [60, 60, 90, 6, 0]);
    }
}
