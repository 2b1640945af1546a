//! Scene file of a discovery: the effects that the simulator carries.

use super::findings::Findings;
use super::predict::Known;
use meniscus::reduced::effects::Active;
use std::fmt::Write;

/// Returns `active` as effects of the simulator, in the glass and liquid of `known`; none where it does not carry it.
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

/// Returns the scene file with the effects that the simulator carries, each with its source; the others stand in it as
/// comments.
#[must_use]
pub fn scene_toml(findings: &Findings) -> String {
    let assessment = &findings.assessment;
    let mut text =
        format!("# {}\n# Written by `meniscus discover`.\n\n[effects]\n", assessment.verdict.sentence());
    for active in &assessment.chosen().active {
        let lines = carried(active, &findings.known);
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
