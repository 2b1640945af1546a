//! A video frame as a payload of the outline's stream: the header of a UVC payload, then YUY2.
//!
//! | offset | field |
//! |---|---|
//! | 0 | length of the header, flags: frame identifier, end of frame, time stamp, error, end of header |
//! | 2 | the driver's time, microseconds modulo 2^32 |
//! | 6 | capture timing of 40 bytes, of which the frame's number alone is valid |

use crate::mode::{Mode, PixelFormat};
use crate::video::VideoFrame;
use meniscus_usb::buffer::Buffer;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// Bytes before the pixels.
const HEADER: usize = 46;
/// Bytes of a YUY2 pixel.
const PIXEL: usize = 2;
/// Colour of a grey pixel.
const GREY: u8 = 128;
const FID: u8 = 0x01;
const END_OF_FRAME: u8 = 0x02;
const HAS_TIME: u8 = 0x04;
const ERROR: u8 = 0x40;
const END_OF_HEADER: u8 = 0x80;

/// Packs frames of one mode.
#[derive(Debug)]
pub(crate) struct Packer {
    mode: Mode,
    luma: Vec<u8>,
}

impl Packer {
    pub(crate) fn new(mode: Mode) -> Self {
        let pixels = usize::from(mode.size[0]) * usize::from(mode.size[1]);
        Self { mode, luma: vec![0; if mode.format == PixelFormat::Mjpg { pixels } else { 0 }] }
    }

    /// Bytes of a payload.
    pub(crate) fn payload_bytes(mode: Mode) -> usize {
        HEADER + PIXEL * usize::from(mode.size[0]) * usize::from(mode.size[1])
    }

    /// Fills `payload` with a frame. One that is damaged, or is no JPEG of the right size, goes on with the error bit; one
    /// that is too short as it is. The reader books both.
    pub(crate) fn pack(&mut self, frame: &VideoFrame<'_>, payload: &mut Buffer) {
        let whole = !frame.damaged
            && match self.mode.format {
                PixelFormat::Yuyv => true,
                PixelFormat::Mjpg => self.decode(frame.bytes),
            };
        let pixels = payload.room().get_mut(HEADER..).unwrap_or_default();
        let filled = match (whole, self.mode.format) {
            (false, _) => 0,
            (true, PixelFormat::Yuyv) => self.rows(frame, pixels),
            (true, PixelFormat::Mjpg) => {
                let pairs = pixels.as_chunks_mut().0.iter_mut();
                pairs.zip(&self.luma).for_each(|(to, &luma)| *to = [luma, GREY]);
                PIXEL * self.luma.len()
            }
        };
        if let Some(head) = payload.room().get_mut(..HEADER) {
            head.copy_from_slice(&header(frame, whole));
        }
        payload.set_filled(HEADER + filled);
    }

    /// Copies the rows of a YUYV frame that are there without what lies between them; returns the bytes.
    fn rows(&self, frame: &VideoFrame<'_>, pixels: &mut [u8]) -> usize {
        let [width, height] = self.mode.size.map(usize::from);
        let row_bytes = PIXEL * width;
        let rows = frame.bytes.chunks(frame.bytes_per_row.max(row_bytes)).take(height);
        let mut filled = 0;
        for (from, to) in rows.zip(pixels.chunks_exact_mut(row_bytes)) {
            let from = from.get(..row_bytes).unwrap_or(from);
            to[..from.len()].copy_from_slice(from);
            filled += from.len();
        }
        filled
    }

    /// Decodes the luma of a JPEG; whether it is one of the mode's size.
    fn decode(&mut self, bytes: &[u8]) -> bool {
        let [width, height] = self.mode.size.map(usize::from);
        let options = DecoderOptions::default()
            .jpeg_set_out_colorspace(ColorSpace::Luma)
            .set_strict_mode(false)
            .set_max_width(width)
            .set_max_height(height);
        let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
        let fits = decoder.decode_headers().is_ok()
            && decoder.dimensions() == Some((width, height))
            && decoder.output_buffer_size() == Some(self.luma.len());
        fits && decoder.decode_into(&mut self.luma).is_ok()
    }
}

fn header(frame: &VideoFrame<'_>, whole: bool) -> [u8; HEADER] {
    let mut head = [0; HEADER];
    let fid = if frame.sequence % 2 == 1 { FID } else { 0 };
    let error = if whole { 0 } else { ERROR };
    head[0] = HEADER as u8;
    head[1] = fid | END_OF_FRAME | HAS_TIME | END_OF_HEADER | error;
    head[2..6].copy_from_slice(&(frame.captured_us as u32).to_le_bytes());
    // Capture timing: id, size, version, flags with the number's bit alone, number.
    let fields = [0x8000_0001, 40, 1, 1, frame.sequence];
    for (place, field) in head[6..26].chunks_exact_mut(4).zip(fields) {
        place.copy_from_slice(&field.to_le_bytes());
    }
    head
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::usb::uvc::{Assembler, AssemblyOutcome, Cause, DeviceClock};

    const MODE: Mode = Mode { format: PixelFormat::Yuyv, size: [4, 2], interval: [1, 30] };

    /// A frame of rows that are 10 bytes apart.
    fn frame(bytes: &[u8]) -> VideoFrame<'_> {
        VideoFrame { bytes, bytes_per_row: 10, captured_us: (7 << 32) + 500, sequence: 41, damaged: false }
    }

    /// Number, time and pixels of a frame.
    type Whole = (u32, u64, Vec<u8>);

    fn assembled(frame: VideoFrame<'_>) -> (Option<Whole>, Option<Cause>) {
        let mut payload = Buffer::new(Packer::payload_bytes(MODE));
        Packer::new(MODE).pack(&frame, &mut payload);
        let mut room = [0; 16];
        let mut assembler = Assembler::new(&mut room);
        match assembler.push(&payload, &mut DeviceClock::default()) {
            AssemblyOutcome::Frame(frame) => {
                (Some((frame.stamp.sequence, frame.stamp.captured.0, frame.pixels.to_vec())), None)
            }
            AssemblyOutcome::Lost(cause) => (None, Some(cause)),
            AssemblyOutcome::Partial => (None, None),
        }
    }

    #[test]
    fn time_number_and_rows_of_the_driver_come_through() {
        let bytes: Vec<u8> = (0..20).collect();
        let rows: Vec<u8> = (0..8).chain(10..18).collect();
        assert_eq!(assembled(frame(&bytes)), (Some((41, 500, rows.clone())), None));
        // The last row without the bytes behind it.
        assert_eq!(assembled(frame(&bytes[..18])), (Some((41, 500, rows)), None));
    }

    #[test]
    fn a_short_frame_and_a_damaged_one_are_booked() {
        let bytes: Vec<u8> = (0..20).collect();
        assert_eq!(assembled(frame(&bytes[..17])), (None, Some(Cause::ShortFrame)));
        assert_eq!(assembled(VideoFrame { damaged: true, ..frame(&bytes) }), (None, Some(Cause::ErrorBit)));
        assert_eq!(assembled(frame(&[])), (None, Some(Cause::EmptyPayload)));
    }

    #[test]
    fn what_is_no_jpeg_is_damaged() {
        let mode = Mode { format: PixelFormat::Mjpg, ..MODE };
        for bytes in [&[][..], &[0xff, 0xd8, 0xff], &[7; 64]] {
            let mut payload = Buffer::new(Packer::payload_bytes(mode));
            Packer::new(mode).pack(&frame(bytes), &mut payload);
            assert_eq!((payload.len(), payload[1] & ERROR), (HEADER, ERROR), "{bytes:?}");
        }
    }
}
