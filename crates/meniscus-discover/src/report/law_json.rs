//! JSON of a drawn law, a part of `verdict.json`.

use crate::law::band::{Band, CONFIDENCE};
use crate::law::draw::Drawn;
use crate::law::nearest::Range;
use crate::workflow::Report;
use serde_json::{Value, json};

/// Returns the law of `report`: null with a verdict that has a name or misses nothing.
pub(super) fn law_json(report: &Report) -> Value {
    match &report.law {
        None => Value::Null,
        Some(Err(why)) => json!({ "drawn": false, "reason": why.to_string() }),
        Some(Ok(drawn)) => drawn_json(drawn),
    }
}

fn drawn_json(drawn: &Drawn) -> Value {
    let ranges = |all: &[Range]| all.iter().map(|r| [r.from, r.to]).collect::<Vec<_>>();
    let half = |band: &Band| json!({ "value_n": band.value, "half_width_n": band.half });
    json!({
        "drawn": true,
        "sentence": drawn.sentence(),
        "gain": drawn.gain,
        "misfit": drawn.misfit,
        "held_out_better": [drawn.held_out.better, drawn.held_out.recordings],
        "confidence": CONFIDENCE,
        "force": { "height_m": drawn.bands.force.at, "curve": half(&drawn.bands.force), "even_share": drawn.even_share },
        "drag": {
            "rate_m_s": drawn.bands.drag.at, "curve": half(&drawn.bands.drag),
            "power": drawn.power.map(|p| json!({
                "exponent": p.exponent, "at_fastest_n": p.at_fastest_n, "within_band": p.distance <= 1.0,
            })),
        },
        "nearest": drawn.nearest.as_ref().map(|near| json!({
            "effect": near.name, "distance": near.distance, "force_n": near.force_n, "drag_n": near.drag_n,
            "force_departs_m": ranges(&near.heights), "drag_departs_m_s": ranges(&near.rates),
        })),
        "gap_mm": drawn.gap.as_ref().map(|gap| 1e3 * gap.law_m),
        "ask": drawn.suggestion.as_ref().map(|q| json!({
            "record": q.motion, "between": q.between, "separation": q.separation, "seconds": q.seconds,
        })),
    })
}
