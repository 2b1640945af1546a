//! Messages of the page for one turn, without a server, so that a check can read them.

use super::bases::bases;
use super::frame::{AHEAD, Facts, frame};
use meniscus::blob::Model;
use meniscus::runtime::Forecast;
use meniscus_service::snapshot::TurnSnapshot;
use meniscus_service::timed_turn::TimedTurn;

/// Bytes that a viewer gets; `docs/page.md` has their layout.
#[derive(Clone, Debug)]
pub struct Messages {
    /// Answer to `/model`.
    pub model: Vec<u8>,
    /// Frame of `/live`.
    pub frame: Vec<u8>,
}

/// Returns what a viewer gets of `model` and the turn `logged`, with forecasts from rest.
#[must_use]
pub fn messages(model: &Model<'_>, logged: &TimedTurn) -> Messages {
    let snapshot = TurnSnapshot::default();
    let ahead = AHEAD.map(|turns| Forecast::new(model, &snapshot.memory, turns, &[]));
    let facts = Facts {
        snapshot: &snapshot,
        logged,
        unseen_s: 0.0,
        viewers: (0, 0),
        crest: None,
        ahead,
        truth: None,
        recent_error: f64::NAN,
    };
    Messages { model: bases(model, ""), frame: frame(model, &facts, 1) }
}
