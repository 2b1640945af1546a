//! The estimate itself, as JSON with its schema: what has no well-known message.

use super::Shared;
use ::foxglove::{FoxgloveError, RawChannel, Schema};
use meniscus::blob::Model;
use meniscus::runtime::{Forecast, Mode};
use meniscus_data::validity::Validity;
use meniscus_service::snapshot::TurnSnapshot;
use meniscus_service::timed_turn::TimedTurn;
use serde_json::{Value, json};
use std::sync::Arc;

/// Name of the schema.
const SCHEMA: &str = "meniscus.Estimate";

/// Modes, in the order of a run.
const MODES: [Mode; 4] = [Mode::Filling, Mode::Tracking, Mode::Coasting, Mode::Halted];

/// Turns ahead of the forecast: 0.25 s.
const AHEAD: usize = 15;

/// Single numbers of a message with what they are.
const NUMBERS: [(&str, &str); 18] = [
    ("slosh_energy", "H(x): energy of the slosh, J; null where velocity is not known"),
    ("heat", "heat since the start, J, which never falls; null where internal energy is not known"),
    ("work", "work of the moving glass in this step, in units of H; null as the energy"),
    ("produced", "heat of this step, in units of H, never negative; null as the heat"),
    ("energy_residual", "energy of this step less the work: rounding"),
    ("glass_acceleration", "m/s2"),
    ("turn", "time of the turn, us"),
    ("latency", "from the frame's last payload to the end of its turn, us"),
    ("number", "turns since the start of the run"),
    ("camera_us", "mid-exposure on the camera's clock, us"),
    (
        "host_ns",
        "mid-exposure on the host's clock, ns since 1970 UTC as far as a double holds; null where it is not known",
    ),
    ("host_std_ns", "standard deviation of it, ns"),
    ("host_latency", "from mid-exposure to the end of the turn on the host's clock, us"),
    ("late_turns", "frames whose turn ended too late or had been taken before they came"),
    ("frames_lost", "frames that never came as a pair of whole images"),
    ("frames_never_handled", "frames that were due while the host stood still, or dropped"),
    ("frames_missing", "turns without a frame"),
    ("field_left_out", "turns without the full field"),
];

/// Lists of a message, 21 numbers each, m.
const LISTS: [(&str, &str); 5] = [
    ("estimated", "heights of the liquid's edge above the inner bottom"),
    ("estimated_half", "half width of their 90 % interval"),
    ("measured", "heights as the camera saw them; null where it did not"),
    ("ahead", "heights in 0.25 s, if the glass moves on as it does"),
    ("ahead_half", "half width of their interval"),
];

/// The channel.
pub(super) fn channel(context: &Shared) -> Result<Arc<RawChannel>, FoxgloveError> {
    let schema = Schema::new(SCHEMA, "jsonschema", schema().to_string().into_bytes());
    context.channel_builder("/liquid/estimate").message_encoding("json").schema(schema).build_raw()
}

/// Returns the JSON schema of a message.
fn schema() -> Value {
    let mut properties = serde_json::Map::new();
    properties.insert("mode".into(), json!({ "type": "string", "enum": MODES.map(mode) }));
    for (name, what) in NUMBERS {
        properties.insert(name.into(), json!({ "type": ["number", "null"], "description": what }));
    }
    for (name, what) in LISTS {
        let items = json!({ "type": ["number", "null"] });
        properties.insert(name.into(), json!({ "type": "array", "items": items, "description": what }));
    }
    let groups = "field groups that the model knows for this liquid";
    properties.insert(
        "known".into(),
        json!({ "type": "array", "items": { "type": "string" }, "description": groups }),
    );
    let why = "reason and remedy for the other groups; empty where all are known";
    properties.insert("unknown".into(), json!({ "type": "string", "description": why }));
    json!({ "title": SCHEMA, "type": "object", "properties": properties })
}

/// A turn.
pub(super) fn message(model: &Model<'_>, snapshot: &TurnSnapshot, logged: &TimedTurn) -> String {
    let (turn, health) = (&logged.turn, &snapshot.memory.health);
    let validity = Validity::of(&model.header);
    let estimate = turn.estimate.known_only(validity.known);
    let measured = turn.profile.and_then(Result::ok).map(|profile| {
        let points = profile.height_m.into_iter().zip(profile.valid);
        points.map(|(z, valid)| valid.then_some(z)).collect::<Vec<_>>()
    });
    let valid = estimate.mode != Mode::Halted;
    let ahead = valid.then(|| Forecast::new(model, &snapshot.memory, AHEAD, &[]));
    json!({
        "mode": mode(estimate.mode),
        "known": validity.names(),
        "unknown": validity.sentence.unwrap_or_default(),
        "slosh_energy": estimate.slosh_j,
        "heat": estimate.heat_j,
        "work": estimate.audit.work,
        "produced": estimate.audit.heat,
        "energy_residual": estimate.audit.energy_residual,
        "glass_acceleration": estimate.acceleration_m_s2,
        "turn": logged.turn_us,
        "latency": logged.latency_us,
        "number": health.turns,
        "camera_us": turn.time.0,
        "host_ns": logged.host.map(|host| host.unix_ns),
        "host_std_ns": logged.host.map(|host| host.std_ns),
        "host_latency": logged.host.map(|host| host.latency_us),
        "late_turns": logged.frames.late,
        "frames_lost": logged.frames.lost,
        "frames_never_handled": logged.frames.never_handled,
        "frames_missing": health.frames_missing,
        "field_left_out": health.field_shed,
        "estimated": if valid { estimate.surface_m.to_vec() } else { Vec::new() },
        "estimated_half": if valid { estimate.interval.surface_m.to_vec() } else { Vec::new() },
        "measured": measured.unwrap_or_default(),
        "ahead": ahead.map(|ahead| ahead.surface_m.to_vec()).unwrap_or_default(),
        "ahead_half": ahead.map(|ahead| ahead.half_width_m.to_vec()).unwrap_or_default(),
    })
    .to_string()
}

/// A mode in lower case.
fn mode(mode: Mode) -> String {
    format!("{mode:?}").to_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::runtime::{Estimator, Memory, Turn, TurnInput};
    use meniscus::units::Micros;
    use meniscus_platform::clock::Monotonic;
    use meniscus_platform::files::AlignedBytes;

    #[test]
    fn a_message_is_what_its_schema_says() {
        let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
        let model = Model::load(&bytes).expect("the shipped model");
        let mut memory = Memory::default();
        let estimate =
            Estimator::new(&model).turn(&mut memory, TurnInput::default(), &mut Monotonic::start(), &mut []);
        let turn = Turn { time: Micros(1), stamp: None, profile: None, estimate };
        let logged = TimedTurn { latency_us: 5, turn_us: 4, ..TimedTurn::untimed(turn) };
        let snapshot = TurnSnapshot { memory, ..TurnSnapshot::default() };
        let message: Value = serde_json::from_str(&message(&model, &snapshot, &logged)).expect("it is JSON");
        let schema = schema();
        let properties = schema["properties"].as_object().expect("an object");
        let fields = message.as_object().expect("an object");
        assert!(fields.keys().eq(properties.keys()), "{:?}", fields.keys());
        for (name, value) in fields {
            let is = if value.is_string() {
                "string"
            } else if value.is_array() {
                "array"
            } else {
                "number"
            };
            let allowed = &properties[name]["type"];
            assert!(*allowed == is || *allowed == json!([is, "null"]), "{name}: {allowed}");
        }
        assert_eq!(message["latency"], 5);
    }
}
