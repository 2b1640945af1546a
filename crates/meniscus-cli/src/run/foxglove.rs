//! `--foxglove` and `--mcap`: the run for Foxglove, live and in a file.

use meniscus::surface::Config;
use std::net::SocketAddr;
use std::path::PathBuf;

#[cfg(feature = "foxglove")]
pub(super) use meniscus_ui::foxglove::Foxglove;

/// What a person says about Foxglove.
#[derive(clap::Args)]
pub(super) struct FoxgloveArguments {
    /// Serve the run to Foxglove (Open connection, Foxglove WebSocket): tracers, surface, camera and estimate. Only this
    /// machine is answered: the protocol knows no password. Needs a program built with --features foxglove.
    #[arg(long, value_name = "ADDRESS:PORT", num_args = 0..=1, default_missing_value = "127.0.0.1:8765")]
    foxglove: Option<SocketAddr>,
    /// Write the same topics into an MCAP file; one that is there is replaced. Needs the same feature. (`meniscus
    /// record` writes the camera's raw images, from which a run can be done again.)
    #[arg(long, value_name = "FILE.mcap")]
    mcap: Option<PathBuf>,
}

#[cfg(feature = "foxglove")]
impl FoxgloveArguments {
    /// Opens server and file; `None` where neither was asked for.
    pub(super) fn open(&self, config: Config) -> anyhow::Result<Option<Foxglove>> {
        if self.foxglove.is_none() && self.mcap.is_none() {
            return Ok(None);
        }
        let foxglove = Foxglove::open(config, self.foxglove, self.mcap.as_deref())?;
        if let Some(port) = foxglove.port() {
            eprintln!("Foxglove: open a connection to ws://127.0.0.1:{port}");
        }
        Ok(Some(foxglove))
    }

    /// Closes both and says what became of the turns.
    pub(super) fn close(&self, foxglove: Foxglove) -> anyhow::Result<()> {
        let books = foxglove.close()?;
        let to = self.mcap.as_ref().map_or(String::new(), |path| format!(", written to {}", path.display()));
        eprintln!(
            "Foxglove: {} turns and {} images{to}; {} turns in between left out",
            books.turns, books.images, books.left_out
        );
        Ok(())
    }
}

/// In a program without Foxglove there is none of these.
#[cfg(not(feature = "foxglove"))]
pub(super) enum Foxglove {}

#[cfg(not(feature = "foxglove"))]
impl Foxglove {
    pub(super) fn outlet(&self) -> &meniscus_service::snapshot::Outlet {
        match *self {}
    }

    pub(super) fn compose(&self, _: &meniscus::blob::Model<'_>) {
        match *self {}
    }

    pub(super) fn end(&self) {
        match *self {}
    }
}

#[cfg(not(feature = "foxglove"))]
impl FoxgloveArguments {
    /// Refuses what was asked for, with the remedy.
    pub(super) fn open(&self, _: Config) -> anyhow::Result<Option<Foxglove>> {
        anyhow::ensure!(
            self.foxglove.is_none() && self.mcap.is_none(),
            "this program was built without Foxglove; from the repository: cargo run --release --features foxglove -- \
             run --foxglove"
        );
        Ok(None)
    }

    pub(super) fn close(&self, foxglove: Foxglove) -> anyhow::Result<()> {
        match foxglove {}
    }
}
