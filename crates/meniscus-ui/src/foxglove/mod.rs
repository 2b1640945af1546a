//! A run for Foxglove: the same topics live over its WebSocket and in an MCAP file.
//!
//! ```text
//! worker --SnapshotOutlet (never waits)--> hand-off --> a thread of its own --topics--> WebSocket clients, MCAP file
//! ```
//! `docs/formats.md` has the topics. The protocol knows no password, so only this machine is answered, and of web pages only
//! Foxglove's own and those that were named: see `gate`.

mod camera;
mod estimate;
mod gate;
mod scene;
mod topics;
mod tracers;

pub use gate::Listen;

use ::foxglove::{Context, FoxgloveError, McapWriteOptions, McapWriterHandle, WebSocketServerHandle};
use gate::{Gate, hidden_address};
use meniscus::blob::Model;
use meniscus::surface::Config;
use meniscus_service::run::Viewer;
use meniscus_service::snapshot::{ImageSchedule, PATIENCE, SnapshotOutlet};
use std::fs::File;
use std::io::{self, BufWriter};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use topics::Topics;

/// Default address, at which Foxglove looks.
pub const ADDRESS: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 8765);

/// Bytes of a chunk of the file: half a second, which is what a pulled plug costs.
const CHUNK: u64 = 2 << 20;

/// Why there is nothing for Foxglove.
#[derive(Debug)]
pub enum Error {
    /// The address is another machine's to reach.
    Open(SocketAddr),
    /// Nothing can listen there.
    Listen(SocketAddr, io::Error),
    /// The SDK's server behind the gate cannot start.
    Server(FoxgloveError),
    /// The file cannot be made.
    Create(PathBuf, io::Error),
    /// The file cannot be written.
    Write(PathBuf, FoxgloveError),
}

impl std::fmt::Display for Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Open(address) => write!(
                f,
                "Foxglove's protocol knows no password, and others reach {address}: listen on 127.0.0.1 and reach it \
                 through a tunnel (ssh -L {port}:127.0.0.1:{port} BOARD)",
                port = address.port()
            ),
            Self::Listen(address, error) => {
                write!(f, "nothing can listen for Foxglove at {address}: {error}")
            }
            Self::Server(error) => write!(f, "the server for Foxglove cannot start: {error}"),
            Self::Create(path, error) => write!(f, "cannot make {}: {error}", path.display()),
            Self::Write(path, error) => write!(f, "{} cannot be written to its end: {error}", path.display()),
        }
    }
}

impl std::error::Error for Error {}

/// Foxglove outlet: an open server, a growing file, or both.
pub struct Foxglove {
    outlet: SnapshotOutlet,
    topics: Topics,
    config: Config,
    /// The gate, and the SDK's server behind it.
    server: Option<(Gate, WebSocketServerHandle)>,
    file: Option<(PathBuf, McapWriterHandle<BufWriter<File>>)>,
    closing: AtomicBool,
    books: Mutex<Books>,
    _context: Shared,
}

/// Counts of turns and images.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Books {
    /// Turns that were handed on.
    pub turns: u64,
    /// Images among them.
    pub images: u64,
    /// Turns in between that nobody had time for, by the camera's clock.
    pub left_out: u64,
}

impl std::fmt::Debug for Foxglove {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Foxglove")
            .field("file", &self.file.as_ref().map(|(path, _)| path))
            .finish_non_exhaustive()
    }
}

impl Foxglove {
    /// Serves at `listen` and writes into `file`, as far as they are given. A file that is there is replaced.
    ///
    /// # Errors
    /// [`Error`].
    pub fn open(config: Config, listen: Option<&Listen>, file: Option<&Path>) -> Result<Self, Error> {
        let context = Context::new();
        if let Some(listen) = listen.filter(|listen| !listen.address.ip().is_loopback()) {
            return Err(Error::Open(listen.address));
        }
        let file = match file {
            None => None,
            Some(path) => {
                let writer = File::create(path).map_err(|error| Error::Create(path.into(), error))?;
                // Never gone back to: a file that ends at any byte keeps the chunks before.
                let options = McapWriteOptions::new().chunk_size(Some(CHUNK)).disable_seeking(true);
                let writer = context.mcap_writer_with_options(options).create(BufWriter::new(writer));
                Some((path.to_path_buf(), writer.map_err(|error| Error::Write(path.into(), error))?))
            }
        };
        let server = match listen {
            None => None,
            Some(listen) => {
                let failed = |error| Error::Listen(listen.address, error);
                let hidden = hidden_address().map_err(failed)?;
                let server = context.websocket_server().name("meniscus").bind(hidden.to_string(), 0);
                let server = server.start_blocking().map_err(Error::Server)?;
                let gate = Gate::open(listen, SocketAddr::new(hidden, server.port())).map_err(failed)?;
                Some((gate, server))
            }
        };
        let (width, height) = config.image_size();
        Ok(Self {
            outlet: SnapshotOutlet::new(width * height),
            topics: Topics::new(&context),
            config,
            server,
            file,
            closing: AtomicBool::new(false),
            books: Mutex::default(),
            _context: context,
        })
    }

    /// The port that is listened at; `None` without a server.
    #[must_use]
    pub fn port(&self) -> Option<u16> {
        self.server.as_ref().map(|(gate, _)| gate.port())
    }

    /// Closes server and file; what became of the turns.
    ///
    /// # Errors
    /// [`Error::Write`]: what the file holds until then stays readable.
    pub fn close(self) -> Result<Books, Error> {
        if let Some((path, file)) = self.file {
            let written = file.close().and_then(|mut file| io::Write::flush(&mut file).map_err(Into::into));
            written.map_err(|error| Error::Write(path, error))?;
        }
        if let Some((gate, server)) = self.server {
            drop(gate);
            server.stop().wait_blocking();
        }
        Ok(*self.books.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Viewer for Foxglove {
    fn sink(&self) -> SnapshotOutlet {
        self.outlet.clone()
    }

    /// Publishes the topics. With a server and nobody connected nothing is decoded.
    fn show(&self, model: &Model<'_>) {
        let mut field = vec![0.0; model.field_len()];
        let mut images = ImageSchedule::default();
        let mut last_us = None;
        while !self.closing.load(Ordering::Relaxed) {
            if !self.topics.wanted() {
                last_us = None;
                std::thread::sleep(PATIENCE);
                continue;
            }
            let Some((snapshot, logged)) = self.outlet.take(&mut images) else { continue };
            self.topics.log(model, &self.config, &snapshot, &logged, &mut field);
            let mut books = self.books.lock().unwrap_or_else(PoisonError::into_inner);
            books.turns += 1;
            books.images += u64::from(snapshot.image_of.is_some());
            let now_us = logged.turn.time.0;
            let passed = last_us.map_or(1, |last| (now_us.saturating_sub(last) + 8_333) / 16_667);
            books.left_out += passed.saturating_sub(1);
            last_us = Some(now_us);
        }
    }

    /// Foxglove has turns alone: a note belongs to no topic of theirs.
    fn tell(&self, _: &str) {}

    fn end(&self) {
        self.closing.store(true, Ordering::Relaxed);
    }
}

/// Context of channels and sinks; it lasts as long as [`Foxglove`] does.
type Shared = Arc<Context>;

/// Time of a turn as every message of it carries it: the camera's, ns.
fn nanoseconds(logged: &meniscus_service::timed_turn::TimedTurn) -> u64 {
    logged.turn.time.0.saturating_mul(1000)
}

/// A name as a message wants it.
fn name(text: &str) -> String {
    text.into()
}
