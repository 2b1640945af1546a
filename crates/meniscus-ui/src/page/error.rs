//! Why there is no page.

use std::io::ErrorKind;
use std::net::SocketAddr;

/// Fault, reason and remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PageError {
    what: String,
    why: String,
    remedy: String,
}

impl PageError {
    /// `what` cannot be because of `why`.
    pub(super) fn new(what: impl Into<String>, why: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { what: what.into(), why: why.into(), remedy: remedy.into() }
    }

    /// The system's reason why nothing can listen at `address`.
    pub(super) fn of_listening(address: SocketAddr, error: &std::io::Error) -> Self {
        let next = SocketAddr::new(address.ip(), address.port().saturating_add(1));
        let (why, remedy) = match error.kind() {
            ErrorKind::AddrInUse => (
                "another program listens there, perhaps another run".into(),
                format!("end it, or choose another port: --listen {next}"),
            ),
            ErrorKind::PermissionDenied => (
                "ports below 1024 belong to the system".into(),
                "choose a higher one, such as --listen 127.0.0.1:8060".into(),
            ),
            ErrorKind::AddrNotAvailable => (
                "this machine does not have that address".into(),
                "choose one that `ip address` shows, or --listen 0.0.0.0:8060 for all".into(),
            ),
            _ => (format!("{error}"), "choose another address: --listen 127.0.0.1:8060".into()),
        };
        Self { what: format!("a page at {address}"), why, remedy }
    }
}

impl std::fmt::Display for PageError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} cannot be used: {}. What to do: {}", self.what, self.why, self.remedy)
    }
}

impl std::error::Error for PageError {}
