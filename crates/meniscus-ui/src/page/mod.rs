//! The live page: one page from the program itself, in any browser that can reach it.
//!
//! ```text
//! worker --SnapshotOutlet (never waits)--> hand-off --> composer's thread --> board --> a thread for each viewer
//!          newest turn, estimator's memory, image      frames, forecasts, JPEG          newest frame, when taken
//! ```
//! Loopback needs no token; every other address does. Either may be encrypted. Nothing is composed while nobody looks. The bytes are in
//! `docs/page.md`, the page's own files in `assets/`.

mod assets;
mod bases;
mod board;
mod compose;
mod error;
mod frame;
mod image;
mod messages;
mod metrics;
mod recent_error;
mod request;
mod server;
#[cfg(not(feature = "tls"))]
#[path = "no_tls.rs"]
mod tls;
#[cfg(feature = "tls")]
mod tls;
mod token;
mod viewer;
mod wire;

pub use board::Counters;
pub use error::PageError;
pub use messages::{Messages, messages};
pub use server::{VIEWERS_EACH, VIEWERS_MAX};
#[cfg(not(feature = "tls"))]
pub use tls::NoTls as Tls;
#[cfg(feature = "tls")]
pub use tls::Tls;
pub use token::Token;

use board::Board;
use meniscus::blob::Model;
use meniscus::surface::Config;
use meniscus_service::run::Viewer;
use meniscus_service::snapshot::SnapshotOutlet;
use meniscus_service::truth::Truth;
use server::Server;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::Arc;

/// Default address of the page.
pub const ADDRESS: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 8060);

/// An open page; dropping it closes it for everybody.
#[derive(Debug)]
pub struct Page {
    server: Server,
    outlet: SnapshotOutlet,
    board: Arc<Board>,
    config: Config,
    truth: Option<Truth>,
    door: Door,
    load_bytes: usize,
}

/// Way to the page.
#[derive(Clone, Debug)]
pub struct Door {
    /// Address to listen at.
    pub address: SocketAddr,
    /// Word that everybody has to know; without one, only this machine is answered.
    pub token: Option<Token>,
    /// Certificate and key; without them nothing is encrypted.
    pub tls: Option<Tls>,
}

impl Page {
    /// Opens the page of a run with `model` and `config` at `address`; `title` says what is looked at. Without a
    /// `token` only this machine is answered.
    ///
    /// # Errors
    /// When nothing can listen there, or a token is missing for an address that others reach.
    pub fn open(
        model: &Model<'_>,
        config: Config,
        title: &str,
        address: SocketAddr,
        token: Option<Token>,
    ) -> Result<Self, PageError> {
        Self::open_at(model, config, title, Door { address, token, tls: None })
    }

    /// Opens the page at `door`, as [`open`](Self::open) does.
    ///
    /// # Errors
    /// As for [`open`](Self::open).
    pub fn open_at(model: &Model<'_>, config: Config, title: &str, door: Door) -> Result<Self, PageError> {
        let address = door.address;
        if door.token.is_none() && !address.ip().is_loopback() {
            let why = "others reach that address, and no token keeps them out";
            return Err(PageError::new(format!("a page at {address}"), why, "give a token"));
        }
        let board = Arc::new(Board::default());
        let bases: tungstenite::Bytes = bases::bases(model, title).into();
        let load_bytes = bases.len();
        let gate = request::Gate { token: door.token.clone() };
        let server =
            Server::start(address, server::Front { gate, tls: door.tls.clone() }, bases, Arc::clone(&board))?;
        let (width, height) = config.image_size();
        let outlet = SnapshotOutlet::new(width * height);
        Ok(Self { server, outlet, board, config, truth: None, door, load_bytes })
    }

    /// Returns the page that shows the true surface beside the estimate.
    #[must_use]
    pub fn with_truth(self, truth: Option<Truth>) -> Self {
        Self { truth, ..self }
    }

    /// Bytes that every viewer loads once, beside the page's own files.
    #[must_use]
    pub fn load_bytes(&self) -> usize {
        self.load_bytes
    }

    /// Returns the counts of frames and viewers.
    #[must_use]
    pub fn counters(&self) -> &Counters {
        &self.board.counters
    }

    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.server.address()
    }

    /// Returns the address for a browser, the token included.
    #[must_use]
    pub fn url(&self) -> String {
        let mut address = self.address();
        if address.ip().is_unspecified() {
            address.set_ip(own_address(address).unwrap_or(address.ip()));
        }
        let scheme = if self.door.tls.is_some() { "https" } else { "http" };
        match &self.door.token {
            None => format!("{scheme}://{address}/"),
            Some(token) => format!("{scheme}://{address}/?token={}", token.reveal()),
        }
    }
}

impl Viewer for Page {
    fn sink(&self) -> SnapshotOutlet {
        self.outlet.clone()
    }

    /// Composes frames and images for everybody who looks at the page.
    fn show(&self, model: &Model<'_>) {
        let shown = compose::Shown { config: &self.config, truth: self.truth.as_ref() };
        compose::compose(model, &shown, &self.outlet, &self.board);
    }

    fn tell(&self, note: &str) {
        self.board.tell(note);
    }

    /// Tells every browser that the run has ended, too.
    fn end(&self) {
        self.board.close();
    }
}

/// This machine's address as its network knows it: the system chooses it for a datagram that is never sent.
fn own_address(listening: SocketAddr) -> Option<IpAddr> {
    let (any, far): (SocketAddr, SocketAddr) = if listening.is_ipv4() {
        (([0, 0, 0, 0], 0).into(), ([192, 0, 2, 1], 9).into())
    } else {
        (([0_u16; 8], 0).into(), ([0x2001, 0xdb8, 0, 0, 0, 0, 0, 1], 9).into())
    };
    let socket = UdpSocket::bind(any).ok()?;
    socket.connect(far).ok()?;
    Some(socket.local_addr().ok()?.ip()).filter(|address| !address.is_unspecified())
}
