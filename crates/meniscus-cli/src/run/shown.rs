//! Views of a run: the live page in a browser and the dashboard in the terminal, as long as the run lasts.

use super::config::{Encryption, PageConfig};
use meniscus::blob::Model;
use meniscus::surface::Config;
use meniscus_data::validity::Validity;
use meniscus_service::run::RunState;
pub(super) use meniscus_ui::page::Page;
use meniscus_ui::page::{Door, Tls, Token};
use meniscus_ui::terminal::{Caption, Dashboard};
use std::net::SocketAddr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

impl Encryption {
    /// Returns certificate and key of a page at `address`.
    fn tls(&self, address: SocketAddr) -> anyhow::Result<Option<Tls>> {
        Ok(match self {
            Self::None => None,
            Self::Made => Some(Tls::self_signed(address)?),
            Self::Given { certificate, key } => Some(Tls::from_files(certificate, key)?),
        })
    }
}

/// Opens the page and says where.
pub(super) fn open(
    config: &PageConfig,
    model: &Model<'_>,
    reader: Config,
    title: &str,
) -> anyhow::Result<Page> {
    let token = match &config.token_file {
        Some(path) => Some(Token::from_file(path)?),
        None if config.listen.ip().is_loopback() => None,
        None => Some(Token::generate()?),
    };
    let tls = config.encryption.tls(config.listen)?;
    let fingerprint = tls.as_ref().map(|tls| tls.fingerprint().to_owned());
    let page = Page::open_at(model, reader, title, Door { address: config.listen, token, tls })?;
    eprintln!("live page: {}", page.url());
    if let Some(fingerprint) = fingerprint {
        eprintln!("SHA-256 of its certificate: {fingerprint}");
    } else if !page.address().ip().is_loopback() {
        eprintln!("whoever has this whole address can watch; the way there is not encrypted (--tls)");
    }
    eprintln!("Ctrl-C ends the run");
    Ok(page)
}

/// Waits until the run has `finished`: the page shows it.
pub(super) fn attend(finished: &dyn Fn() -> bool) {
    while !finished() {
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Closes the page and says what became of its frames.
pub(super) fn close(page: Page) {
    let of = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
    let counters = page.counters();
    eprintln!(
        "page: {} viewers came, {} frames sent ({:.1} MB), {} left out for want of room, {} requests refused",
        of(&counters.came),
        of(&counters.sent),
        of(&counters.bytes) as f64 * 1e-6,
        of(&counters.left_out),
        of(&counters.refused)
    );
}

/// Shows the dashboard until the run has `finished` or a person ends it.
pub(super) fn dashboard(
    model: &Model<'_>,
    title: String,
    length: Duration,
    state: &RunState,
    finished: &dyn Fn() -> bool,
) -> std::io::Result<()> {
    let validity = Validity::of(&model.header);
    Dashboard::new(model, Caption { title, length, validity }).run(state, finished)
}
