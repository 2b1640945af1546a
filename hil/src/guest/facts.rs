//! The facts of a child's run, picked from its report.

use super::program::Ran;
use super::turns;
use meniscus_hil::vhci::Witness;
use serde_json::{Map, Value, json};

/// Keys of the report that are handed on whole.
const KEPT: [&str; 11] = [
    "camera",
    "camera_error",
    "camera_health",
    "camera_notes",
    "realtime",
    "modes",
    "motion",
    "health",
    "losses",
    "truth",
    "stages_us_median",
];

/// Exit status, words, and what matters of the report. Checks become one object, name by name.
pub(crate) fn of(ran: &Ran) -> Map<String, Value> {
    let mut facts = Map::new();
    facts.insert("exit".into(), ran.exit.into());
    facts.insert("said".into(), ran.said.clone().into());
    for key in KEPT {
        if let Some(value) = ran.report.get(key) {
            facts.insert(key.into(), value.clone());
        }
    }
    let checks = ran.report.get("checks").and_then(Value::as_array).into_iter().flatten();
    let checks: Map<String, Value> = checks
        .filter_map(|check| {
            let name = check["name"].as_str()?.to_owned();
            Some((name, json!({ "value": check["value"], "ok": check["ok"] })))
        })
        .collect();
    facts.insert("checks".into(), Value::Object(checks));
    facts
}

/// The facts, with the table of turns held against what the camera's side has seen.
pub(crate) fn with_turns(ran: &Ran, witness: &Witness) -> Map<String, Value> {
    let mut facts = of(ran);
    facts.insert("turns".into(), turns::judge(&ran.turns, witness));
    facts.insert("attached".into(), json!(witness.attached.len()));
    facts
}
