//! Ctrl-C and SIGTERM for verbs that take minutes.
//!
//! The first signal raises a flag, and a verb that looks at it ends where it can go on later. One that does not end within
//! [`GRACE`] is ended from here. An interrupted command exits with 130 and leaves no output that looks finished.

use anyhow::Context;
use meniscus_platform::files::finish_writes;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Time that a verb has to end by itself.
const GRACE: Duration = Duration::from_millis(1500);

/// Exit status of an interrupted command, as the shell has it: 128 and the number of SIGINT.
pub(super) const INTERRUPTED: u8 = 130;

/// Raised by the first signal.
static STOP: AtomicBool = AtomicBool::new(false);

/// Held while a verb writes its outputs, which it then does to the end.
static OUTPUTS: Mutex<()> = Mutex::new(());

/// Whether the outputs are being written or are there.
static FINISHED: AtomicBool = AtomicBool::new(false);

/// Results that an interrupted verb keeps, for its last line.
static KEPT: Mutex<String> = Mutex::new(String::new());

/// Watches Ctrl-C from here on; the flag is raised by the first, and the second ends the command.
///
/// # Errors
/// Where it is watched already, or cannot be.
pub(super) fn watched() -> anyhow::Result<&'static AtomicBool> {
    ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::Relaxed) {
            end();
        }
    })
    .context("Ctrl-C cannot be watched")?;
    Ok(&STOP)
}

/// Watches Ctrl-C from here on; the flag is raised at once, and after [`GRACE`] the command is ended. `kept` says then
/// what is not written and what can be gone on from.
///
/// # Errors
/// Where it is watched already, or cannot be.
pub(super) fn watched_until(kept: impl Into<String>) -> anyhow::Result<&'static AtomicBool> {
    *KEPT.lock().unwrap_or_else(PoisonError::into_inner) = kept.into();
    ctrlc::set_handler(|| {
        STOP.store(true, Ordering::Relaxed);
        std::thread::sleep(GRACE);
        let _writing = OUTPUTS.lock();
        end();
    })
    .context("Ctrl-C cannot be watched")?;
    Ok(&STOP)
}

/// Whether the command was interrupted before its outputs were written.
pub(super) fn raised() -> bool {
    STOP.load(Ordering::Relaxed) && !FINISHED.load(Ordering::Relaxed)
}

/// Begins the outputs, which are then written to the end; an interrupted command ends here instead.
pub(super) fn finish() {
    let writing = OUTPUTS.lock();
    if STOP.load(Ordering::Relaxed) {
        end();
    }
    FINISHED.store(true, Ordering::Relaxed);
    std::mem::forget(writing);
}

/// The same for outputs that say themselves that they are partial: an interrupted command writes them, too.
pub(super) fn finish_partial() {
    std::mem::forget(OUTPUTS.lock());
}

/// Ends an interrupted command, behind the files that are being written.
fn end() -> ! {
    finish_writes();
    let kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    let kept = if kept.is_empty() { "nothing was written" } else { kept.as_str() };
    eprintln!("\ninterrupted: {kept}");
    std::process::exit(INTERRUPTED.into());
}
