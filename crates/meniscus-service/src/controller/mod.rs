//! Records for a controller: modes of the surface with covariance, risk of spilling, forecast under a plan, linearised model.
//!
//! ```text
//! worker --hand-off of the memory (never waits)--> controller's thread --queue--> publisher's thread --> sockets, UDP
//! robot --plan over UDP--> listener's thread ------------^    (or through the service of the ROS 2 node)
//! ```
//! The work of a record is bounded by [`HORIZON_MAX`]. A turn that comes while one is computed has no record, and is
//! counted.

mod course;
mod plan;
mod plan_rules;
mod plan_wire;
mod record;
mod spill;

pub use course::{Course, HORIZON_MAX};
pub use plan::Plan;
pub use plan_rules::{PLAN_SAMPLES_MAX, PLAN_VERSION, PlanFault};
pub use plan_wire::{PlanWire, SharedPlan};
pub use record::{CONTROL_KIND, CONTROL_VERSION, ControlRecord, ForecastPoint, PlanStanding};
pub use spill::SpillRisk;

use crate::commanded_motion::Say;
use crate::publish::RecordOutlet;
use crate::run::Viewer;
use crate::snapshot::{ImageSchedule, SnapshotOutlet};
use crate::timed_turn::TimedTurn;
use meniscus::blob::Model;
use meniscus::runtime::output::HostTime;
use meniscus::runtime::{LinearModel, Memory, ModalState};
use std::sync::atomic::Ordering;

/// Records between two that carry the linearised model: ten a second.
pub const LINEAR_EVERY: u64 = 6;

/// Turns along which the model is linearised: 100 ms.
pub const CHAIN_TURNS: usize = 6;

/// Frame interval, microseconds.
const INTERVAL_US: u64 = 16_667;

/// The controller's thread as a viewer of the run.
#[derive(Debug)]
pub struct Controller {
    outlet: SnapshotOutlet,
    records: RecordOutlet,
    plan: SharedPlan,
}

impl Controller {
    /// Returns a controller's end that hands its records to `records` and follows `plan`; plans may come where `plans` says.
    ///
    /// # Errors
    /// The error of the operating system on the address of the plans.
    pub fn start(
        records: RecordOutlet,
        plan: SharedPlan,
        plans: Option<PlanWire>,
        say: Say,
    ) -> std::io::Result<Self> {
        if let Some(wire) = plans {
            plan.listen(wire, say)?;
        }
        // It has no use for images.
        Ok(Self { outlet: SnapshotOutlet::new(0), records, plan })
    }

    /// Returns the record `number` of a turn after which the estimator's memory is `memory`.
    fn record(&self, model: &Model<'_>, logged: &TimedTurn, memory: &Memory, number: u64) -> ControlRecord {
        let (standing, course) = self.plan.course(logged.host);
        let (spill, forecast) = course.forecast(model, memory);
        let linear = number.is_multiple_of(LINEAR_EVERY).then(|| LinearModel::at(model, memory));
        let mut chain = Vec::new();
        if let Some(linear) = &linear {
            let held = [f64::from(linear.acceleration_m_s2); CHAIN_TURNS];
            let course = course.accelerations().get(..CHAIN_TURNS).unwrap_or(&held);
            LinearModel::along(model, memory, course, |_, step| chain.push(*step));
        }
        ControlRecord {
            kind: CONTROL_KIND,
            version: CONTROL_VERSION,
            number,
            time: logged.turn.time,
            host: logged.host,
            mode: logged.turn.estimate.mode,
            state: ModalState::of(model, memory),
            spill,
            plan: standing,
            forecast,
            linear,
            chain,
            skipped: 0,
        }
    }
}

impl Viewer for Controller {
    fn sink(&self) -> SnapshotOutlet {
        self.outlet.clone()
    }

    fn show(&self, model: &Model<'_>) {
        let (mut images, mut number, mut skipped, mut last_us) = (ImageSchedule::default(), 0, 0, None);
        while !self.plan.ended.load(Ordering::Relaxed) {
            let Some((snapshot, logged)) = self.outlet.take(&mut images) else { continue };
            let now_us = logged.turn.time.0;
            let passed_us = last_us.map_or(INTERVAL_US, |last_us| now_us.saturating_sub(last_us));
            skipped += (passed_us.saturating_add(INTERVAL_US / 2) / INTERVAL_US).saturating_sub(1);
            last_us = Some(now_us);
            let record = self.record(model, &logged, &snapshot.memory, number);
            let waited_us = u64::try_from(logged.ended.elapsed().as_micros()).unwrap_or(u64::MAX);
            let host = record
                .host
                .map(|host| HostTime { latency_us: host.latency_us.saturating_add(waited_us), ..host });
            self.records.send(ControlRecord { host, skipped, ..record }.to_bytes());
            number += 1;
        }
    }

    /// Notes of the camera are in no record.
    fn tell(&self, _: &str) {}

    fn end(&self) {
        self.plan.ended.store(true, Ordering::Relaxed);
    }
}
