//! `meniscus_msgs/Estimate`.

use super::{GLASS, Header, Stamp};
use meniscus::blob::Header as ModelHeader;
use meniscus::runtime::{ModalState, Mode};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_service::controller::{PlanStanding, SpillRisk};
use meniscus_service::timed_turn::TimedTurn;
use serde::Serialize;

/// `meniscus_msgs/Estimate`; the definition says what each field is.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs, reason = "ros2/meniscus_msgs/msg/Estimate.msg has them")]
pub struct Estimate {
    pub header: Header,
    pub stamp_std: f64,
    pub latency: f64,
    pub camera_time: u64,
    pub number: u64,
    pub has_frame: bool,
    pub frame: u32,
    pub has_tracers: bool,
    pub mode: u8,
    pub model_version: u64,
    pub along: [f64; 4],
    pub along_covariance: [f64; 16],
    pub across: [f64; 2],
    pub across_covariance: [f64; 4],
    pub acceleration: f64,
    pub slosh_energy: f64,
    pub heat: f64,
    pub crest: f64,
    pub crest_half_width: f64,
    pub crest_after: f64,
    pub spill_probability: f64,
    pub spill_limit: f64,
    pub spill_warning: bool,
    pub horizon: f64,
    pub planned: f64,
    pub has_plan: bool,
    pub plan: u32,
    pub frames_in_time: u64,
    pub frames_late: u64,
    pub frames_lost: u64,
    pub frames_never_handled: u64,
    pub turns_dropped: u64,
}

/// Parts of an estimate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EstimateParts<'e> {
    pub(crate) model: &'e ModelHeader,
    pub(crate) logged: &'e TimedTurn,
    pub(crate) number: u64,
    pub(crate) has_tracers: bool,
    pub(crate) modes: &'e ModalState,
    pub(crate) risk: &'e SpillRisk,
    pub(crate) plan: &'e PlanStanding,
    pub(crate) spill_limit: f64,
    pub(crate) turns_dropped: u64,
}

/// Returns the number of a mode in the message.
#[must_use]
pub(crate) fn mode_number(mode: Mode) -> u8 {
    match mode {
        Mode::Filling => 0,
        Mode::Tracking => 1,
        Mode::Coasting => 2,
        Mode::Halted => 3,
    }
}

impl Estimate {
    /// Returns the message of a turn.
    pub(crate) fn of(parts: &EstimateParts<'_>) -> Self {
        let EstimateParts { model, logged, modes, risk, plan, .. } = *parts;
        let estimate = logged.turn.estimate.known_only(model.known());
        let (frames, host) = (logged.frames, logged.host.unwrap_or_default());
        let [first, second] = modes.along;
        let seconds = |turns: u32| f64::from(turns) * FRAME_INTERVAL_S;
        let probability = f64::from(risk.probability);
        let nothing = [f64::NAN; 2];
        let across = modes.across.map_or(nothing, |mode| [mode.amplitude_m, mode.rate_m_s].map(f64::from));
        Self {
            header: Header { stamp: Stamp::of_unix_ns(host.unix_ns), frame_id: GLASS.into() },
            stamp_std: 1e-9 * host.std_ns as f64,
            latency: 1e-6 * host.latency_us as f64,
            camera_time: logged.turn.time.0,
            number: parts.number,
            has_frame: logged.turn.stamp.is_some(),
            frame: logged.turn.stamp.map_or(0, |stamp| stamp.sequence),
            has_tracers: parts.has_tracers,
            mode: mode_number(estimate.mode),
            model_version: model.model_version,
            along: [first.amplitude_m, second.amplitude_m, first.rate_m_s, second.rate_m_s].map(f64::from),
            along_covariance: flat(&modes.along_covariance),
            across,
            across_covariance: modes.across.map_or([f64::NAN; 4], |_| flat(&modes.across_covariance)),
            acceleration: f64::from(estimate.acceleration_m_s2),
            slosh_energy: estimate.slosh_j,
            heat: estimate.heat_j,
            crest: f64::from(risk.crest_m),
            crest_half_width: f64::from(risk.crest_half_m),
            crest_after: seconds(risk.crest_turn),
            spill_probability: probability,
            spill_limit: parts.spill_limit,
            spill_warning: probability > parts.spill_limit && estimate.mode != Mode::Halted,
            horizon: seconds(risk.horizon),
            planned: seconds(risk.planned),
            has_plan: plan.sequence.is_some(),
            plan: plan.sequence.unwrap_or(0),
            frames_in_time: frames.in_time,
            frames_late: frames.late,
            frames_lost: frames.lost,
            frames_never_handled: frames.never_handled,
            turns_dropped: parts.turns_dropped,
        }
    }
}

/// Returns a matrix row by row.
fn flat<const N: usize, const ALL: usize>(matrix: &[[f32; N]; N]) -> [f64; ALL] {
    let mut numbers = matrix.iter().flatten();
    std::array::from_fn(|_| numbers.next().map_or(f64::NAN, |number| f64::from(*number)))
}
