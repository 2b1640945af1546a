//! A program that is built for a board shows nothing: it refuses the page, and never chooses the dashboard.

use super::config::PageConfig;
use anyhow::bail;
use meniscus::blob::Model;
use meniscus::surface::Config;
use meniscus_service::run::{RunState, Viewer};
use meniscus_service::snapshot::SnapshotOutlet;
use meniscus_service::truth::Truth;
use std::time::Duration;

/// The live page, which is never there.
pub(super) enum Page {}

impl Page {
    pub(super) fn with_truth(self, _: Option<Truth>) -> Self {
        match self {}
    }
}

impl Viewer for Page {
    fn sink(&self) -> SnapshotOutlet {
        match *self {}
    }

    fn show(&self, _: &Model<'_>) {
        match *self {}
    }

    fn tell(&self, _: &str) {}

    fn end(&self) {
        match *self {}
    }
}

/// Refuses the page, with the remedy.
pub(super) fn open(_: &PageConfig, _: &Model<'_>, _: Config, _: &str) -> anyhow::Result<Page> {
    bail!(
        "this program was built for a board, without the live page; from the repository: cargo run --release -- run --view"
    )
}

/// Waits until the run has `finished`.
pub(super) fn attend(finished: &dyn Fn() -> bool) {
    while !finished() {
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Closes the page.
pub(super) fn close(page: Page) {
    match page {}
}

/// Waits until the run has `finished`.
pub(super) fn dashboard(
    _: &Model<'_>,
    _: String,
    _: Duration,
    _: &RunState,
    finished: &dyn Fn() -> bool,
) -> std::io::Result<()> {
    attend(finished);
    Ok(())
}
