//! The configuration descriptor of a D435, byte by byte.

use super::trouble::Trouble;

/// Number of the colour function's control interface.
pub(super) const COLOUR_CONTROL: u8 = 3;
/// Number of its streaming interface.
pub(super) const COLOUR_STREAMING: u8 = 4;
/// Its camera terminal.
pub(super) const COLOUR_TERMINAL: u8 = 6;

/// Output terminals of the depth function and of the colour function.
const DEPTH_OUTPUT: u8 = 4;
const COLOUR_OUTPUT: u8 = 9;

/// The code of a format that no reader knows.
const UNKNOWN: [u8; 4] = *b"none";

/// Formats, frames and endpoints follow the public dumps of D435 cameras.
const TAIL: [u8; 12] = [0x00, 0x00, 0x10, 0x00, 0x80, 0x00, 0x00, 0xaa, 0x00, 0x38, 0x9b, 0x71];
const DEPTH_UNIT: [u8; 16] =
    [0xcb, 0x6c, 0x60, 0xc9, 0x4c, 0x59, 0x25, 0x4d, 0xaf, 0x47, 0xcc, 0xc4, 0x96, 0x43, 0x59, 0x95];
const COLOUR_UNIT: [u8; 16] =
    [0xb8, 0xec, 0x41, 0x6e, 0xa3, 0xac, 0x45, 0x80, 0x8d, 0x5c, 0x0b, 0xee, 0x15, 0x97, 0xe4, 0x3d];

/// Intervals by rate, 100 ns, as the camera spells them.
const ALL: &[u32] = &[111_111, 166_666, 333_333, 666_666, 1_666_665];
const NO_60: &[u32] = &[111_111, 333_333, 666_666, 1_666_665];
const SLOW: &[u32] = &[333_333, 666_666, 1_666_665];
const FAST_SMALL: &[u32] = &[166_666, 333_333, 666_666, 1_666_665];

