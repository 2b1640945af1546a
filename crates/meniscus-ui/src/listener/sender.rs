//! Check of a request's sender by its `Host` and `Origin`.
//!
//! A browser says in `Origin` whose page asks, and in `Host` by which name it reached the machine. Any page on the web can
//! make a browser connect to 127.0.0.1, and can give its own name the address 127.0.0.1 (DNS rebinding). The first shows in
//! `Origin`, the second in `Host`. Other programs need send no `Origin`.

use std::net::IpAddr;
use tungstenite::handshake::server::Request;

/// Names of the machine under which a server answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Hosts {
    /// `localhost` and loopback addresses.
    ThisMachine,
    /// Any name: something else, as a token, guards the server.
    Any,
}

/// Senders that a server answers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Senders<'s> {
    /// Names of the machine.
    pub(crate) hosts: Hosts,
    /// Origins that may ask besides the server's own, as `https://app.example`.
    pub(crate) origins: &'s [String],
}

/// Fault of a sender.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SenderFault {
    /// Not exactly one readable `Host` (RFC 9112, section 3.2), or more than one `Origin`.
    Malformed,
    /// A name that a page of somebody else may have made up.
    Host,
    /// A page of somebody else asks.
    Origin,
}

/// Checks that `request` comes from one of `senders`.
pub(crate) fn check_sender(request: &Request, senders: Senders<'_>) -> Result<(), SenderFault> {
    let host = only(request, "host")?.ok_or(SenderFault::Malformed)?;
    if senders.hosts == Hosts::ThisMachine && !is_this_machine(host) {
        return Err(SenderFault::Host);
    }
    match only(request, "origin")? {
        Some(origin) if !is_own(origin, host) && !senders.origins.iter().any(|one| one == origin) => {
            Err(SenderFault::Origin)
        }
        _ => Ok(()),
    }
}

/// Returns the only value of a header; more than one, or one that is no text, is a fault.
fn only<'r>(request: &'r Request, name: &str) -> Result<Option<&'r str>, SenderFault> {
    let mut values = request.headers().get_all(name).iter();
    let first = values.next();
    if values.next().is_some() {
        return Err(SenderFault::Malformed);
    }
    first.map(|value| value.to_str().map_err(|_| SenderFault::Malformed)).transpose()
}

/// Whether `origin` is a page of the server itself. A tunnel or proxy may have put TLS before it.
fn is_own(origin: &str, host: &str) -> bool {
    ["http://", "https://"]
        .iter()
        .any(|scheme| origin.strip_prefix(scheme).is_some_and(|from| from.eq_ignore_ascii_case(host)))
}

/// Whether a `Host` names this machine from inside: `localhost` or a loopback address, with any port.
fn is_this_machine(host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if !port.is_empty() && port.bytes().all(|b| b.is_ascii_digit()) => name,
        _ => host,
    };
    let literal = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')).unwrap_or(name);
    name.eq_ignore_ascii_case("localhost")
        || literal.parse::<IpAddr>().is_ok_and(|address| address.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::listener::read;

    fn checked(senders: Senders<'_>, headers: &str) -> Result<(), SenderFault> {
        let head = format!("GET / HTTP/1.1\r\n{headers}\r\n");
        check_sender(&read(&mut head.as_bytes()).expect("a head").request, senders)
    }

    #[test]
    fn names_of_this_machine_pass_and_others_do_not() {
        let senders = Senders { hosts: Hosts::ThisMachine, origins: &[] };
        for host in ["localhost:8060", "127.0.0.1", "127.0.0.1:9", "[::1]:8060", "LOCALHOST:9"] {
            assert_eq!(checked(senders, &format!("Host: {host}\r\n")), Ok(()), "{host}");
        }
        for host in ["evil.example", "127.0.0.1.evil.example", "10.0.0.5:80", "localhost.evil:80", "", "[::1"]
        {
            assert_eq!(checked(senders, &format!("Host: {host}\r\n")), Err(SenderFault::Host), "{host}");
        }
        for heads in ["", "Host: localhost\r\nHost: localhost\r\n", "Host: localhost\r\nHost: evil\r\n"] {
            assert_eq!(checked(senders, heads), Err(SenderFault::Malformed), "{heads}");
        }
    }

    #[test]
    fn only_own_and_listed_origins_pass() {
        let listed = ["https://app.example".to_owned()];
        let senders = Senders { hosts: Hosts::Any, origins: &listed };
        let of = |origin: &str| checked(senders, &format!("Host: board:8060\r\nOrigin: {origin}\r\n"));
        for origin in ["http://board:8060", "https://board:8060", "https://app.example"] {
            assert_eq!(of(origin), Ok(()), "{origin}");
        }
        let foreign = [
            "http://evil.example",
            "foo://board:8060",
            "http://board:8061",
            "null",
            "file://",
            "http://app.example",
            "https://app.example.evil",
            "",
        ];
        for origin in foreign {
            assert_eq!(of(origin), Err(SenderFault::Origin), "{origin}");
        }
        let two = "Host: board:8060\r\nOrigin: http://board:8060\r\nOrigin: http://evil.example\r\n";
        assert_eq!(checked(senders, two), Err(SenderFault::Malformed));
    }
}
