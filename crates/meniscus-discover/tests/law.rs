//! A law without a name through the whole workflow: recordings by a solver that shares no code with the fit, and a library that has
//! no formula of the hidden force.

use meniscus_data::profiles::profiles_to_csv;
use meniscus_discover::insert::simulated::Resolution;
use meniscus_discover::recordings::load::{load, load_references};
use meniscus_discover::report::html::page;
use meniscus_discover::report::verdict_json::verdict_json;
use meniscus_discover::study::motions::{MotionKind, motions};
use meniscus_discover::study::unnamed::laws::{HiddenLaw, JUDGED};
use meniscus_discover::study::unnamed::recordings::profiles;
use meniscus_discover::study::unnamed::solver::{DENSITY_KG_M3, DEPTH_M, Glass, RADIUS_M};
use meniscus_discover::workflow::Discovery;
use meniscus_discover::workflow::inputs::{Inputs, library};
use meniscus_discover::workflow::progress::Silent;
use std::path::{Path, PathBuf};

/// A folder that is gone when the test ends.
struct Scratch(PathBuf);

impl Drop for Scratch {
    fn drop(&mut self) {
        // What a failed test did not make cannot be removed.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Writes the recordings of `glass` under `law`.
fn write(folder: &Path, glass: &Glass, law: Option<&HiddenLaw>, seed: u64) {
    std::fs::create_dir_all(folder).expect("a folder");
    let mu = glass.viscosity_pa_s;
    let setup = format!(
        "radius_m = {RADIUS_M}\nfill_m = {DEPTH_M}\ndensity_kg_m3 = {DENSITY_KG_M3:.1}\nviscosity_pa_s = {mu}\n"
    );
    std::fs::write(folder.join("setup.toml"), setup).expect("written");
    for (i, plan) in motions(MotionKind::Single).iter().enumerate() {
        let seen = profiles(glass, plan, law, seed + i as u64);
        let name = char::from(b'a' + i as u8);
        std::fs::write(folder.join(format!("{name}.profile.csv")), profiles_to_csv(&seen)).expect("written");
        std::fs::write(folder.join(format!("{name}.motion.csv")), plan.csv()).expect("written");
    }
}

#[test]
fn an_unknown_verdict_draws_both_curves_with_bands_and_says_where_no_formula_follows() {
    let scratch = Scratch(std::env::temp_dir().join(format!("meniscus-discover-law-{}", std::process::id())));
    let law = JUDGED.iter().find(|law| law.name == "magnet and dry friction").expect("there");
    let glass = |viscosity_pa_s: f64, differs: [f64; 3]| Glass { viscosity_pa_s, differs };
    write(&scratch.0.join("mine"), &glass(0.2, [5e-4, -5e-3, 0.02]), Some(law), 1);
    let references = [(0.2, -1.0), (0.2, 1.0), (0.17, 0.5), (0.235, -0.5), (0.2, 0.3)];
    for (i, (mu, by)) in references.into_iter().enumerate() {
        let differs = [1e-3 * by, 1e-2 * by, -0.04 * by];
        write(&scratch.0.join(format!("known/{i}")), &glass(mu, differs), None, 10 * (i as u64 + 1));
    }
    let mut inputs = Inputs::new(load(&scratch.0.join("mine")).expect("sound"));
    inputs.references = load_references(&scratch.0.join("known")).expect("sound");
    let names = ["camera_slope", "camera_pitch", "depth_scale"].map(String::from);
    inputs.settings.library = library(&names).expect("known names");
    inputs.simulation = Some(Resolution { spacing_m: 0.007, seed: 1 });
    let report = Discovery::run(&inputs, &Silent).expect("a verdict");
    let sentence = report.sentence();
    assert_eq!(report.word(), "unknown", "{sentence}");
    for part in
        ["A law without a name is drawn", "the held-out recording has an error", "departs from it by more"]
    {
        assert!(sentence.contains(part), "{sentence}");
    }
    // The simulator was asked for, cannot hold a law, and says so without being started.
    let skipped: Vec<String> = report.insertion.skipped.iter().map(|s| s.reason.to_string()).collect();
    assert!(
        skipped.len() == 1 && skipped[0].contains("simulator knows effects by their formulas"),
        "{skipped:?}"
    );
    let said = verdict_json(&report);
    let (drawn, gap) = (&said["law"], &said["gap_mm"]);
    assert_eq!(
        (drawn["drawn"].as_bool(), said["references_by"].as_str()),
        (Some(true), Some("given")),
        "{said}"
    );
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    let (law_mm, untouched, refitted) =
        (number(&drawn["gap_mm"]), number(&gap["untouched"]), number(&gap["refitted"]));
    println!(
        "gap: untouched {untouched:.3}, refitted {refitted:.3}, black box {}, law {law_mm:.3} mm",
        gap["black_box"]
    );
    assert!(law_mm < 0.3 * untouched && law_mm < refitted, "{drawn}");
    let drag = drawn["drag"]["curve"]["value_n"].as_array().expect("a curve");
    let half = drawn["drag"]["curve"]["half_width_n"].as_array().expect("a band");
    assert!(drag.len() == 24 && half.len() == 24 && drag.iter().all(|d| number(d) >= 0.0), "{drag:?}");
    // The magnet pulls towards +x: the force is negative there.
    let force = drawn["force"]["curve"]["value_n"].as_array().expect("a curve");
    assert!(number(&force[force.len() - 1]) < 0.0 && number(&drawn["force"]["even_share"]) > 0.1, "{drawn}");
    let html = page(&report, "meniscus discover").expect("a page");
    assert!(html.contains("Law without a name") && html.contains("band, upper end"), "the section");
}
