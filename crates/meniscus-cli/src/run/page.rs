//! `--view`: the live page, as long as the run lasts.

use meniscus::blob::Model;
use meniscus::surface::Config;
use meniscus_ui::page::{ADDRESS, Page, Token};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// What a person says about the page.
#[derive(clap::Args)]
pub(super) struct PageArguments {
    /// Show the run in a browser: prints the address of a live page that the program itself serves. A recording then
    /// begins again where it ends, until Ctrl-C or --seconds.
    #[arg(long)]
    pub(super) view: bool,
    /// Where the page is. Any address that other machines reach, such as 0.0.0.0:8060, makes a token that the page's
    /// address then holds.
    #[arg(long, value_name = "ADDRESS:PORT", default_value_t = ADDRESS, requires = "view")]
    listen: SocketAddr,
    /// Take the token from the first line of this file instead of a new one, on loopback too.
    #[arg(long, value_name = "FILE", requires = "view")]
    token_file: Option<PathBuf>,
}

impl PageArguments {
    /// Opens the page and says where; `None` without `--view`.
    pub(super) fn open(
        &self,
        model: &Model<'_>,
        config: Config,
        title: &str,
    ) -> anyhow::Result<Option<Page>> {
        if !self.view {
            return Ok(None);
        }
        let token = match &self.token_file {
            Some(path) => Some(Token::from_file(path)?),
            None if self.listen.ip().is_loopback() => None,
            None => Some(Token::generate()?),
        };
        let page = Page::open(model, config, title, self.listen, token)?;
        eprintln!("live page: {}", page.url());
        if !page.address().ip().is_loopback() {
            eprintln!("whoever has this whole address can watch; the way there is not encrypted");
        }
        eprintln!("Ctrl-C ends the run");
        Ok(Some(page))
    }
}

/// Waits until the run has `finished`, where the page is what is looked at.
pub(super) fn attend(finished: impl Fn() -> bool) {
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
