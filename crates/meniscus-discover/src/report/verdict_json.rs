//! JSON of a discovery (`verdict.json`).

use super::law_json::law_json;
use super::sizing_json::sizing_json;
use crate::decision::rank::Candidate;
use crate::findings::Estimate;
use crate::workflow::Report;
use meniscus::reduced::effects::Class;
use serde_json::{Value, json};

/// Returns the report as one JSON object. Its keys and words are a file format and stay as they are.
#[must_use]
pub fn verdict_json(report: &Report) -> Value {
    let Report { findings, insertion, clocks, fits, .. } = report;
    let (verdict, search) = (&findings.assessment.verdict, &findings.assessment.search);
    let claim = verdict.claim();
    let held_out = claim.map(|claim| claim.held_out);
    let estimate = |e: &Estimate| {
        json!({
            "effect": e.effect, "parameter": e.parameter, "unit": e.unit, "value": e.value,
            "interval_90": [e.interval.0, e.interval.1],
        })
    };
    let line = |c: &Candidate| {
        let values: Vec<Value> = c.fitted.iter().flat_map(|f| &f.active).map(|a| json!(a.values)).collect();
        json!({ "effects": c.names, "gain": c.gain, "fall": c.fall, "fitted_in_full": c.fitted.is_some(), "values": values })
    };
    json!({
        "verdict": report.word(),
        "sentence": report.sentence(),
        "names": report.names(),
        "class": report.class().map(Class::words),
        "reduced_model": {
            "verdict": verdict.word(), "sentence": verdict.sentence(), "names": verdict.names(),
            "class": verdict.class().map(Class::words),
            "parameters": findings.estimates.iter().map(estimate).collect::<Vec<_>>(),
            "rivals": findings.rivals.iter().map(estimate).collect::<Vec<_>>(),
        },
        "law": law_json(report),
        "simulator": sizing_json(report),
        "misfit_without": search.plain.chi2(search.count),
        "misfit_with": verdict.misfit(),
        "inclusion": claim.map_or(0.0, |claim| claim.inclusion),
        "stands_off": verdict.rest_offset().map(|offset| json!({ "channel": offset.quantity.words(), "mm": 1e3 * offset.m })),
        "out_of_range": claim.map_or(&[][..], |claim| &claim.range_ends),
        "held_out_better": held_out.map_or([0, 0], |score| [score.better, score.recordings]),
        "thresholds": {
            "gain": findings.limits.gain, "misfit": findings.limits.chi2,
            "misfit_of_none": findings.limits.clean_chi2, "fall": findings.limits.bound,
        },
        "references": findings.calibration.groups,
        "references_by": report.origin.word(),
        "recordings": findings.split.fitted.iter().map(|r| &r.name).collect::<Vec<_>>(),
        "sealed": findings.split.held_out.as_ref().map(|r| &r.name),
        "parameters": report.final_sizes().iter().map(|p| json!({
            "effect": p.effect, "parameter": p.parameter, "unit": p.unit, "value": p.value,
            "interval_90": [p.interval.0, p.interval.1], "by": p.by,
        })).collect::<Vec<_>>(),
        "gap_mm": findings.gap.as_ref().map(|g| g.gap).map(|g| json!({
            "untouched": 1e3 * g.untouched, "refitted": 1e3 * g.refitted, "black_box": 1e3 * g.black_box,
            "effect": 1e3 * g.effect, "noise_subtracted": 1e3 * g.noise,
        })),
        "other_models": insertion.closed.iter().map(|c| json!({
            "model": c.model, "untouched_mm": 1e3 * c.untouched_m, "effect_mm": 1e3 * c.effect_m,
        })).collect::<Vec<_>>(),
        "ask": findings.suggestion.as_ref().map(|q| json!({
            "record": q.motion, "between": q.between, "separation": q.separation, "seconds": q.seconds,
        })),
        "clocks": clocks.iter().map(|c| json!({
            "recording": c.recording, "late_s": c.clock.best.late_s, "error_mm": 1e3 * c.clock.best.error_m,
            "rival_late_s": c.clock.rival.map(|r| r.late_s), "rival_error_mm": c.clock.rival.map(|r| 1e3 * r.error_m),
            "ambiguous": c.clock.is_ambiguous(),
        })).collect::<Vec<_>>(),
        "fits": { "taken": fits.reused, "made": fits.computed },
        "ranking": search.ranking.iter().map(line).collect::<Vec<_>>(),
        "pairs": search.pairs.iter().take(6).map(line).collect::<Vec<_>>(),
        "map": findings.map.iter().map(|c| json!({
            "channel": c.channel, "window": c.window, "misfit": c.chi2, "p": c.p, "rms_mm": 1e3 * c.rms_m,
            "in_phase": c.phase[0], "in_quadrature": c.phase[1],
        })).collect::<Vec<_>>(),
    })
}
