//! The place of `Tls` in a build without it: there is no value of it.

use super::PageError;
use super::wire::Wire;
use crate::listener::TimedStream;
use std::net::SocketAddr;
use std::path::Path;

/// Certificate and key of a page, which this build cannot use.
#[derive(Clone, Debug)]
pub enum NoTls {}

impl NoTls {
    /// Refuses.
    ///
    /// # Errors
    /// Always.
    pub fn self_signed(_: SocketAddr) -> Result<Self, PageError> {
        Err(absent())
    }

    /// Refuses.
    ///
    /// # Errors
    /// Always.
    pub fn from_files(_: &Path, _: &Path) -> Result<Self, PageError> {
        Err(absent())
    }

    /// Returns the SHA-256 of the certificate.
    #[must_use]
    pub fn fingerprint(&self) -> &str {
        match *self {}
    }

    pub(super) fn wire(&self, _: TimedStream) -> Option<Wire> {
        match *self {}
    }
}

fn absent() -> PageError {
    PageError::new("an encrypted page", "this build has no TLS", "build with --features tls")
}
