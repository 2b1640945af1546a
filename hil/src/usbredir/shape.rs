//! Description of the device for QEMU, before the guest sees it: speed, interfaces, endpoints.

use super::wire::{Message, kind};
use crate::device::Seen;

/// Places for interfaces, and for endpoints: 0 to 15 outwards, 16 to 31 inwards.
const PLACES: usize = 32;
/// A place without an endpoint.
const NONE: u8 = 255;
/// The speeds of the protocol.
const HIGH: u8 = 2;
const SUPER: u8 = 3;

/// The three messages of a plug, by the configuration descriptor.
pub(super) fn connect(seen: &Seen, configuration: &[u8]) -> [Message; 3] {
    let mut interfaces: Vec<[u8; 4]> = Vec::new();
    let (mut kinds, mut intervals, mut owners) = ([NONE; PLACES], [0; PLACES], [0; PLACES]);
    let mut packets = [0_u16; PLACES];
    for control in [0, PLACES / 2] {
        (kinds[control], packets[control]) = (0, if seen.usb2 { 64 } else { 512 });
    }
    for descriptor in descriptors(configuration) {
        match *descriptor {
            [9, 4, number, 0, _, class, subclass, protocol, _] => {
                interfaces.push([number, class, subclass, protocol]);
            }
            [7, 5, address, attributes, low, high, interval] => {
                let place = usize::from(address & 0x0f) + usize::from(address >> 7) * PLACES / 2;
                kinds[place] = attributes & 3;
                intervals[place] = interval;
                owners[place] = interfaces.last().map_or(0, |interface| interface[0]);
                packets[place] = u16::from_le_bytes([low, high]);
            }
            _ => {}
        }
    }
    let mut endpoints = [kinds, intervals, owners].concat();
    packets.iter().for_each(|packet| endpoints.extend(packet.to_le_bytes()));
    let mut shown = (interfaces.len() as u32).to_le_bytes().to_vec();
    interfaces.resize(PLACES, [0; 4]);
    (0..4).for_each(|field| shown.extend(interfaces.iter().map(|interface| interface[field])));
    let ([v0, v1], [p0, p1]) = (seen.vendor.to_le_bytes(), seen.product.to_le_bytes());
    // Class by interface association; version 50.10.
    let device = vec![if seen.usb2 { HIGH } else { SUPER }, 0xef, 2, 1, v0, v1, p0, p1, 0x10, 0x50];
    [
        Message::new(kind::ENDPOINTS, 0, endpoints),
        Message::new(kind::INTERFACES, 0, shown),
        Message::new(kind::CONNECT, 0, device),
    ]
}

/// The descriptors one after the other, as far as their lengths hold.
fn descriptors(mut bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || {
        let length = usize::from(*bytes.first()?);
        let (one, rest) = bytes.split_at_checked(length.max(1))?;
        bytes = rest;
        Some(one)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FaultList;
    use crate::device::{DEPTH, Device, INTERRUPT, TestCard};

    #[test]
    fn the_cameras_five_interfaces_and_four_endpoints_are_described() {
        let device = Device::new(Box::<TestCard>::default(), None, FaultList::default(), 1);
        let seen = device.seen(0).expect("it is there");
        let [endpoints, interfaces, connect] = connect(&seen, &device.enumerated(0));
        assert_eq!((endpoints.body.len(), interfaces.body.len(), connect.body.len()), (160, 132, 10));
        assert_eq!(interfaces.body[..4], [5, 0, 0, 0]);
        let kind = |address: u8| endpoints.body[16 + usize::from(address & 0x0f)];
        assert_eq!((kind(DEPTH), kind(INTERRUPT), kind(0x8f)), (2, 3, NONE));
        assert_eq!(endpoints.body[96 + 2 * 18..][..2], 1024_u16.to_le_bytes());
        assert_eq!(connect.body[..6], [SUPER, 0xef, 2, 1, 0x86, 0x80]);
    }
}
