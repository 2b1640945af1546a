//! USB/IP on the wire: 48-byte headers, big-endian (Documentation/usb/usbip_protocol.rst in the kernel).
//!
//! | word | submit | its answer | unlink | its answer |
//! |---|---|---|---|---|
//! | 0 | 1 | 3 | 2 | 4 |
//! | 1 | number of the request | the same | own number | the same |
//! | 3, 4 | direction (1 is in), endpoint | 0 | 0 | 0 |
//! | 5 | flags | status | number of the submit | status |
//! | 6 | bytes of the buffer | bytes that came | | |
//! | 10, 11 | setup packet | | | |

/// Bytes of a header.
pub(super) const HEADER: usize = 48;

/// Message from the kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Command {
    /// A request block.
    Submit {
        /// Its number.
        number: u32,
        /// Endpoint address, with the direction bit.
        endpoint: u8,
        /// Bytes of its buffer; of an outgoing one, they follow.
        length: usize,
        /// Setup packet, of a control request.
        setup: [u8; 8],
    },
    /// The request block of that number is no longer wanted.
    Unlink {
        /// Its own number.
        number: u32,
        /// The number of the other one.
        other: u32,
    },
}

/// Linux error numbers that end a request block.
pub(super) mod status {
    pub(crate) const PIPE: i32 = -32;
    pub(crate) const PROTOCOL: i32 = -71;
    pub(crate) const OVERFLOW: i32 = -75;
    pub(crate) const UNLINKED: i32 = -104;
    pub(crate) const TIMED_OUT: i32 = -110;
}

impl Command {
    /// Reads a header; `None` for a command that is none.
    pub(super) fn read(header: &[u8; HEADER]) -> Option<Self> {
        let (words, _) = header.as_chunks::<4>();
        let word = |at: usize| words.get(at).map_or(0, |bytes| u32::from_be_bytes(*bytes));
        match word(0) {
            1 => {
                let mut setup = [0; 8];
                setup.copy_from_slice(&header[40..]);
                let inwards = if word(3) == 1 { 0x80 } else { 0 };
                let endpoint = (word(4) & 0x0f) as u8 | inwards;
                Some(Self::Submit { number: word(1), endpoint, length: word(6) as usize, setup })
            }
            2 => Some(Self::Unlink { number: word(1), other: word(5) }),
            _ => None,
        }
    }
}

/// The answer to a submit; the bytes of an incoming one follow.
pub(super) fn submitted(number: u32, status: i32, length: usize) -> [u8; HEADER] {
    answer(3, number, status, length as u32)
}

/// The answer to an unlink.
pub(super) fn unlinked(number: u32, status: i32) -> [u8; HEADER] {
    answer(4, number, status, 0)
}

fn answer(command: u32, number: u32, status: i32, length: u32) -> [u8; HEADER] {
    let mut header = [0; HEADER];
    for (at, word) in [(0, command), (1, number), (5, status.cast_unsigned()), (6, length)] {
        header[4 * at..4 * at + 4].copy_from_slice(&word.to_be_bytes());
    }
    header
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_read_as_the_kernel_writes_them() {
        let mut header = [0; HEADER];
        for (at, word) in [(0, 1), (1, 77), (2, 0x0001_0002), (3, 1), (4, 2), (5, 0x200), (6, 615_424)] {
            header[4 * at..4 * at + 4].copy_from_slice(&u32::to_be_bytes(word));
        }
        header[40..].copy_from_slice(&[0x80, 6, 0, 2, 0, 0, 9, 0]);
        let setup = [0x80, 6, 0, 2, 0, 0, 9, 0];
        let submit = Command::Submit { number: 77, endpoint: 0x82, length: 615_424, setup };
        assert_eq!(Command::read(&header), Some(submit));
        header[3] = 2;
        header[20..24].copy_from_slice(&[0, 0, 0, 76]);
        assert_eq!(Command::read(&header), Some(Command::Unlink { number: 77, other: 76 }));
        header[3] = 9;
        assert_eq!(Command::read(&header), None);
    }

    #[test]
    fn answers_have_their_status_and_length_in_place() {
        let header = submitted(5, status::PIPE, 18);
        assert_eq!(header[..8], [0, 0, 0, 3, 0, 0, 0, 5]);
        assert_eq!(header[20..28], [0xff, 0xff, 0xff, 0xe0, 0, 0, 0, 18]);
        assert_eq!(unlinked(6, status::UNLINKED)[20..24], [0xff, 0xff, 0xff, 0x98]);
    }
}
