//! `--publish`: estimates for others, as long as the run lasts.

use super::Arguments;
use meniscus::blob::Model;
use meniscus_service::publish::{Outlet, Publisher};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The worker's end and the thread behind it.
pub(super) struct Published {
    outlet: Outlet,
    publisher: Publisher,
}

impl Published {
    /// Opens what `arguments` name; `None` if that is nothing.
    pub(super) fn open(arguments: &Arguments, model: &Model<'_>) -> anyhow::Result<Option<Self>> {
        if arguments.publish.is_empty() {
            return Ok(None);
        }
        let (outlet, publisher) =
            Publisher::start(&arguments.publish, arguments.field_hz, model.field_len())?;
        Ok(Some(Self { outlet, publisher }))
    }

    /// The worker's end.
    pub(super) fn outlet(&self) -> &Outlet {
        &self.outlet
    }

    /// Sends what is left and says what became of everything.
    pub(super) fn close(self) {
        let counters = Arc::clone(&self.outlet.counters);
        // Without an outlet the publisher sends what it has and leaves.
        drop(self.outlet);
        self.publisher.finish();
        let of = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        eprintln!(
            "published {} records; left out {} by slow readers, {} by a full queue; {} readers gone",
            of(&counters.sent),
            of(&counters.reader_slow),
            of(&counters.queue_full),
            of(&counters.readers_gone)
        );
    }
}
