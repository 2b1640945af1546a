//! Where estimates go, as a person writes it: `unix:PATH`, `udp:HOST:PORT`, `serial:DEVICE[@BAUD]`.

use std::net::{SocketAddr, ToSocketAddrs};
use std::path::PathBuf;

/// Default speed of a serial line, which all adapters and boards reach.
const BAUD: u32 = 921_600;

/// One destination.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Destination {
    /// A Unix stream socket that others connect to; its owner and group may, nobody else.
    Unix(PathBuf),
    /// Datagrams to one address.
    Udp(SocketAddr),
    /// A serial line, eight bits, no parity, one stop bit, no flow control.
    Serial(PathBuf, u32),
}

/// Fault of a destination, its reason and a remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DestinationError {
    what: String,
    why: String,
    remedy: String,
}

impl DestinationError {
    pub(super) fn new(what: impl Into<String>, why: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { what: what.into(), why: why.into(), remedy: remedy.into() }
    }
}

impl std::fmt::Display for DestinationError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "cannot publish to {}: {}. What to do: {}", self.what, self.why, self.remedy)
    }
}

impl std::error::Error for DestinationError {}

impl std::str::FromStr for Destination {
    type Err = DestinationError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let wrong = |why: &str| {
            let forms = "write unix:/run/meniscus.sock, udp:192.168.1.5:7000 or serial:/dev/ttyUSB0@921600";
            DestinationError::new(format!("'{text}'"), why, forms)
        };
        let (kind, rest) = text.split_once(':').ok_or_else(|| wrong("it names no kind"))?;
        match kind {
            _ if rest.is_empty() => Err(wrong("nothing follows the colon")),
            "unix" => Ok(Self::Unix(rest.into())),
            "udp" => {
                let mut found = rest.to_socket_addrs().map_err(|error| wrong(&error.to_string()))?;
                found.next().map(Self::Udp).ok_or_else(|| wrong("the host has no address"))
            }
            "serial" => match rest.rsplit_once('@') {
                None => Ok(Self::Serial(rest.into(), BAUD)),
                Some((device, baud)) => {
                    let baud = baud.parse().ok().filter(|baud| (1200..=4_000_000).contains(baud));
                    let baud = baud.ok_or_else(|| wrong("the speed is no number from 1200 to 4000000"))?;
                    Ok(Self::Serial(device.into(), baud))
                }
            },
            _ => Err(wrong("the kind is none of unix, udp, serial")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn destinations_are_read() {
        assert_eq!("unix:/run/m.sock".parse(), Ok(Destination::Unix("/run/m.sock".into())));
        let here = "127.0.0.1:7000".parse().expect("an address");
        assert_eq!("udp:127.0.0.1:7000".parse(), Ok(Destination::Udp(here)));
        assert_eq!("serial:/dev/ttyS0@9600".parse(), Ok(Destination::Serial("/dev/ttyS0".into(), 9600)));
        assert_eq!("serial:/dev/ttyS0".parse(), Ok(Destination::Serial("/dev/ttyS0".into(), BAUD)));
    }

    #[test]
    fn what_is_none_is_refused_with_a_remedy() {
        for text in
            ["", "unix:", "tcp:1.2.3.4:5", "udp:nowhere", "serial:/dev/ttyS0@fast", "serial:/dev/ttyS0@7"]
        {
            let error = text.parse::<Destination>().expect_err(text);
            assert!(format!("{error}").contains("What to do: write unix:"), "{error}");
        }
    }
}
