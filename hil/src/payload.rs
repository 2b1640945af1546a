//! One payload: the 232-byte header of the D435's depth and infrared streams, then the pixels. The colour stream's is
//! given the same one; the camera's own has a block of 80 bytes for that of depth control.
//!
//! | offset | block | bytes |
//! |---|---|---|
//! | 0 | UVC header: length, flags, PTS, SCR | 12 |
//! | 12 | capture timing 0x80000001 | 40 |
//! | 52 | capture stats 0x00000003 | 80 |
//! | 132 | depth control 0x80000000 | 60 |
//! | 192 | configuration 0x80000002 | 40 |

/// Bytes before the pixels.
pub const HEADER_LENGTH: usize = 232;

/// Offset of the flags byte.
pub(crate) const FLAGS_AT: usize = 1;
/// Offset of the frame counter inside the capture timing block.
pub(crate) const COUNTER_AT: usize = 12 + 16;
/// Flag bits of the UVC header.
pub(crate) const FID: u8 = 0x01;
pub(crate) const EOF: u8 = 0x02;
pub(crate) const ERR: u8 = 0x40;
const PTS_PRESENT: u8 = 0x04;
const SCR_PRESENT: u8 = 0x08;
const END_OF_HEADER: u8 = 0x80;

/// Pixels as they go on the wire.
#[derive(Clone, Copy, Debug)]
pub struct Image<'a> {
    /// Row-major pixel bytes.
    pub pixels: &'a [u8],
    /// Pixels in a row.
    pub width: u16,
    /// Rows.
    pub height: u16,
    /// The camera's number of the pixel format: 0 for Z16, 1 for Y8, 4 for YUY2.
    pub format: u16,
}

/// Frame data of a payload header.
#[derive(Clone, Copy, Debug)]
pub struct Stamp {
    /// Frame identifier, toggles from frame to frame.
    pub fid: bool,
    /// Presentation time stamp: end of the exposure, microseconds of the device clock modulo 2^32.
    pub pts_us: u32,
    /// Number of the bus frame, 11 bits.
    pub bus_frame: u16,
    /// The camera's frame counter.
    pub counter: u32,
    /// Exposure, microseconds.
    pub exposure_us: u32,
    /// Frame interval, microseconds.
    pub interval_us: u32,
}

/// Packs a frame into one payload.
#[must_use]
pub fn pack(stamp: &Stamp, image: &Image<'_>) -> Vec<u8> {
    let mut out = Vec::with_capacity(HEADER_LENGTH + image.pixels.len());
    uvc_header(&mut out, stamp);
    capture_timing(&mut out, stamp);
    capture_stats(&mut out, stamp);
    depth_control(&mut out, stamp, image);
    configuration(&mut out, stamp, image);
    debug_assert_eq!(out.len(), HEADER_LENGTH);
    out.extend_from_slice(image.pixels);
    out
}

fn uvc_header(out: &mut Vec<u8>, stamp: &Stamp) {
    let flags = EOF | PTS_PRESENT | SCR_PRESENT | END_OF_HEADER | if stamp.fid { FID } else { 0 };
    out.extend([HEADER_LENGTH as u8, flags]);
    u32s(out, &[stamp.pts_us, stamp.pts_us]);
    out.extend((stamp.bus_frame & 0x07ff).to_le_bytes());
}

/// Version, flags (all six fields valid), counter, sensor timestamp (half the exposure, in spite of
/// its name), readout, exposure, interval, latency.
fn capture_timing(out: &mut Vec<u8>, stamp: &Stamp) {
    u32s(out, &[0x8000_0001, 40, 1, 0x3f]);
    u32s(out, &[stamp.counter, stamp.exposure_us / 2, 10_000, stamp.exposure_us, stamp.interval_us, 5_000]);
}

/// Flags, reserved, hardware time stamp, exposure (64 bits), then fields that a D435 leaves at rest.
fn capture_stats(out: &mut Vec<u8>, stamp: &Stamp) {
    u32s(out, &[0x0000_0003, 80, 0x3, stamp.pts_us, stamp.exposure_us, 0]);
    out.resize(52 + 80, 0);
}

/// Version, flags (all nine fields valid), gain, exposure, laser power, exposure mode, priority,
/// region of the exposure control, preset, emitter mode, LED power.
fn depth_control(out: &mut Vec<u8>, stamp: &Stamp, image: &Image<'_>) {
    u32s(out, &[0x8000_0000, 60, 2, 0x1ff, 16, stamp.exposure_us, 150, 0, 0]);
    u32s(out, &[0, u32::from(image.width) - 1, 0, u32::from(image.height) - 1, 0]);
    out.extend([1, 0, 0, 0]);
}

/// Version, flags (all eleven fields valid), hardware, cookie, format, size, rate, trigger,
/// calibration count, GPIO, sub-preset.
fn configuration(out: &mut Vec<u8>, stamp: &Stamp, image: &Image<'_>) {
    u32s(out, &[0x8000_0002, 40, 1, 0x7ff]);
    out.extend([4, 0]);
    u32s(out, &[0]);
    let interval_us = stamp.interval_us.max(1);
    let rate = ((1_000_000 + interval_us / 2) / interval_us) as u16;
    for field in [image.format, image.width, image.height, rate, 0, 0] {
        out.extend(field.to_le_bytes());
    }
    out.push(0);
    u32s(out, &[0]);
    out.push(0);
}

fn u32s(out: &mut Vec<u8>, numbers: &[u32]) {
    numbers.iter().for_each(|number| out.extend(number.to_le_bytes()));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bytes_lie_where_the_fact_sheet_puts_them() {
        let stamp = Stamp {
            fid: true,
            pts_us: 0x0403_0201,
            bus_frame: 0x0fff,
            counter: 0x0807_0605,
            exposure_us: 4_000,
            interval_us: 16_667,
        };
        let image = Image { pixels: &[9, 8, 7, 6], width: 2, height: 1, format: 0 };
        let bytes = pack(&stamp, &image);
        let u32_at = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        let u16_at = |at: usize| u16::from_le_bytes(bytes[at..at + 2].try_into().unwrap());
        // Length, FID | EOF | PTS | SCR | EOH, PTS, clock, bus frame.
        assert_eq!(bytes[..12], [232, 0x8f, 1, 2, 3, 4, 1, 2, 3, 4, 0xff, 0x07]);
        let blocks = [(12, 0x8000_0001, 40), (52, 3, 80), (132, 0x8000_0000, 60), (192, 0x8000_0002, 40)];
        for (at, id, size) in blocks {
            assert_eq!((u32_at(at), u32_at(at + 4)), (id, size), "block at {at}");
        }
        assert_eq!((u32_at(12 + 16), u32_at(12 + 20), u32_at(12 + 28)), (0x0807_0605, 2_000, 4_000));
        assert_eq!((u32_at(132 + 20), u32_at(132 + 24)), (4_000, 150), "exposure and laser power");
        assert_eq!([192 + 22, 192 + 24, 192 + 26, 192 + 28].map(u16_at), [0, 2, 1, 60], "format, size, rate");
        assert_eq!(bytes[232..], [9, 8, 7, 6]);
    }
}
