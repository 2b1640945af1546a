//! One connection as the places see it: its address, and how far it has come.

use super::head::HEAD_MAX;
use rustix::net::RecvFlags;
use std::io::Result;
use std::net::{IpAddr, Ipv6Addr, TcpStream};
use std::sync::Arc;

/// Stage of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// Its request has not come yet.
    Silent,
    /// Its request has come, and is read or answered.
    Asking,
    /// It stays.
    Guest,
}

/// One connection.
#[derive(Debug)]
pub(super) struct Entry {
    /// Number in the order of arrival.
    pub(super) number: u64,
    /// Address that it is counted under.
    pub(super) address: IpAddr,
    /// Its stage, as far as it was seen.
    pub(super) stage: Stage,
    /// The connection itself.
    pub(super) stream: Arc<TcpStream>,
}

impl Entry {
    /// Returns whether it is of `address` and at `stage`.
    pub(super) fn is(&self, address: IpAddr, stage: Stage) -> bool {
        self.address == address && self.stage == stage
    }

    /// Returns whether it stays.
    pub(super) fn is_guest(&self) -> bool {
        self.stage == Stage::Guest
    }

    /// Returns whether a whole request lies unread in its buffer.
    pub(super) fn has_asked(&self) -> bool {
        let flags = RecvFlags::PEEK | RecvFlags::DONTWAIT;
        peeks_request(|head| Ok(rustix::net::recv(&self.stream, head, flags)?.0))
    }
}

/// Returns whether `peek`, which copies waiting bytes, finds a whole request.
pub(super) fn peeks_request(peek: impl FnOnce(&mut [u8]) -> Result<usize>) -> bool {
    let mut head = [0; HEAD_MAX];
    let waiting = peek(&mut head).unwrap_or(0);
    head.get(..waiting).is_some_and(is_whole)
}

/// Returns whether `bytes` have the empty line that ends a request's head, or the first message of a TLS handshake.
///
/// Source: RFC 8446, section 5.1: a record is its kind, 22 for a handshake, two bytes of version, two of length, and so many
/// bytes.
fn is_whole(bytes: &[u8]) -> bool {
    match bytes {
        [22, _, _, high, low, message @ ..] => {
            message.len() >= usize::from(u16::from_be_bytes([*high, *low]))
        }
        _ => bytes.windows(4).any(|four| four == b"\r\n\r\n"),
    }
}

/// Returns the address that a peer's connections are counted under.
pub(super) fn counted(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => {
            let [a, b, c, d, ..] = address.segments();
            Ipv6Addr::new(a, b, c, d, 0, 0, 0, 0).into()
        }
        v4 @ IpAddr::V4(_) => v4,
    }
}

#[cfg(test)]
mod tests {
    use super::{counted, is_whole};

    #[test]
    fn a_part_of_a_request_is_none() {
        assert!(is_whole(b"GET / HTTP/1.1\r\n\r\n") && is_whole(&[22, 3, 1, 0, 2, 1, 0]));
        assert!(
            !is_whole(b"GET / HTTP/1.1\r\n") && !is_whole(&[22, 3, 1, 0, 2, 1]) && !is_whole(&[22, 3, 1])
        );
        assert!(!is_whole(&[]));
    }

    #[test]
    fn a_network_of_ipv6_counts_as_one_address() {
        let of = |text: &str| counted(text.parse().expect("an address"));
        assert_eq!(of("2001:db8::1"), of("2001:db8::ffff:2"));
        assert_ne!(of("2001:db8::1"), of("2001:db8:0:1::1"));
        assert_eq!(of("::ffff:10.0.0.1"), of("10.0.0.1"));
    }
}
