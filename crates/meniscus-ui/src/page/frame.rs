//! One turn as the page gets it. `docs/page.md` has the bytes.
//!
//! The full field does not travel: it is linear in the decoder's coefficients, so the page gets the bases once
//! ([`super::bases`]) and then, turn after turn, some hundred coefficients instead of 27742 numbers. Groups that the model does
//! not know have no coefficients, and their half-widths and totals are not numbers.

use meniscus::blob::Model;
use meniscus::latent::decoder::ENERGY_GROUP;
use meniscus::runtime::{Crest, Forecast, Mode};
use meniscus::surface::{POINTS, SurfaceProfile};
use meniscus_service::snapshot::TurnSnapshot;
use meniscus_service::timed_turn::TimedTurn;

/// First byte of a frame.
pub(super) const FRAME: u8 = 1;

/// Turns ahead of the two forecasts: 0.25 s and 0.5 s.
pub(super) const AHEAD: [usize; 2] = [15, 30];

/// Names of the profiles in a frame, in order: 21 heights or half-widths each, metres.
pub(super) const PROFILES: [&str; 9] = [
    "estimated",
    "estimated_half",
    "measured",
    "measured_half",
    "ahead_0",
    "ahead_0_half",
    "ahead_1",
    "ahead_1_half",
    "true",
];

/// Flag bits: the full field is of this turn; its frame came; the liquid was seen in it.
const FIELD_FRESH: u8 = 1;
const FRAME_CAME: u8 = 2;
const SEEN: u8 = 4;

/// Inputs of a frame.
pub(super) struct Facts<'l> {
    /// The snapshot.
    pub(super) snapshot: &'l TurnSnapshot,
    /// Its turn.
    pub(super) logged: &'l TimedTurn,
    /// Seconds, in the camera's time, since a frame came.
    pub(super) unseen_s: f64,
    /// Viewers of the page, and frames that they had no room for.
    pub(super) viewers: (usize, u64),
    /// The next crest.
    pub(super) crest: Option<Crest>,
    /// The two forecasts.
    pub(super) ahead: [Forecast; 2],
    /// The true surface, m, where the camera is simulated.
    pub(super) truth: Option<&'l [f32; POINTS]>,
    /// Error of the surface over the last turns, relative to the slosh; not a number without a truth.
    pub(super) recent_error: f64,
}

/// The numbers of a frame by name, each with where it comes from.
type Number = (&'static str, fn(&Facts<'_>) -> f64);

/// In the order in which they travel; the page learns the names with the bases.
pub(super) const NUMBERS: [Number; 48] = [
    ("slosh_j", |f| f.logged.turn.estimate.slosh_j),
    ("heat_j", |f| f.logged.turn.estimate.heat_j),
    ("acceleration_m_s2", |f| f64::from(f.logged.turn.estimate.acceleration_m_s2)),
    ("glass_x_m", |f| seen(f).and_then(|p| p.glass_x_m).map_or(f64::NAN, f64::from)),
    ("points_seen", |f| seen(f).map_or(0.0, |p| p.valid_points() as f64)),
    ("unseen_s", |f| f.unseen_s),
    ("energy_residual", |f| f.logged.turn.estimate.audit.energy_residual),
    ("step_heat", |f| f.logged.turn.estimate.audit.heat),
    ("step_iterations", |f| f64::from(f.logged.turn.estimate.audit.iterations)),
    ("surface_us", |f| f.logged.turn.estimate.stages.surface_us as f64),
    ("predict_us", |f| f.logged.turn.estimate.stages.predict_us as f64),
    ("encode_us", |f| f.logged.turn.estimate.stages.encode_us as f64),
    ("correct_us", |f| f.logged.turn.estimate.stages.correct_us as f64),
    ("field_us", |f| f.logged.turn.estimate.stages.field_us as f64),
    ("turn_us", |f| f.logged.turn_us as f64),
    ("latency_us", |f| f.logged.latency_us as f64),
    ("turns", |f| f.snapshot.memory.health.turns as f64),
    ("tracking", |f| f.snapshot.memory.health.tracking as f64),
    ("coasting", |f| f.snapshot.memory.health.coasting as f64),
    ("halted", |f| f.snapshot.memory.health.halted as f64),
    ("filling", |f| f.snapshot.memory.health.filling as f64),
    ("frames_missing", |f| f.snapshot.memory.health.frames_missing as f64),
    ("frames_stale", |f| f.snapshot.memory.health.frames_stale as f64),
    ("frames_caught_up", |f| f.snapshot.memory.health.frames_caught_up as f64),
    ("not_seen", |f| f.snapshot.memory.health.not_seen as f64),
    ("field_shed", |f| f.snapshot.memory.health.field_shed as f64),
    ("deadline_missed", |f| f.logged.frames.missed() as f64),
    ("q_half", |f| f64::from(f.logged.turn.estimate.interval.field[0])),
    ("v_half", |f| f64::from(f.logged.turn.estimate.interval.field[1])),
    ("e_half", |f| f64::from(f.logged.turn.estimate.interval.field[2])),
    ("sigma_half", |f| f64::from(f.logged.turn.estimate.interval.field[3])),
    ("tau_half", |f| f64::from(f.logged.turn.estimate.interval.field[4])),
    ("crest_turns", |f| f.crest.map_or(f64::NAN, |crest| crest.frames as f64)),
    ("crest_m", |f| f.crest.map_or(f64::NAN, |crest| f64::from(crest.height_m))),
    ("crest_half_m", |f| f.crest.map_or(f64::NAN, |crest| f64::from(crest.half_width_m))),
    ("crest_spills", |f| f.crest.map_or(0.0, |crest| f64::from(u8::from(crest.spills)))),
    ("viewers", |f| f.viewers.0 as f64),
    ("left_out", |f| f.viewers.1 as f64),
    ("step_work", |f| f.logged.turn.estimate.audit.work),
    ("frames_taken", |f| f.logged.frames.taken() as f64),
    ("frames_late", |f| f.logged.frames.late as f64),
    ("frames_lost", |f| f.logged.frames.lost as f64),
    ("frames_never_handled", |f| f.logged.frames.never_handled as f64),
    ("host_s", |f| f.logged.host.map_or(f64::NAN, |host| host.unix_ns as f64 * 1e-9)),
    ("host_std_ms", |f| f.logged.host.map_or(f64::NAN, |host| host.std_ns as f64 * 1e-6)),
    ("host_latency_ms", |f| f.logged.host.map_or(f64::NAN, |host| host.latency_us as f64 * 1e-3)),
    // The page shows it as it comes.
    ("over_s", |f| (10.0 * f.logged.frames.over_s).round() / 10.0),
    ("surface_error", |f| f.recent_error),
];

