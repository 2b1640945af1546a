//! The messages of usbredir (protocol 0.7, <https://gitlab.freedesktop.org/spice/usbredir>, docs/usb-redirection-protocol.md):
//! a header of type, length and number, then a header of the type's own, then bytes; all little-endian.
//!
//! Both sides begin with a hello, whose header has a number of 32 bits; behind it numbers have 64, as both say that
//! they can do that.

use std::io::{self, Read};

/// Types of messages.
pub(super) mod kind {
    pub(crate) const HELLO: u32 = 0;
    pub(crate) const CONNECT: u32 = 1;
    pub(crate) const DISCONNECT: u32 = 2;
    pub(crate) const RESET: u32 = 3;
    pub(crate) const INTERFACES: u32 = 4;
    pub(crate) const ENDPOINTS: u32 = 5;
    pub(crate) const SET_CONFIGURATION: u32 = 6;
    pub(crate) const GET_CONFIGURATION: u32 = 7;
    pub(crate) const CONFIGURATION: u32 = 8;
    pub(crate) const SET_ALTERNATE: u32 = 9;
    pub(crate) const GET_ALTERNATE: u32 = 10;
    pub(crate) const ALTERNATE: u32 = 11;
    pub(crate) const START_INTERRUPT: u32 = 15;
    pub(crate) const STOP_INTERRUPT: u32 = 16;
    pub(crate) const INTERRUPT_STATUS: u32 = 17;
    pub(crate) const CANCEL: u32 = 21;
    pub(crate) const DISCONNECT_ACK: u32 = 24;
    pub(crate) const CONTROL: u32 = 100;
    pub(crate) const BULK: u32 = 101;
    pub(crate) const INTERRUPT: u32 = 103;
}

/// Status of a request.
pub(super) mod status {
    pub(crate) const SUCCESS: u8 = 0;
    pub(crate) const CANCELLED: u8 = 1;
    pub(crate) const IO_ERROR: u8 = 3;
    pub(crate) const STALL: u8 = 4;
    pub(crate) const TIMED_OUT: u8 = 5;
    pub(crate) const BABBLE: u8 = 6;
}

/// Capabilities of this side: the device's version in the connection, an answer to a disconnection, packet sizes of the
/// endpoints, numbers of 64 bits, bulk lengths of 32 bits. Without the last three QEMU allows no SuperSpeed.
const CAPABILITIES: u32 = 1 << 1 | 1 << 3 | 1 << 4 | 1 << 5 | 1 << 6;
/// Longest message that is taken.
const LONGEST: usize = 1 << 24;

/// One message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Message {
    pub(super) kind: u32,
    pub(super) number: u64,
    pub(super) body: Vec<u8>,
}

impl Message {
    pub(super) fn new(kind: u32, number: u64, body: Vec<u8>) -> Self {
        Self { kind, number, body }
    }

    /// This side's hello: a name of 64 bytes, and what it can do.
    pub(super) fn hello() -> Self {
        let mut body = b"meniscus-hil".to_vec();
        body.resize(64, 0);
        body.extend(CAPABILITIES.to_le_bytes());
        Self::new(kind::HELLO, 0, body)
    }

    /// Its bytes.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let mut bytes = self.kind.to_le_bytes().to_vec();
        bytes.extend((self.body.len() as u32).to_le_bytes());
        match self.kind {
            kind::HELLO => bytes.extend((self.number as u32).to_le_bytes()),
            _ => bytes.extend(self.number.to_le_bytes()),
        }
        bytes.extend(&self.body);
        bytes
    }

    /// Reads one.
    pub(super) fn read(link: &mut impl Read) -> io::Result<Self> {
        let mut words = [[0; 4]; 3];
        for word in &mut words {
            link.read_exact(word)?;
        }
        let [kind, length, low] = words.map(u32::from_le_bytes);
        let mut number = u64::from(low);
        if kind != kind::HELLO {
            let mut high = [0; 4];
            link.read_exact(&mut high)?;
            number |= u64::from(u32::from_le_bytes(high)) << 32;
        }
        if length as usize > LONGEST {
            return Err(io::Error::new(io::ErrorKind::InvalidData, format!("a message of {length} bytes")));
        }
        let mut body = vec![0; length as usize];
        link.read_exact(&mut body)?;
        Ok(Self { kind, number, body })
    }

    /// A byte of the body; 0 behind its end.
    pub(super) fn byte(&self, place: usize) -> u8 {
        self.body.get(place).copied().unwrap_or(0)
    }

    fn word(&self, place: usize) -> u16 {
        u16::from_le_bytes([self.byte(place), self.byte(place + 1)])
    }
}

