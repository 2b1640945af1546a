//! The video control interface: its version, its streaming interfaces, terminals and units.
//!
//! | descriptor | subtype | fields |
//! |---|---|---|
//! | header | 0x01 | bcdUVC 3, count of streaming interfaces 11, their numbers from 12 |
//! | input terminal | 0x02 | id 3, type 4 (0x0201: a camera) |
//! | processing unit | 0x05 | id 3 |
//! | extension unit | 0x06 | id 3, GUID 4..20 |
//!
//! Source: USB Video Class 1.5, section 3.7.

use super::bytes::u16_at;
use super::descriptor::Interface;

const HEADER: u8 = 0x01;
const INPUT_TERMINAL: u8 = 0x02;
const PROCESSING_UNIT: u8 = 0x05;
const EXTENSION_UNIT: u8 = 0x06;
/// wTerminalType of a camera.
const CAMERA: u16 = 0x0201;

/// Parts of a video control interface.
///
/// ```
/// use meniscus::usb::uvc::descriptor::{Interface, VIDEO_CONTROL};
/// use meniscus::usb::uvc::Topology;
///
/// // Header of UVC 1.5 with one streaming interface, then processing unit 2.
/// let extra = [13, 0x24, 1, 0x50, 1, 0, 0, 0, 0, 0, 0, 1, 1, 4, 0x24, 5, 2];
/// let interface = Interface { number: 0, alternate: 0, class: VIDEO_CONTROL, extra: &extra };
/// let topology = Topology::of(&interface).unwrap();
/// assert_eq!((topology.version, topology.streaming), (0x0150, &[1][..]));
/// assert_eq!((topology.camera, topology.processing), (None, Some(2)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Topology<'a> {
    /// bcdUVC: 0x0100, 0x0110 or 0x0150.
    pub version: u16,
    /// Numbers of the streaming interfaces that belong to it.
    pub streaming: &'a [u8],
    /// Camera terminal.
    pub camera: Option<u8>,
    /// Processing unit.
    pub processing: Option<u8>,
}

impl<'a> Topology<'a> {
    /// Reads a control interface; `None` without a header.
    #[must_use]
    pub fn of(interface: &Interface<'a>) -> Option<Self> {
        let find = |subtype| interface.class_specific().filter(move |(found, _)| *found == subtype);
        let (_, header) = find(HEADER).next()?;
        let count = usize::from(header.byte(11)?);
        let camera = find(INPUT_TERMINAL).find(|(_, d)| u16_at(d.bytes, 4) == Some(CAMERA));
        Some(Self {
            version: u16_at(header.bytes, 3)?,
            streaming: header.bytes.get(12..12_usize.saturating_add(count))?,
            camera: camera.and_then(|(_, d)| d.byte(3)),
            processing: find(PROCESSING_UNIT).next().and_then(|(_, d)| d.byte(3)),
        })
    }
}

/// The id of the extension unit with this GUID, as its bytes stand on the wire.
///
/// ```
/// use meniscus::usb::uvc::descriptor::{Interface, VIDEO_CONTROL};
/// use meniscus::usb::uvc::extension_unit;
///
/// let mut extra = [7; 20];
/// extra[..4].copy_from_slice(&[20, 0x24, 6, 3]);
/// let interface = Interface { number: 0, alternate: 0, class: VIDEO_CONTROL, extra: &extra };
/// assert_eq!(extension_unit(&interface, &[7; 16]), Some(3));
/// assert_eq!(extension_unit(&interface, &[8; 16]), None);
/// ```
#[must_use]
pub fn extension_unit(interface: &Interface<'_>, guid: &[u8; 16]) -> Option<u8> {
    let mut units = interface.class_specific().filter(|(subtype, _)| *subtype == EXTENSION_UNIT);
    let (_, unit) = units.find(|(_, d)| d.bytes.get(4..).and_then(<[u8]>::first_chunk) == Some(guid))?;
    unit.byte(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_depth_function_reads() {
        let mut extra = [0; 14 + 15 + 11 + 27];
        extra[..14].copy_from_slice(&[14, 0x24, 1, 0x50, 1, 0, 0, 0, 0, 0, 0, 2, 1, 2]);
        extra[14..22].copy_from_slice(&[15, 0x24, 2, 1, 0x01, 0x02, 0, 0]);
        extra[29..33].copy_from_slice(&[11, 0x24, 5, 2]);
        extra[40..44].copy_from_slice(&[27, 0x24, 6, 3]);
        extra[44..60].copy_from_slice(&[7; 16]);
        let interface = Interface { number: 0, alternate: 0, class: (14, 1), extra: &extra };
        let topology = Topology::of(&interface).expect("a header");
        assert_eq!((topology.version, topology.streaming), (0x0150, &[1, 2][..]));
        assert_eq!((topology.camera, topology.processing), (Some(1), Some(2)));
        assert_eq!(extension_unit(&interface, &[7; 16]), Some(3));
        assert_eq!(extension_unit(&interface, &[8; 16]), None);
    }

    #[test]
    fn a_header_that_lists_more_interfaces_than_it_has_is_refused() {
        let extra = [13, 0x24, 1, 0x50, 1, 0, 0, 0, 0, 0, 0, 2, 1];
        let interface = Interface { number: 0, alternate: 0, class: (14, 1), extra: &extra };
        assert_eq!(Topology::of(&interface), None);
    }
}
