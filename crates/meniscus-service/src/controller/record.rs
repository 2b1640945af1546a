//! The controller's record, as it is published.

use super::plan_rules::PlanFault;
use super::spill::SpillRisk;
use meniscus::runtime::output::HostTime;
use meniscus::runtime::{LinearModel, LinearStep, ModalState, Mode};
use meniscus::surface::POINTS;
use meniscus::units::Micros;
use serde::{Deserialize, Serialize};

/// First byte of a controller's record.
pub const CONTROL_KIND: u8 = b'C';
/// Version of the record, its second byte.
pub const CONTROL_VERSION: u8 = 1;

/// Estimate of a turn as a controller takes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControlRecord {
    /// [`CONTROL_KIND`].
    pub kind: u8,
    /// [`CONTROL_VERSION`].
    pub version: u8,
    /// Number of the record since the start of the run, from 0 without gaps.
    pub number: u64,
    /// Instant of the turn on the camera's clock.
    pub time: Micros,
    /// The same instant on the host's clock, with the latency until the record was handed to the publisher.
    pub host: Option<HostTime>,
    /// Validity of the estimate.
    pub mode: Mode,
    /// First modes of the surface.
    pub state: ModalState,
    /// Risk of spilling, under the plan where there is one.
    pub spill: SpillRisk,
    /// Standing of the plan.
    pub plan: PlanStanding,
    /// Forecast under the plan, every third turn; empty without a plan.
    pub forecast: Vec<ForecastPoint>,
    /// Linearised model, in every [`super::LINEAR_EVERY`]th record.
    pub linear: Option<LinearModel>,
    /// The model linearised along the plan, or along the present acceleration without one, for the next
    /// [`super::CHAIN_TURNS`] turns; with `linear` alone.
    pub chain: Vec<LinearStep>,
    /// Turns that had no record so far, because the one before was not ready.
    pub skipped: u64,
}

impl ControlRecord {
    /// Returns the bytes of the record.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        // Nothing in a record can fail to be written, and a vector has room for all.
        postcard::to_extend(self, Vec::with_capacity(32_768)).unwrap_or_default()
    }

    /// Returns the record in `bytes`; `None` where they are of another kind or version.
    #[must_use]
    pub fn read(bytes: &[u8]) -> Option<Self> {
        bytes.starts_with(&[CONTROL_KIND, CONTROL_VERSION]).then_some(())?;
        postcard::from_bytes(bytes).ok()
    }
}

/// Standing of the newest plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlanStanding {
    /// Sequence number of the plan that the forecast follows; `None` without a plan, or when it has ended.
    pub sequence: Option<u32>,
    /// Largest distance of its samples from the line of the model, m.
    pub across_m: f32,
    /// Plans that were taken so far.
    pub taken: u32,
    /// Plans that were refused so far.
    pub refused: u32,
    /// Reason of the last refusal, [`PlanFault::code`]; 0 without one.
    pub last_fault: u8,
}

impl PlanStanding {
    /// Counts a refusal.
    pub(super) fn refuse(&mut self, fault: PlanFault) {
        self.refused += 1;
        self.last_fault = fault.code();
    }
}

/// Forecast of one turn to come.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ForecastPoint {
    /// Turns from now.
    pub ahead: u32,
    /// The 21 heights, m.
    pub surface_m: [f32; POINTS],
    /// Their half-widths with 90 % coverage, m.
    pub half_width_m: [f32; POINTS],
}
