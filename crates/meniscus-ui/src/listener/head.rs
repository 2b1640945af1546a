//! Head of one request, read within limits of length and time.

use std::io::{ErrorKind, Read};
use std::time::Duration;
use tungstenite::handshake::machine::TryParse;
use tungstenite::handshake::server::Request;

/// Longest head, bytes.
pub(crate) const HEAD_MAX: usize = 8 * 1024;

/// Longest time for a whole head. The stream has to end its reads by then ([`TimedStream`](super::TimedStream)).
pub(crate) const HEAD_WITHIN: Duration = Duration::from_secs(5);

/// Fault of a head.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HeadFault {
    /// No head of this kind.
    Malformed,
    /// More than [`HEAD_MAX`] bytes.
    TooLong,
    /// It did not come in time.
    Slow,
}

/// A head that is whole.
#[derive(Debug)]
pub(crate) struct Head {
    /// The parsed request.
    pub(crate) request: Request,
    /// All bytes that came: the head, and what was behind it.
    pub(crate) bytes: Vec<u8>,
    /// Length of the head, bytes.
    length: usize,
}

impl Head {
    /// Bytes that came behind it.
    pub(crate) fn rest(&self) -> &[u8] {
        self.bytes.get(self.length..).unwrap_or_default()
    }
}

/// Reads a head from `stream`.
pub(crate) fn read(stream: &mut impl Read) -> Result<Head, HeadFault> {
    let mut bytes = Vec::with_capacity(1024);
    let mut part = [0; 1024];
    loop {
        match stream.read(&mut part) {
            Ok(0) => return Err(HeadFault::Malformed),
            Ok(length) => bytes.extend_from_slice(part.get(..length).unwrap_or_default()),
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                return Err(HeadFault::Slow);
            }
            Err(_) => return Err(HeadFault::Malformed),
        }
        match Request::try_parse(&bytes) {
            // The last part may have carried a whole head beyond the limit.
            Ok(Some((length, _))) if length > HEAD_MAX => return Err(HeadFault::TooLong),
            Ok(Some((length, request))) => {
                return Ok(Head { request, bytes, length });
            }
            Ok(None) if bytes.len() > HEAD_MAX => return Err(HeadFault::TooLong),
            Ok(None) => {}
            Err(_) => return Err(HeadFault::Malformed),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_head_of_the_limit_passes_and_one_byte_more_does_not() {
        let head = |length: usize| {
            let frame = "GET / HTTP/1.1\r\nHost: localhost\r\nX: \r\n\r\n".len();
            format!("GET / HTTP/1.1\r\nHost: localhost\r\nX: {}\r\n\r\n", "y".repeat(length - frame))
        };
        assert!(read(&mut head(HEAD_MAX).as_bytes()).is_ok());
        assert_eq!(read(&mut head(HEAD_MAX + 1).as_bytes()).err(), Some(HeadFault::TooLong));
    }

    #[test]
    fn the_bytes_are_those_that_came() {
        let text = "GET /a HTTP/1.1\r\nHost: localhost\r\n\r\n";
        let head = read(&mut format!("{text}behind").as_bytes()).expect("a head");
        assert_eq!(head.rest(), b"behind");
        assert_eq!(head.bytes, format!("{text}behind").as_bytes());
    }
}