/// Returns the profile of the turn's frame, if there is one.
fn seen<'f>(facts: &'f Facts<'_>) -> Option<&'f SurfaceProfile> {
    facts.logged.turn.profile.as_ref().and_then(|sight| sight.as_ref().ok())
}

/// The bytes of frame `number`, with the groups that `model` knows.
pub(super) fn frame(model: &Model<'_>, facts: &Facts<'_>, number: u32) -> Vec<u8> {
    let mut logged = *facts.logged;
    logged.turn.estimate = logged.turn.estimate.known_only(model.header.known());
    let facts = &Facts { logged: &logged, ..*facts };
    let turn = &facts.logged.turn;
    let estimate = &turn.estimate;
    let mode = match estimate.mode {
        Mode::Filling => 0,
        Mode::Tracking => 1,
        Mode::Coasting => 2,
        Mode::Halted => 3,
    };
    let flag = |set: bool, bit: u8| if set { bit } else { 0 };
    let flags = flag(estimate.field_fresh, FIELD_FRESH)
        | flag(turn.stamp.is_some(), FRAME_CAME)
        | flag(seen(facts).is_some(), SEEN);
    let mut bytes = Vec::with_capacity(2048);
    bytes.extend_from_slice(&[FRAME, mode, flags, 0]);
    bytes.extend_from_slice(&number.to_le_bytes());
    bytes.extend_from_slice(&(turn.time.0 as f64 * 1e-6).to_le_bytes());
    for (_, of) in NUMBERS {
        bytes.extend_from_slice(&of(facts).to_le_bytes());
    }
    let (mut measured, mut measured_half) = ([f32::NAN; POINTS], [f32::NAN; POINTS]);
    if let Some(profile) = seen(facts) {
        for (index, half) in measured_half.iter_mut().enumerate() {
            // A point that was not seen stays no number: it is never invented.
            if let Some(interval) = profile.interval_m(index) {
                measured[index] = profile.height_m[index];
                *half = interval;
            }
        }
    }
    let [near, far] = &facts.ahead;
    let profiles = [
        &estimate.surface_m,
        &estimate.interval.surface_m,
        &measured,
        &measured_half,
        &near.surface_m,
        &near.half_width_m,
        &far.surface_m,
        &far.half_width_m,
        facts.truth.unwrap_or(&[f32::NAN; POINTS]),
    ];
    let mut put = |number: f32| bytes.extend_from_slice(&number.to_le_bytes());
    profiles.into_iter().flatten().for_each(|&height| put(height));
    // The coefficients of every known group; those of the internal energy hold the heat.
    let latent = estimate.latent.map(|x| x as f32);
    let coefficients = model.decoder.coefficients(&latent, estimate.port);
    let known = model.header.known().selection();
    for (index, group) in model.decoder.groups.iter().enumerate().filter(|(index, _)| known.holds(*index)) {
        if index == ENERGY_GROUP {
            let heated = model.decoder.heated(&coefficients, estimate.heat_j as f32);
            heated.iter().take(group.basis.columns()).for_each(|&coefficient| put(coefficient));
        } else {
            let own = coefficients.iter().skip(group.first).take(group.basis.columns());
            own.for_each(|&coefficient| put(coefficient));
        }
    }
    bytes
}
