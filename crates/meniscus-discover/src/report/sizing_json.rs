//! JSON of the sizes by simulation (`simulator` in `verdict.json`).

use crate::sizing::comparison::Score;
use crate::sizing::outcome::{Change, SizedCandidate, SizedParameter, Sizing, SpacingResult};
use crate::workflow::Report;
use serde_json::{Value, json};

/// Returns the sizes by simulation; null where they were not requested.
pub(super) fn sizing_json(report: &Report) -> Value {
    match &report.sizing {
        None => Value::Null,
        Some(Err(error)) => json!({ "error": error.to_string() }),
        Some(Ok(sizing)) => of(sizing, &report.simulator),
    }
}

fn of(sizing: &Sizing, simulator: &str) -> Value {
    let (with, all) = sizing.with_control;
    let (taken, made) = sizing.simulations;
    json!({
        "program": simulator,
        "sentence": sizing.sentence(),
        "change": match sizing.change {
            Change::Kept => "kept",
            Change::Decided => "decided",
            Change::Contradicted => "contradicted",
            Change::NotBorneOut => "not_borne_out",
            Change::Refuted => "refuted",
        },
        "candidates": sizing.candidates.iter().map(candidate).collect::<Vec<_>>(),
        "not_sized": sizing.not_sized.iter().map(|c| json!({ "names": c.names, "reason": c.reason })).collect::<Vec<_>>(),
        "recordings_with_reference": [with, all],
        "packings": sizing.packings,
        "simulations": { "taken": taken, "made": made },
    })
}

fn candidate(candidate: &SizedCandidate) -> Value {
    let variance = candidate.variance;
    let [curvature, packings, spacing] =
        [variance.curvature, variance.packings, variance.spacing].map(|part| part.variance.sqrt());
    let parameter = |p: &SizedParameter| {
        json!({
            "effect": p.effect, "parameter": p.parameter, "unit": p.unit, "value": p.value,
            "interval_90": [p.interval.0, p.interval.1], "reduced_model": p.reduced,
        })
    };
    let spacing_result = |r: &SpacingResult| json!({ "spacing_mm": 1e3 * r.spacing_m, "value": r.value, "sizes": r.sizes, "misfit": r.misfit });
    let score = |s: &Score| json!({ "recording": s.recording, "numbers": s.numbers, "squares": s.squares, "squares_without": s.absent });
    json!({
        "names": candidate.names,
        "parameters": candidate.parameters.iter().map(parameter).collect::<Vec<_>>(),
        "viscosity_factor": candidate.viscosity.map(|(factor, _)| factor),
        "viscosity_factor_90": candidate.viscosity.map(|(_, (least, largest))| [least, largest]),
        "deviations_of_first_coordinate": { "curvature": curvature, "packings": packings, "spacing": spacing },
        "spacings": candidate.spacings.iter().map(spacing_result).collect::<Vec<_>>(),
        "recordings_not_fitted": candidate.scores.each.iter().map(score).collect::<Vec<_>>(),
        "correlation_frames": candidate.scores.correlation,
        "cautions": candidate.cautions,
        "refutation": candidate.refutation,
    })
}
