//! A law without a name through the command: recordings by a solver that shares no code with the fit, and a library that has
//! no formula of the hidden force.

use meniscus_data::profiles::profiles_to_csv;
use meniscus_discover::study::motions::{MotionKind, motions};
use meniscus_discover::study::unnamed::laws::{HiddenLaw, JUDGED};
use meniscus_discover::study::unnamed::recordings::profiles;
use meniscus_discover::study::unnamed::solver::{DENSITY_KG_M3, DEPTH_M, Glass, RADIUS_M};
use std::path::{Path, PathBuf};

/// A folder that is gone when the test ends, unless `MENISCUS_KEEP` names one that stays.
struct Scratch(PathBuf);

impl Drop for Scratch {
    fn drop(&mut self) {
        if std::env::var_os("MENISCUS_KEEP").is_none() {
            // What a failed test did not make cannot be removed.
            let _ = std::fs::remove_dir_all(&self.0);
        }
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
    let kept = std::env::var_os("MENISCUS_KEEP").map(PathBuf::from);
    let folder = std::env::temp_dir().join(format!("meniscus-discover-law-{}", std::process::id()));
    let scratch = Scratch(kept.unwrap_or(folder));
    let law = JUDGED.iter().find(|law| law.name == "magnet and dry friction").expect("there");
    let glass = |viscosity_pa_s: f64, differs: [f64; 3]| Glass { viscosity_pa_s, differs };
    write(&scratch.0.join("mine"), &glass(0.2, [5e-4, -5e-3, 0.02]), Some(law), 1);
    for (i, (mu, by)) in [(0.2, -1.0), (0.2, 1.0), (0.17, 0.5), (0.235, -0.5)].into_iter().enumerate() {
        let differs = [1e-3 * by, 1e-2 * by, -0.04 * by];
        write(&scratch.0.join(format!("known/{i}")), &glass(mu, differs), None, 10 * (i as u64 + 1));
    }
    let path = |name: &str| scratch.0.join(name).to_string_lossy().into_owned();
    let run = |more: &[&str]| {
        let done = std::process::Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
            .args([
                "discover",
                "--recordings",
                &path("mine"),
                "--reference",
                &path("known"),
                "--out",
                &path("out"),
            ])
            .args(["--library", "camera_latency,camera_pitch,depth_scale", "--quick"])
            .args(more)
            .output()
            .expect("the command starts");
        let errors = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(done.status.success(), "{errors}");
        (String::from_utf8(done.stdout).expect("text"), errors)
    };
    let (text, _) = run(&[]);
    for part in
        ["A law without a name is drawn", "held-out recording with the drawn law", "departs from it by more"]
    {
        assert!(text.contains(part), "{text}");
    }
    let (json, errors) = run(&["--json", "--model", "shipped"]);
    assert!(errors.contains("not inserted into the flashed model"), "{errors}");
    let said: serde_json::Value = serde_json::from_str(&json).expect("one JSON object");
    let (drawn, gap) = (&said["law"], &said["gap_mm"]);
    assert_eq!((said["verdict"].as_str(), drawn["drawn"].as_bool()), (Some("unknown"), Some(true)), "{said}");
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
    let page = std::fs::read_to_string(scratch.0.join("out/report.html")).expect("a page");
    assert!(page.contains("Law without a name") && page.contains("band, upper end"), "the section");
}
