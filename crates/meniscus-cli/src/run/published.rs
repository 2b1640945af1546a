//! `--publish`: estimates for other programs, as long as the run lasts.

use super::config::{Controlling, Publishing};
use anyhow::Context;
use meniscus::blob::Model;
use meniscus_service::controller::{Controller, SharedPlan};
use meniscus_service::publish::{PublishOutlet, Publisher};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The worker's end and the thread behind it, with the records for a controller.
pub(super) struct Published {
    outlet: PublishOutlet,
    controller: Option<Controller>,
    publisher: Publisher,
}

impl Published {
    /// Opens the destinations; `None` if there are none.
    pub(super) fn open(
        publishing: &Publishing,
        model: &Model<'_>,
        plan: &SharedPlan,
    ) -> anyhow::Result<Option<Self>> {
        let Publishing { destinations, field_hz, controller } = publishing;
        if destinations.is_empty() {
            return Ok(None);
        }
        let (outlet, publisher) =
            Publisher::start(destinations, &model.header, *field_hz, model.field_len())?;
        let controller = match controller {
            Controlling::Off => None,
            Controlling::On(plans) => {
                let say = Box::new(|line: &str| eprintln!("{line}"));
                let started = Controller::start(outlet.records(), plan.clone(), plans.clone(), say);
                Some(started.context("--plan cannot be listened to: choose another port")?)
            }
        };
        Ok(Some(Self { outlet, controller, publisher }))
    }

    /// The worker's end, and the records for a controller.
    pub(super) fn parts(&mut self) -> (&mut PublishOutlet, Option<&Controller>) {
        (&mut self.outlet, self.controller.as_ref())
    }

    /// Sends what is left and says what became of everything.
    pub(super) fn close(self) {
        let counters = Arc::clone(&self.outlet.counters);
        // Without an outlet the publisher sends what it has and leaves.
        drop((self.outlet, self.controller));
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
