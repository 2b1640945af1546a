//! Scene file of a discovery: the effects that the simulator carries.

use crate::findings::Findings;
use meniscus_data::effects::Effects;
use std::fmt::Write;

/// Returns the scene file with the effects that the simulator carries, each with its source; the others stand in it as
/// comments.
#[must_use]
pub fn scene_toml(findings: &Findings) -> String {
    let assessment = &findings.assessment;
    let mut text =
        format!("# {}\n# Written by `meniscus discover`.\n\n[effects]\n", assessment.verdict.sentence());
    for active in &assessment.chosen().active {
        let mut carried = Effects::default();
        // Writing into a string cannot fail.
        if let Err(error) = carried.set_simulated(active, &findings.known.stated()) {
            let _ = writeln!(text, "# {} = {}: {error}", active.entry.name, active.values[0]);
        }
        for (parameter, value) in carried.on() {
            let spelling = parameter.spelling;
            let _ = writeln!(text, "{spelling} = {{ value = {value:.6}, source = \"meniscus discover\" }}");
        }
    }
    text
}
