//! Report on a recording that `meniscus simulate` made.

use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::recording::{Recording, States};
use meniscus_sph::relative_closure;
use std::path::Path;

/// Time that a recording took.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cost {
    /// From begin to end, s.
    pub(super) wall_s: f64,
    /// Of all processors, s.
    pub(super) processor_s: f64,
}

/// Prints what was made.
pub(super) fn report(recording: &Recording, path: &Path, cost: Cost, json: bool) {
    let Cost { wall_s, processor_s } = cost;
    let seconds = recording.frames() as f64 * FRAME_INTERVAL_S;
    let fill = recording.glass.fill_m as f32;
    let crest_mm = 1e3 * recording.wall_m.iter().fold(0.0_f32, |m, h| m.max(h - fill));
    let closure = relative_closure(&recording.energy);
    let cost = processor_s / seconds;
    let spilled_ml = 1e6 * recording.spilled_m3.last().copied().unwrap_or(0.0);
    let truncation = match &recording.states {
        States::Full(_) => None,
        States::Factored(factored) => Some(factored.truncation),
    };
    if json {
        // A particle that goes through the wall ends a simulation with an error, so a recording that exists has none.
        println!(
            "{}",
            serde_json::json!({
                "file": path, "motion": recording.provenance.motion, "liquid": recording.provenance.liquid,
                "frames": recording.frames(), "crest_mm": crest_mm, "energy_closure": closure, "escapes": 0,
                "spilled_ml": spilled_ml,
                "processor_s_per_simulated_s": cost, "wall_s": wall_s, "truncation": truncation,
            })
        );
        return;
    }
    println!(
        "{}: {} frames of {} in {}",
        path.display(),
        recording.frames(),
        recording.provenance.liquid,
        recording.provenance.motion
    );
    println!("  highest crest {crest_mm:.1} mm above the fill, {}", spill(recording, spilled_ml));
    println!("  energy closes to {:.2} % of the largest slosh energy", 100.0 * closure);
    println!("  {cost:.1} s of processor time for each simulated second, {wall_s:.0} s in all");
    if let Some(errors) = truncation {
        let errors: Vec<_> = errors.iter().map(|e| format!("{:.2} %", 100.0 * e)).collect();
        println!("  truncation errors of q, v, e, sigma, tau: {}", errors.join(", "));
    }
}

/// Says how much of the liquid left over the rim, and when the first of it.
fn spill(recording: &Recording, spilled_ml: f64) -> String {
    let first = recording.spilled_m3.iter().position(|volume| *volume > 0.0);
    first.map_or("nothing spilled".into(), |frame| {
        let seconds = frame as f64 * FRAME_INTERVAL_S;
        format!("{spilled_ml:.1} ml spilled over the rim, the first at {seconds:.1} s")
    })
}
