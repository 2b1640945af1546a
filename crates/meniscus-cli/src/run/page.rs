//! `--view`: flags of the live page.

use super::config::{Encryption, PageConfig};
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;

/// Default of --listen.
const ADDRESS: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 8060);

/// Flags of the live page.
#[derive(clap::Args)]
pub(super) struct PageArguments {
    /// Show the run on a live page in a browser; its address is printed.
    ///
    /// A recording begins again where it ends, until Ctrl-C or --seconds.
    #[arg(long, help_heading = "Live view")]
    pub(super) view: bool,
    /// Address of the page.
    ///
    /// An address that other machines reach, such as 0.0.0.0:8060, makes a token, which the printed address then holds.
    #[arg(
        long,
        value_name = "ADDRESS:PORT",
        default_value_t = ADDRESS,
        requires = "view",
        help_heading = "Live view",
        value_parser = address
    )]
    listen: SocketAddr,
    /// File whose first line is the token, on loopback too.
    #[arg(long, value_name = "FILE", requires = "view", help_heading = "Live view")]
    token_file: Option<PathBuf>,
    /// Encrypt the page (TLS 1.3).
    ///
    /// Without --tls-cert a certificate is made for this run. A browser warns of it: compare the printed SHA-256 with the
    /// fingerprint that the browser shows, and go on only if both are the same.
    #[arg(long, requires = "view", help_heading = "Live view")]
    tls: bool,
    /// Certificate of the encrypted page, PEM, with those that signed it behind it.
    #[arg(long, value_name = "FILE", requires_all = ["view", "tls_key"], help_heading = "Live view")]
    tls_cert: Option<PathBuf>,
    /// Key of the certificate, PEM.
    #[arg(long, value_name = "FILE", requires_all = ["view", "tls_cert"], help_heading = "Live view")]
    tls_key: Option<PathBuf>,
}

/// Reads an address with its port.
pub(super) fn address(text: &str) -> Result<SocketAddr, String> {
    text.parse()
        .map_err(|_| String::from("expected ADDRESS:PORT in numbers, as 127.0.0.1:8060 or 0.0.0.0:8060"))
}

impl PageArguments {
    /// Returns the page's configuration; `None` without `--view`.
    pub(super) fn config(&self) -> Option<PageConfig> {
        let certificate = match (&self.tls_cert, &self.tls_key) {
            (Some(certificate), Some(key)) => {
                Encryption::Given { certificate: certificate.clone(), key: key.clone() }
            }
            _ if self.tls => Encryption::Made,
            _ => Encryption::None,
        };
        let token_file = self.token_file.clone();
        self.view.then_some(PageConfig { listen: self.listen, token_file, encryption: certificate })
    }
}
