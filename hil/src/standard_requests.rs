//! Standard requests of any USB device: device descriptor, strings, capabilities, configuration.
//!
//! The kernel asks these while it enumerates. They are not handed to the simulated device, whose troubles
//! are those that a program meets behind the kernel.

use crate::device::Seen;

/// Languages, maker, product, serial number.
const MAKER: &str = "Intel(R) RealSense(TM) Depth Camera 435";

/// Answer to a standard request, or `None` where the request is for the device itself.
pub(crate) fn answer(seen: &Seen, setup: [u8; 8]) -> Option<Vec<u8>> {
    let [request_type, request, low, high, ..] = setup;
    match (request_type, request, high, low) {
        (0x80, 6, 1, 0) => Some(device(seen)),
        (0x80, 6, 3, index) => string(seen, index),
        (0x80, 6, 15, 0) => Some(capabilities()),
        // Status: self-powered, nothing else.
        (0x80, 0, ..) => Some(vec![1, 0]),
        (0x81 | 0x82, 0, ..) => Some(vec![0, 0]),
        // Configuration, interface's setting, features, SET_SEL and SET_ISOCH_DELAY.
        (0x00, 9, ..) | (0x01, 11, ..) | (0x00 | 0x01, 1 | 3, ..) | (0x00, 0x30 | 0x31, ..) => Some(vec![]),
        (0x80, 8, ..) => Some(vec![1]),
        (0x81, 10, ..) => Some(vec![0]),
        _ => None,
    }
}

/// bcdUSB 3.2 or 2.1, class by interface association, largest packet of endpoint 0 as the speed wants it.
fn device(seen: &Seen) -> Vec<u8> {
    let (low, high, packet) = if seen.usb2 { (0x10, 2, 64) } else { (0x20, 3, 9) };
    let ([vendor, of], [product, hi]) = (seen.vendor.to_le_bytes(), seen.product.to_le_bytes());
    vec![18, 1, low, high, 0xef, 2, 1, packet, vendor, of, product, hi, 0x10, 0x50, 1, 2, 3, 1]
}

/// The capabilities: link power management on USB 2, the speeds of USB 3 (full, high, super).
fn capabilities() -> Vec<u8> {
    vec![5, 15, 22, 0, 2, 7, 16, 2, 6, 0, 0, 0, 10, 16, 3, 0, 0x0e, 0, 1, 10, 0xff, 0x07]
}

fn string(seen: &Seen, index: u8) -> Option<Vec<u8>> {
    let text = match index {
        0 => return Some(vec![4, 3, 9, 4]),
        1 => "Intel(R) RealSense(TM)",
        2 => MAKER,
        3 => &seen.serial,
        _ => return None,
    };
    let units: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    Some([&[units.len() as u8 + 2, 3], &units[..]].concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn descriptors_have_the_length_they_state() {
        let seen = Seen { vendor: 0x8086, product: 0x0b07, serial: "839213061234".into(), usb2: false };
        let asked = |high, low| answer(&seen, [0x80, 6, low, high, 0, 0, 255, 0]).expect("answered");
        for (high, low) in [(1, 0), (3, 1), (3, 2), (3, 3)] {
            let bytes = asked(high, low);
            assert_eq!((bytes[0] as usize, bytes[1]), (bytes.len(), high), "descriptor {high}.{low}");
        }
        let bytes = asked(15, 0);
        assert_eq!(usize::from(u16::from_le_bytes([bytes[2], bytes[3]])), bytes.len());
        assert_eq!(asked(1, 0)[8..12], [0x86, 0x80, 0x07, 0x0b]);
        assert_eq!(answer(&seen, [0x80, 6, 0, 2, 0, 0, 9, 0]), None, "the configuration is the device's own");
        assert_eq!(answer(&seen, [0xa1, 0x81, 0, 1, 1, 0, 48, 0]), None);
    }
}
