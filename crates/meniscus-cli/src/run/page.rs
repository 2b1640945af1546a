//! `--view`: the live page, as long as the run lasts.

use super::config::PageConfig;
use meniscus::blob::Model;
use meniscus::surface::Config;
use meniscus_ui::page::{ADDRESS, Page, Token};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

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
}

/// Reads an address with its port.
pub(super) fn address(text: &str) -> Result<SocketAddr, String> {
    text.parse()
        .map_err(|_| String::from("expected ADDRESS:PORT in numbers, as 127.0.0.1:8060 or 0.0.0.0:8060"))
}

impl PageArguments {
    /// Returns the page's configuration; `None` without `--view`.
    pub(super) fn config(&self) -> Option<PageConfig> {
        self.view.then(|| PageConfig { listen: self.listen, token_file: self.token_file.clone() })
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
    let page = Page::open(model, reader, title, config.listen, token)?;
    eprintln!("live page: {}", page.url());
    if !page.address().ip().is_loopback() {
        eprintln!("whoever has this whole address can watch; the way there is not encrypted");
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