/// Image sizes with their intervals.
pub(super) type Modes = Vec<(u16, u16, &'static [u32])>;

/// The sizes of the depth and infrared streams.
pub(super) fn modes(usb2: bool, trouble: Option<Trouble>) -> Modes {
    let rates = if trouble == Some(Trouble::NoRate) { NO_60 } else { ALL };
    if usb2 {
        return vec![(1280, 720, &SLOW[2..]), (640, 480, SLOW), (480, 270, FAST_SMALL)];
    }
    vec![(1280, 720, SLOW), (848, 480, rates), (640, 480, rates), (640, 360, rates), (480, 270, rates)]
}

/// The whole configuration.
pub(super) fn configuration(usb2: bool, trouble: Option<Trouble>) -> Vec<u8> {
    let modes = modes(usb2, trouble);
    let mut out = Vec::new();
    association(&mut out, 0, 3);
    let interrupt = trouble != Some(Trouble::InterruptDead);
    interface(&mut out, 0, u8::from(interrupt), 1);
    let unit = if trouble == Some(Trouble::NoUnit) { [0x11; 16] } else { DEPTH_UNIT };
    control(&mut out, &[1, 2], &Units { terminal: 1, processing: 2, extension: 3 }, &unit);
    if interrupt {
        endpoint(&mut out, 0x87, 3, 64, usb2);
        out.extend([5, 0x25, 3, 64, 0]);
    }
    let depth = match trouble {
        Some(Trouble::OldGuid) => *b"\x50\0\0\0",
        Some(Trouble::NoDepth) => UNKNOWN,
        _ => *b"Z16 ",
    };
    let grey = if trouble == Some(Trouble::NoInfrared) { UNKNOWN } else { *b"\x32\0\0\0" };
    streaming(&mut out, 1, 0x82, usb2, &[(depth, 16)], &modes);
    streaming(&mut out, 2, 0x83, usb2, &[(grey, 8), (*b"Y8I ", 16)], &modes);
    association(&mut out, COLOUR_CONTROL, 2);
    interface(&mut out, COLOUR_CONTROL, 0, 1);
    let units = Units { terminal: COLOUR_TERMINAL, processing: 7, extension: 8 };
    control(&mut out, &[COLOUR_STREAMING], &units, &COLOUR_UNIT);
    colour(&mut out, usb2);
    let length = (out.len() + 9) as u16;
    let [low, high] = length.to_le_bytes();
    let mut all = vec![9, 2, low, high, 5, 1, 0, 0xc0, 55];
    all.extend(out);
    match trouble {
        Some(Trouble::CutDescriptors) => all.truncate(300),
        Some(Trouble::ZeroDescriptor) => all[17] = 0,
        _ => {}
    }
    all
}

fn association(out: &mut Vec<u8>, first: u8, count: u8) {
    out.extend([8, 0x0b, first, count, 0x0e, 0x03, 0, 0]);
}

fn interface(out: &mut Vec<u8>, number: u8, endpoints: u8, subclass: u8) {
    out.extend([9, 4, number, 0, endpoints, 0x0e, subclass, 0, 0]);
}

fn endpoint(out: &mut Vec<u8>, address: u8, kind: u8, packet: u16, usb2: bool) {
    let [low, high] = packet.to_le_bytes();
    out.extend([7, 5, address, kind, low, high, if kind == 3 { 6 } else { 0 }]);
    if !usb2 {
        // Burst, attributes, bytes in an interval (periodic endpoints only).
        let (burst, bytes) = if kind == 2 { (15, 0) } else { (0, packet as u8) };
        out.extend([6, 0x30, burst, 0, bytes, 0]);
    }
}

/// Identifiers of the units of a control interface.
struct Units {
    terminal: u8,
    processing: u8,
    extension: u8,
}

/// Header, camera terminal, processing unit, extension unit, output terminal.
fn control(out: &mut Vec<u8>, streams: &[u8], units: &Units, guid: &[u8; 16]) {
    let &Units { terminal, processing, extension } = units;
    let mut units = Vec::new();
    units.extend([18, 0x24, 2, terminal, 0x01, 0x02, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0]);
    units.extend([13, 0x24, 5, processing, terminal, 0, 0, 3, 0xff, 0x17, 0, 0, 0]);
    units.extend([27, 0x24, 6, extension]);
    units.extend(guid);
    units.extend([16, 1, processing, 2, 0xff, 0xff, 0]);
    units.extend([9, 0x24, 3, extension + 1, 0x01, 0x01, 0, extension, 0]);
    let length = 12 + streams.len() as u8;
    let [low, high] = (u16::from(length) + units.len() as u16).to_le_bytes();
    out.extend([length, 0x24, 1, 0x50, 0x01, low, high, 0x80, 0x8d, 0x5b, 0, streams.len() as u8]);
    out.extend(streams);
    out.extend(units);
}

/// Frame-based formats.
fn streaming(
    out: &mut Vec<u8>,
    number: u8,
    address: u8,
    usb2: bool,
    formats: &[([u8; 4], u8)],
    modes: &Modes,
) {
    interface(out, number, 1, 2);
    let mut body = Vec::new();
    for (index, (code, bits)) in formats.iter().enumerate() {
        body.extend([28, 0x24, 0x10, index as u8 + 1, modes.len() as u8]);
        body.extend(code);
        body.extend(TAIL);
        body.extend([*bits, 1, 0, 0, 0, 0, 0]);
        for (frame, (width, height, intervals)) in modes.iter().enumerate() {
            body.extend([26 + 4 * intervals.len() as u8, 0x24, 0x11, frame as u8 + 1, 0]);
            body.extend(width.to_le_bytes());
            body.extend(height.to_le_bytes());
            let bits_a_frame = u32::from(*width) * u32::from(*height) * u32::from(*bits);
            body.extend((bits_a_frame * 6).to_le_bytes());
            body.extend((bits_a_frame.saturating_mul(90)).to_le_bytes());
            body.extend(intervals[0].to_le_bytes());
            body.push(intervals.len() as u8);
            body.extend((u32::from(*width) * u32::from(*bits) / 8).to_le_bytes());
            intervals.iter().for_each(|interval| body.extend(interval.to_le_bytes()));
        }
    }
    body.extend([6, 0x24, 0x0d, 1, 1, 4]);
    input_header(out, address, DEPTH_OUTPUT, formats.len() as u8, body.len());
    out.extend(body);
    endpoint(out, address, 2, if usb2 { 512 } else { 1024 }, usb2);
}

/// `terminal` is the output terminal whose images the stream carries: a driver finds the units of a stream by it.
fn input_header(out: &mut Vec<u8>, address: u8, terminal: u8, formats: u8, rest: usize) {
    let length = 13 + formats;
    let [low, high] = (u16::from(length) + rest as u16).to_le_bytes();
    out.extend([length, 0x24, 1, formats, low, high, address, 0, terminal, 0, 0, 0, 1]);
    out.extend(vec![0; formats.into()]);
}

/// YUY2, uncompressed.
fn colour(out: &mut Vec<u8>, usb2: bool) {
    interface(out, 4, 1, 2);
    let mut body = vec![27, 0x24, 4, 1, 1];
    body.extend(*b"YUY2");
    body.extend(TAIL);
    body.extend([16, 1, 0, 0, 0, 0]);
    body.extend([26 + 8, 0x24, 5, 1, 0, 0x80, 2, 0xe0, 1]);
    for number in [147_456_000_u32, 294_912_000, 614_400, 166_666] {
        body.extend(number.to_le_bytes());
    }
    body.push(2);
    body.extend(166_666_u32.to_le_bytes());
    body.extend(333_333_u32.to_le_bytes());
    input_header(out, 0x84, COLOUR_OUTPUT, 1, body.len());
    out.extend(body);
    endpoint(out, 0x84, 2, if usb2 { 512 } else { 1024 }, usb2);
}