/// A control request: endpoint, request, type, status, value, index, length.
pub(super) struct Control {
    /// As on the bus.
    pub(super) setup: [u8; 8],
    header: [u8; 10],
}

impl Control {
    pub(super) fn read(message: &Message) -> Option<(Self, &[u8])> {
        let (header, sent) = message.body.split_first_chunk::<10>()?;
        let [_, request, of, _, value @ ..] = *header;
        let [v0, v1, i0, i1, l0, l1] = value;
        Some((Self { setup: [of, request, v0, v1, i0, i1, l0, l1], header: *header }, sent))
    }

    /// Most bytes that may come back.
    pub(super) fn length(&self) -> usize {
        usize::from(u16::from_le_bytes([self.header[8], self.header[9]]))
    }

    /// The answer: `done` bytes have gone over, which are `bytes` if they came back.
    pub(super) fn answer(&self, number: u64, status: u8, done: usize, bytes: &[u8]) -> Message {
        let mut body = self.header.to_vec();
        body[3] = status;
        body[8..10].copy_from_slice(&(done as u16).to_le_bytes());
        body.extend(bytes);
        Message::new(kind::CONTROL, number, body)
    }
}

/// Length that a bulk read asks for.
pub(super) fn bulk_length(message: &Message) -> usize {
    usize::from(message.word(2)) | usize::from(message.word(8)) << 16
}

/// The answer to a bulk read: endpoint, status, length (low), stream, length (high), bytes.
pub(super) fn bulk(number: u64, endpoint: u8, status: u8, bytes: &[u8]) -> Message {
    let [l0, l1, l2, l3] = (bytes.len() as u32).to_le_bytes();
    let mut body = vec![endpoint, status, l0, l1, 0, 0, 0, 0, l2, l3];
    body.extend(bytes);
    Message::new(kind::BULK, number, body)
}

/// A status packet of the interrupt endpoint.
pub(super) fn interrupt(number: u64, endpoint: u8, status: u8, bytes: &[u8]) -> Message {
    let [low, high] = (bytes.len() as u16).to_le_bytes();
    let mut body = vec![endpoint, status, low, high];
    body.extend(bytes);
    Message::new(kind::INTERRUPT, number, body)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_come_back_as_they_went() {
        for message in
            [Message::hello(), bulk(1 << 40, 0x82, 0, &[1, 2, 3]), Message::new(kind::RESET, 7, vec![])]
        {
            let bytes = message.bytes();
            assert_eq!(Message::read(&mut &bytes[..]).expect("whole"), message);
            assert!(Message::read(&mut &bytes[..bytes.len() - 1]).is_err(), "cut");
        }
        assert_eq!(Message::hello().bytes().len(), 12 + 68);
        let long = [kind::BULK.to_le_bytes(), u32::MAX.to_le_bytes(), [0; 4], [0; 4]].concat();
        assert!(Message::read(&mut &long[..]).is_err());
    }

    #[test]
    fn a_control_request_is_written_as_on_the_bus() {
        let body = vec![0x80, 6, 0x80, 0, 0, 2, 0, 0, 9, 0];
        let message = Message::new(kind::CONTROL, 3, body);
        let (control, sent) = Control::read(&message).expect("whole");
        assert_eq!((control.setup, control.length(), sent), ([0x80, 6, 0, 2, 0, 0, 9, 0], 9, &[][..]));
        let answer = control.answer(3, status::STALL, 0, &[]);
        assert_eq!(answer.body, [0x80, 6, 0x80, 4, 0, 2, 0, 0, 0, 0]);
    }

    #[test]
    fn a_bulk_length_has_32_bits() {
        let read = Message::new(kind::BULK, 1, vec![0x82, 0, 0, 4, 0, 0, 0, 0, 9, 0]);
        assert_eq!(bulk_length(&read), 9 << 16 | 1024);
    }
}
