//! Datagrams that could not be sent, counted: DDS sends from a thread of its own, and says it to the process's logger alone.

use log::{LevelFilter, Log, Metadata, Record};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// Module of the middleware that sends.
const SENDER: &str = "rustdds::network::udp_sender";

/// Beginning of its message about a datagram that the system refused. The same module warns of long messages, which go out.
const REFUSED: &str = "raw_send";

/// Letters of a message that are kept.
const KEPT: usize = 160;

static COUNTING: AtomicBool = AtomicBool::new(false);
static NUMBER: AtomicU64 = AtomicU64::new(0);
static LAST: Mutex<String> = Mutex::new(String::new());

/// Logger that counts them, and hands everything on to the logger of the program.
struct Counted(Option<Box<dyn Log>>);

impl Log for Counted {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.target() == SENDER || self.0.as_ref().is_some_and(|own| own.enabled(metadata))
    }

    fn log(&self, record: &Record<'_>) {
        if record.target() == SENDER && COUNTING.load(Ordering::Relaxed) {
            let text = record.args().to_string();
            if text.starts_with(REFUSED) {
                NUMBER.fetch_add(1, Ordering::Relaxed);
                let text: String = text.chars().take(KEPT).collect();
                *LAST.lock().unwrap_or_else(PoisonError::into_inner) = text;
            }
        }
        if let Some(own) = self.0.as_ref().filter(|own| own.enabled(record.metadata())) {
            own.log(record);
        }
    }

    fn flush(&self) {
        if let Some(own) = &self.0 {
            own.flush();
        }
    }
}

/// Returns the logger `own` of a program with the count of datagrams around it. A program that installs a logger installs this one:
/// the process has room for one only, and without it nothing is counted.
#[must_use]
pub fn counting(own: Box<dyn Log>) -> Box<dyn Log> {
    Box::new(Counted(Some(own)))
}

/// Counts from now on.
pub(crate) fn count_from_now() {
    // A process that has a logger keeps it.
    let _has = log::set_boxed_logger(Box::new(Counted(None)));
    log::set_max_level(log::max_level().max(LevelFilter::Warn));
    COUNTING.store(true, Ordering::Relaxed);
}

/// Returns the number of datagrams so far.
pub(crate) fn count() -> u64 {
    NUMBER.load(Ordering::Relaxed)
}

/// Returns the reason of the last one; empty before the first.
pub(crate) fn last() -> String {
    LAST.lock().unwrap_or_else(PoisonError::into_inner).clone()
}
