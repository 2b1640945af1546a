//! The publisher's thread: turns to messages, the estimate first.

use crate::counters::{Counters, count};
use crate::frames;
use crate::message::{Estimate, EstimateParts, GLASS, Header, Stamp};

use crate::outlet::{Outgoing, TurnQueue};
use crate::parameters::LiveSettings;
use crate::report::{Report, Standing};
use crate::topics::Topics;
use crate::tracers::{TracerLayout, surface};
use meniscus::blob::Model;
use meniscus::runtime::{ModalState, Mode};
use meniscus::surface::Config;
use meniscus_service::controller::SharedPlan;
use ros2_client::Node;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Time that the publisher waits for a turn before it checks whether the run has ended.
const PATIENCE: Duration = Duration::from_millis(100);

/// Time between two messages of `/diagnostics`.
const REPORT_EVERY: Duration = Duration::from_secs(1);

/// Everything that publishing needs.
pub(crate) struct Publishing<'p> {
    pub(crate) model: &'p Model<'p>,
    pub(crate) config: &'p Config,
    pub(crate) layout: Option<&'p TracerLayout>,
    pub(crate) node: &'p Mutex<Node>,
    pub(crate) topics: &'p Topics,
    pub(crate) queue: &'p TurnQueue,
    pub(crate) plan: &'p SharedPlan,
    pub(crate) live: &'p LiveSettings,
    pub(crate) counters: &'p Counters,
    pub(crate) camera: &'p str,
    pub(crate) note: &'p Mutex<String>,
}

impl Publishing<'_> {
    /// Publishes turns until `closing` is set and the queue is empty.
    pub(crate) fn run(&self, closing: &AtomicBool) {
        let mut report = Report::default();
        let mut due = Instant::now() + REPORT_EVERY;
        loop {
            match self.queue.take(PATIENCE) {
                Ok(turn) => {
                    let probability = self.turn(&turn);
                    report.turn(turn.logged, probability);
                    self.queue.give_back(turn);
                }
                Err(RecvTimeoutError::Timeout) if !closing.load(Ordering::Relaxed) => {}
                Err(_) => break,
            }
            if Instant::now() >= due {
                due = (due + REPORT_EVERY).max(Instant::now());
                let note = self.note.lock().unwrap_or_else(PoisonError::into_inner).clone();
                let standing = Standing {
                    camera: self.camera,
                    note: &note,
                    counts: self.counters.counts(),
                    unsent: crate::unsent::last(),
                    readers: self.topics.readers(&self.node.lock().unwrap_or_else(PoisonError::into_inner)),
                    spill_limit: self.live.spill_limit(),
                };
                self.topics.diagnostics.publish(report.message(&standing));
            }
        }
    }

    /// Publishes a turn; returns the probability of spilling.
    fn turn(&self, turn: &Outgoing) -> f64 {
        let Some(logged) = &turn.logged else { return 0.0 };
        // A cloud without a time is of no use to anybody.
        let layout = self.layout.filter(|_| turn.has_field && logged.host.is_some());
        let (standing, course) = self.plan.course(logged.host);
        let (risk, _) = course.forecast(self.model, &turn.memory);
        self.topics.estimate.publish(Estimate::of(&EstimateParts {
            model: &self.model.header,
            logged,
            number: turn.number,
            has_tracers: layout.is_some(),
            modes: &ModalState::of(self.model, &turn.memory),
            risk: &risk,
            plan: &standing,
            spill_limit: self.live.spill_limit(),
            turns_dropped: self.counters.left_out(),
        }));
        count(&self.counters.turns);
        let probability = f64::from(risk.probability);
        let Some(host) = logged.host else { return probability };
        let stamp = Stamp::of_unix_ns(host.unix_ns);
        if let Some(message) = frames::glass(self.config, logged, stamp) {
            self.topics.transforms.publish(message);
        }
        let header = Header { stamp, frame_id: GLASS.into() };
        if logged.turn.estimate.mode != Mode::Halted {
            self.topics.surface.publish(surface(self.config, logged, header.clone()));
        }
        if let Some(layout) = layout {
            self.topics.tracers.publish(layout.cloud(header, &turn.field));
        }
        probability
    }
}
