//! Certificate and key of an encrypted page (TLS 1.3, by rustls): given as files, or made for one run.
//!
//! A certificate that is made here is signed by nobody else, so that a browser warns. Its SHA-256 fingerprint is printed where
//! the run starts, and whoever compares it with the browser's knows that nobody stands between.

use super::PageError;
use super::wire::Wire;
use crate::listener::TimedStream;
use meniscus_platform::files::{Links, read_regular};
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer, PrivatePkcs8KeyDer};
use rustls::{ServerConfig, ServerConnection, StreamOwned};
use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;

/// Longest file of a certificate chain or a key, bytes.
const LONGEST: u64 = 256 * 1024;

/// Certificate and key of a page.
#[derive(Clone)]
pub struct Tls {
    config: Arc<ServerConfig>,
    fingerprint: String,
}

impl std::fmt::Debug for Tls {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Tls").field("fingerprint", &self.fingerprint).finish_non_exhaustive()
    }
}

impl Tls {
    /// Makes a key and a certificate of it for this machine's loopback names and for `address`, for one run: neither is
    /// written anywhere.
    ///
    /// # Errors
    /// When the system gives no random numbers.
    pub fn self_signed(address: SocketAddr) -> Result<Self, PageError> {
        let refused = |why: &dyn ToString| {
            PageError::new("a certificate", why.to_string(), "give one by --tls-cert and --tls-key")
        };
        let own = ["localhost", "127.0.0.1", "::1"].map(String::from);
        let names: Vec<String> = own.into_iter().chain([address.ip().to_string()]).collect();
        let made = rcgen::generate_simple_self_signed(names).map_err(|error| refused(&error))?;
        let key = PrivatePkcs8KeyDer::from(made.signing_key.serialize_der());
        Self::of(vec![made.cert.into()], key.into()).map_err(|error| refused(&error))
    }

    /// Reads a certificate chain and its key, both PEM.
    ///
    /// # Errors
    /// When one of the files cannot be read or holds none, or when the key is not that of the certificate.
    pub fn from_files(certificate: &Path, key: &Path) -> Result<Self, PageError> {
        let read = |what: &str, path: &Path| {
            read_regular(path, LONGEST, Links::Followed).map_err(|error| {
                PageError::new(
                    format!("the {what} in {}", path.display()),
                    error.to_string(),
                    "name a PEM file",
                )
            })
        };
        let none = |what: &str, path: &Path, start: &str| {
            let why = format!("it has no part -----BEGIN {start}-----");
            PageError::new(
                format!("the {what} in {}", path.display()),
                why,
                "write it as PEM, as openssl does",
            )
        };
        let chain: Vec<CertificateDer<'static>> =
            CertificateDer::pem_slice_iter(&read("certificate", certificate)?).flatten().collect();
        if chain.is_empty() {
            return Err(none("certificate", certificate, "CERTIFICATE"));
        }
        let own = PrivateKeyDer::from_pem_slice(&read("key", key)?);
        let own = own.map_err(|_| none("key", key, "PRIVATE KEY"))?;
        Self::of(chain, own).map_err(|error| {
            let both = format!("{} with the key {}", certificate.display(), key.display());
            let why = match error {
                rustls::Error::InconsistentKeys(_) => "the key is not that of the certificate".into(),
                other => other.to_string(),
            };
            PageError::new(
                both,
                why,
                "give the key that the certificate was made with, and a certificate for servers",
            )
        })
    }

    fn of(chain: Vec<CertificateDer<'static>>, key: PrivateKeyDer<'static>) -> Result<Self, rustls::Error> {
        let first = chain.first().ok_or(rustls::Error::NoCertificatesPresented)?;
        let digest = ring::digest::digest(&ring::digest::SHA256, first);
        let hex: Vec<String> = digest.as_ref().iter().map(|byte| format!("{byte:02X}")).collect();
        let provider = Arc::new(rustls::crypto::ring::default_provider());
        let config = ServerConfig::builder_with_provider(provider)
            .with_protocol_versions(&[&rustls::version::TLS13])?
            .with_no_client_auth()
            .with_single_cert(chain, key)?;
        Ok(Self { config: Arc::new(config), fingerprint: hex.join(":") })
    }

    /// Returns the SHA-256 of the certificate, as browsers and openssl show it.
    #[must_use]
    pub fn fingerprint(&self) -> &str {
        &self.fingerprint
    }

    /// Returns `stream`, encrypted from its first byte on.
    pub(super) fn wire(&self, stream: TimedStream) -> Option<Wire> {
        let connection = ServerConnection::new(Arc::clone(&self.config)).ok()?;
        Some(Wire::Encrypted(Box::new(StreamOwned::new(connection, stream))))
    }
}
