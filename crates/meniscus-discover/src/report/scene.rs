//! Scene file of a discovery: the effects that the simulator carries.

use crate::workflow::Report;
use meniscus_data::effects::Effects;
use std::fmt::Write;

/// Returns the scene file with the effects that the simulator carries, each with its source; the others stand in it as
/// comments. A verdict `unknown` adds none.
#[must_use]
pub fn scene_toml(report: &Report) -> String {
    let findings = &report.findings;
    let mut text = format!("# {}\n# Written by `meniscus discover`.\n", report.sentence());
    if let Some((factor, _)) = report.sized().and_then(|sized| sized.viscosity) {
        let _ = writeln!(text, "# The viscosity that fits beside it is {factor:.3} times the stated one.");
    }
    text += "\n[effects]\n";
    for active in report.effects() {
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
