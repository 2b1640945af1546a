//! Ctrl-C for verbs that end whole: the first asks for the end, the second takes it.

use anyhow::Context;
use std::sync::atomic::{AtomicBool, Ordering};

/// Watches Ctrl-C from here on; what it gives is raised by the first.
///
/// # Errors
/// Where it is watched already, or cannot be.
pub(super) fn watched() -> anyhow::Result<&'static AtomicBool> {
    static STOP: AtomicBool = AtomicBool::new(false);
    ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    })
    .context("Ctrl-C cannot be watched")?;
    Ok(&STOP)
}
