//! What a discovery leaves behind beside its page: JSON, and the scene file that holds the effect.

use super::predict::Known;
use super::workflow::Discovery;
use crate::insert::Closed;
use meniscus::reduced::effects::Active;
use serde_json::{Value, json};
use std::fmt::Write;

/// The discovery as JSON; `closed` are the other models that the effect was put into.
#[must_use]
pub fn verdict_json(discovery: &Discovery, closed: &[Closed]) -> Value {
    let verdict = &discovery.verdict;
    let line = |c: &super::rank::Candidate| {
        let values: Vec<Value> = c.fitted.iter().flat_map(|f| &f.active).map(|a| json!(a.values)).collect();
        json!({ "effects": c.names, "gain": c.gain, "fall": c.fall, "fitted_in_full": c.fitted.is_some(), "values": values })
    };
    json!({
        "verdict": verdict.decision.word(),
        "sentence": verdict.sentence(),
        "names": verdict.names,
        "class": verdict.class.map(meniscus::reduced::effects::Class::words),
        "misfit_without": verdict.plain.chi2(verdict.count),
        "misfit_with": verdict.chi2,
        "inclusion": verdict.inclusion,
        "stands_off": verdict.stands_off.map(|(quantity, m)| json!({ "channel": quantity.words(), "mm": 1e3 * m })),
        "out_of_range": verdict.edges,
        "held_out_better": [verdict.held_out.0, verdict.held_out.1],
        "thresholds": {
            "gain": discovery.limits.gain, "misfit": discovery.limits.chi2,
            "misfit_of_none": discovery.limits.clean_chi2, "fall": discovery.limits.bound,
        },
        "references": discovery.calibration.groups,
        "recordings": discovery.split.fitted.iter().map(|r| &r.name).collect::<Vec<_>>(),
        "sealed": discovery.split.held_out.as_ref().map(|r| &r.name),
        "parameters": discovery.estimates.iter().map(|e| json!({
            "effect": e.effect, "parameter": e.parameter, "unit": e.unit, "value": e.value,
            "interval_90": [e.interval.0, e.interval.1],
        })).collect::<Vec<_>>(),
        "gap_mm": discovery.gap.map(|g| json!({
            "untouched": 1e3 * g.untouched, "refitted": 1e3 * g.refitted, "black_box": 1e3 * g.black_box,
            "effect": 1e3 * g.effect, "noise_subtracted": 1e3 * g.noise,
        })),
        "other_models": closed.iter().map(|c| json!({
            "model": c.model, "untouched_mm": 1e3 * c.untouched_m, "effect_mm": 1e3 * c.effect_m,
        })).collect::<Vec<_>>(),
        "ask": discovery.question.as_ref().map(|q| json!({
            "record": q.motion, "between": q.between, "separation": q.separation, "seconds": q.seconds,
        })),
        "ranking": verdict.ranking.iter().map(line).collect::<Vec<_>>(),
        "pairs": verdict.pairs.iter().take(6).map(line).collect::<Vec<_>>(),
        "map": discovery.map.iter().map(|c| json!({
            "channel": c.channel, "window": c.window, "misfit": c.chi2, "p": c.p, "rms_mm": 1e3 * c.rms_m,
            "in_phase": c.phase[0], "in_quadrature": c.phase[1],
        })).collect::<Vec<_>>(),
    })
}

/// How the simulator is told of `active`, in the glass and liquid of `known`; none where it does not carry it.
#[must_use]
pub fn carried(active: &Active, known: &Known) -> Option<Vec<(&'static str, f64)>> {
    let [first, second] = active.values;
    Some(match active.entry.name {
        "viscosity" => vec![("viscosity", known.viscosity_pa_s * first)],
        "fill" => vec![("fill", known.fill_m + first)],
        "contact_line" => vec![("contact_line", first), ("contact_line_reach", second)],
        "pinned_line" => vec![("contact_line", 0.02 * first), ("contact_line_reach", 0.02)],
        "viscoelastic" => vec![("viscoelastic", first), ("viscoelastic_time", second)],
        name @ ("wall_slip"
        | "shear_thinning"
        | "yield_stress"
        | "foam"
        | "surface_tension"
        | "container_tilt"
        | "vertical_acceleration") => vec![(name, first)],
        _ => return None,
    })
}

/// The scene file with the effects that the simulator carries, each with its source; what it does not
/// carry stands as a comment.
#[must_use]
pub fn scene_toml(discovery: &Discovery, known: &Known) -> String {
    let mut text =
        format!("# {}\n# Written by `meniscus discover`.\n\n[effects]\n", discovery.verdict.sentence());
    for active in &discovery.verdict.chosen.active {
        let lines = carried(active, known);
        if lines.is_none() {
            // Writing into a string cannot fail.
            let (name, value) = (active.entry.name, active.values[0]);
            let _ = writeln!(text, "# {name} = {value}: a view or an actuation, which no liquid carries");
        }
        for (name, value) in lines.unwrap_or_default() {
            let _ = writeln!(text, "{name} = {{ value = {value:.6}, source = \"meniscus discover\" }}");
        }
    }
    text
}
