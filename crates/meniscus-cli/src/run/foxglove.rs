//! `--foxglove` and `--mcap`: the run for Foxglove, live and in a file.

use super::config::FoxgloveConfig;
use meniscus::surface::Config;
use std::net::SocketAddr;
use std::path::PathBuf;

#[cfg(feature = "foxglove")]
pub(super) use meniscus_ui::foxglove::{Foxglove, Listen};

/// Flags of Foxglove.
#[derive(clap::Args)]
pub(super) struct FoxgloveArguments {
    /// Serve the run to Foxglove, to this machine alone [default address: 127.0.0.1:8765].
    ///
    /// In Foxglove: Open connection, Foxglove WebSocket. Tracers, surface, camera and estimate are sent. The protocol has no
    /// password. Needs a program built with --features foxglove.
    #[arg(
        long,
        value_name = "ADDRESS:PORT",
        num_args = 0..=1,
        default_missing_value = "127.0.0.1:8765",
        help_heading = "Live view",
        value_parser = super::page::address
    )]
    foxglove: Option<SocketAddr>,
    /// With --foxglove: origin of a web page that may connect; repeatable.
    ///
    /// A browser sends it, as in http://localhost:8080. Foxglove's own application may always connect, and so may programs,
    /// which send none. Other pages are refused.
    #[arg(long, value_name = "SCHEME://HOST", requires = "foxglove", help_heading = "Live view")]
    foxglove_origin: Vec<String>,
    /// Write the same topics to an MCAP file; an old file is replaced.
    ///
    /// Needs the same feature. `meniscus record` writes the camera's raw images, from which a run can be repeated.
    #[arg(long, value_name = "FILE.mcap", help_heading = "Live view")]
    mcap: Option<PathBuf>,
}

impl FoxgloveArguments {
    /// Returns the configuration.
    pub(super) fn config(&self) -> FoxgloveConfig {
        FoxgloveConfig {
            address: self.foxglove,
            #[cfg(feature = "foxglove")]
            origins: self.foxglove_origin.clone(),
            file: self.mcap.clone(),
        }
    }
}

/// Opens server and file; `None` where neither is wanted.
#[cfg(feature = "foxglove")]
pub(super) fn open(config: &FoxgloveConfig, reader: Config) -> anyhow::Result<Option<Foxglove>> {
    if config.address.is_none() && config.file.is_none() {
        return Ok(None);
    }
    let origins = config.origins.clone();
    let listen = config.address.map(|address| Listen { address, origins });
    let foxglove = Foxglove::open(reader, listen.as_ref(), config.file.as_deref())?;
    if let Some(port) = foxglove.port() {
        eprintln!("Foxglove: open a connection to ws://127.0.0.1:{port}");
    }
    Ok(Some(foxglove))
}

/// Closes both and says what became of the turns.
#[cfg(feature = "foxglove")]
pub(super) fn close(config: &FoxgloveConfig, foxglove: Foxglove) -> anyhow::Result<()> {
    let books = foxglove.close()?;
    let to = config.file.as_ref().map_or(String::new(), |path| format!(", written to {}", path.display()));
    eprintln!(
        "Foxglove: {} turns and {} images{to}; {} turns in between left out",
        books.turns, books.images, books.left_out
    );
    Ok(())
}

/// A program without Foxglove has none of these.
#[cfg(not(feature = "foxglove"))]
pub(super) enum Foxglove {}

#[cfg(not(feature = "foxglove"))]
impl meniscus_service::run::Viewer for Foxglove {
    fn sink(&self) -> meniscus_service::snapshot::SnapshotOutlet {
        match *self {}
    }

    fn show(&self, _: &meniscus::blob::Model<'_>) {
        match *self {}
    }

    fn tell(&self, _: &str) {}

    fn end(&self) {
        match *self {}
    }
}

/// Refuses Foxglove, with the remedy.
#[cfg(not(feature = "foxglove"))]
pub(super) fn open(config: &FoxgloveConfig, _: Config) -> anyhow::Result<Option<Foxglove>> {
    anyhow::ensure!(
        config.address.is_none() && config.file.is_none(),
        "this program was built without Foxglove; from the repository: cargo run --release --features foxglove -- \
         run --foxglove"
    );
    Ok(None)
}

#[cfg(not(feature = "foxglove"))]
pub(super) fn close(_: &FoxgloveConfig, foxglove: Foxglove) -> anyhow::Result<()> {
    match foxglove {}
}
