//! Discovery through the command and on folders with faults; what is kept of an interrupted one.

#[path = "support/shaken.rs"]
mod shaken;

use meniscus::blob::Model;
use meniscus::reduced::effects::EffectKind;
use meniscus::surface::{POINTS, SurfaceProfile, profile_abscissa};
use meniscus::units::Micros;
use meniscus_data::profiles::profiles_to_csv;
use meniscus_discover::decision::settings::Settings;
use meniscus_discover::decision::thresholds::Thresholds;
use meniscus_discover::recordings::load::load;
use meniscus_discover::recordings::motion_plan::MotionPlan;
use meniscus_discover::recordings::record::{Record, mean_bow};
use meniscus_discover::recordings::stated::Known;
use meniscus_discover::workflow::discover;
use meniscus_platform::files::AlignedBytes;
use shaken::{KNOWN, glass};
use std::path::{Path, PathBuf};

/// A folder that is gone when the test ends.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("meniscus-discover-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What a failed test did not make cannot be removed.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Writes `records` as a stranger would.
fn write(folder: &Path, records: &[Record], viscosity: f64) {
    std::fs::create_dir_all(folder).expect("a folder");
    let setup =
        format!("radius_m = 0.035\nfill_m = 0.07\ndensity_kg_m3 = 1261.0\nviscosity_pa_s = {viscosity}\n");
    std::fs::write(folder.join("setup.toml"), setup).expect("written");
    for (record, strength) in records.iter().zip([0.6, 1.25, 2.2, 1.7]) {
        let at = |c: usize, f: usize| record.channels[c].value[f].expect("seen");
        let profile = |f: usize| {
            let height = |i: usize| {
                let s = profile_abscissa(i);
                0.07 + at(0, f) + at(1, f) * s + at(2, f) * (2.0 * s * s - 1.0 - mean_bow())
            };
            SurfaceProfile {
                height_m: std::array::from_fn(|i| height(i) as f32),
                variance_m2: [1e-8; POINTS],
                valid: [true; POINTS],
                glass_x_m: Some(at(3, f) as f32),
                sequence: f as u32,
                captured: Micros(1_000_000 + (f as f64 / 60.0 * 1e6).round() as u64),
            }
        };
        let profiles: Vec<_> = (0..record.frames()).map(profile).collect();
        std::fs::write(folder.join(format!("{}.profile.csv", record.name)), profiles_to_csv(&profiles))
            .expect("written");
        let motion = MotionPlan::jolt(0.28, strength, 2.2).csv();
        std::fs::write(folder.join(format!("{}.motion.csv", record.name)), motion).expect("written");
    }
}

#[test]
fn the_command_leaves_a_verdict_a_page_and_a_scene_that_the_simulator_reads() {
    let scratch = Scratch::new("command");
    write(&scratch.path("mine"), &glass(&KNOWN, &[("yield_stress", 2.0)], 9), 0.2);
    for (i, mu) in [0.17, 0.2, 0.235].into_iter().enumerate() {
        let known = Known { viscosity_pa_s: mu, ..KNOWN };
        write(&scratch.path("known").join(format!("{i}")), &glass(&known, &[], 20 + i as u64), mu);
    }
    let path = |name: &str| scratch.path(name).to_string_lossy().into_owned();
    let done = std::process::Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
        .args([
            "discover",
            "--recordings",
            &path("mine"),
            "--reference",
            &path("known"),
            "--out",
            &path("out"),
            "--model",
            "shipped",
            // The recordings are the reduced model's own, so that its size is the right one.
            "--quick",
            "--simulate",
            "--spacing-mm",
            "8.7",
            "--json",
        ])
        .output()
        .expect("the command starts");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let said: serde_json::Value = serde_json::from_slice(&done.stdout).expect("one JSON object");
    println!("{}", said["sentence"]);
    assert_eq!((said["verdict"].as_str(), said["names"][0].as_str()), (Some("named"), Some("yield_stress")));
    // The shipped model is of a thicker liquid, so the gap says nothing here; that both were asked does.
    let others = said["other_models"].as_array().expect("a list");
    assert_eq!(others.len(), 2, "{}", String::from_utf8_lossy(&done.stderr));
    let name = |i: usize| others[i]["model"].as_str().expect("a name");
    assert_eq!((name(0), name(1)), ("the flashed model", "the simulator"));
    for other in others {
        let [before, after] = ["untouched_mm", "effect_mm"].map(|k| other[k].as_f64().expect("a number"));
        println!("{other}");
        assert!(before.is_finite() && after.is_finite() && before != after);
    }
    // The simulator starts from the very liquid that was said, so the effect has to bring it nearer.
    assert!(others[1]["effect_mm"].as_f64() < others[1]["untouched_mm"].as_f64());
    let bytes = AlignedBytes::read(&scratch.path("out/model.blob")).expect("a blob");
    let named = Model::load(&bytes).expect("a sound blob").header.embedded.expect("it names the effect");
    assert_eq!(named.effects[0].name, "yield_stress");
    let page = std::fs::read_to_string(scratch.path("out/report.html")).expect("a page");
    assert!(page.contains("the flashed model") && page.contains("the simulator"));
    assert!(page.contains("<svg") && page.contains("yield_stress"));
    // It stands alone: the only address in it is the name of the SVG standard.
    assert_eq!(page.matches("http").count(), page.matches("http://www.w3.org/2000/svg").count());
    assert!(page.contains("meniscus discover --recordings"), "what made it");
    let scene =
        meniscus_data::scene_file::Experiment::load(&scratch.path("out/scene.toml")).expect("a scene");
    let pa = scene.effects.value(EffectKind::YieldStress);
    assert!(pa.is_some_and(|pa| (pa - 2.0).abs() < 0.3), "{:?}", scene.effects);
}

/// Writes `records` as heights at five gauges of the wall, as another laboratory would, in place of the profiles.
fn write_gauges(folder: &Path, records: &[Record]) {
    const PLACES_MM: [f64; 5] = [-30.0, -15.0, 0.0, 12.5, 31.0];
    for record in records {
        let mut text = String::from("time_s");
        PLACES_MM.iter().for_each(|x| text += &format!(",height_mm@x={x}mm"));
        for f in 0..record.frames() {
            text += &format!("\n{:.6}", f as f64 / 60.0);
            let at = |c: usize| record.channels[c].value[f].expect("seen");
            for x in PLACES_MM {
                let s = x / 35.0;
                let z = 0.07 + at(0) + at(1) * s + at(2) * (2.0 * s * s - 1.0 - mean_bow());
                text += &format!(",{:.5}", 1e3 * z);
            }
        }
        std::fs::write(folder.join(format!("{}.gauges.csv", record.name)), text).expect("written");
        std::fs::remove_file(folder.join(format!("{}.profile.csv", record.name))).expect("it was there");
    }
}

#[test]
fn gauges_at_a_few_places_name_the_effect_that_profiles_name() {
    let scratch = Scratch::new("gauges");
    let records = glass(&KNOWN, &[("yield_stress", 2.0)], 9);
    write(&scratch.path("mine"), &records, 0.2);
    write_gauges(&scratch.path("mine"), &records);
    for (i, mu) in [0.17, 0.2, 0.235].into_iter().enumerate() {
        let (known, folder) =
            (Known { viscosity_pa_s: mu, ..KNOWN }, scratch.path("known").join(format!("{i}")));
        let references = glass(&known, &[], 20 + i as u64);
        write(&folder, &references, mu);
        write_gauges(&folder, &references);
    }
    let path = |name: &str| scratch.path(name).to_string_lossy().into_owned();
    let done = std::process::Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
        .args(["discover", "--quick", "--json", "--library", "yield_stress,viscosity,wall_slip"])
        .args(["--recordings", &path("mine"), "--reference", &path("known"), "--out", &path("out")])
        .output()
        .expect("the command starts");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let said: serde_json::Value = serde_json::from_slice(&done.stdout).expect("one JSON object");
    assert_eq!((said["verdict"].as_str(), said["names"][0].as_str()), (Some("named"), Some("yield_stress")));
    let found = said["parameters"][0]["value"].as_f64().expect("a number");
    assert!((found - 2.0).abs() < 0.4, "{found}");
    // A column without a unit is refused by its name, and nothing is left.
    for record in &records {
        let file = scratch.path("mine").join(format!("{}.gauges.csv", record.name));
        let text = std::fs::read_to_string(&file).expect("read");
        std::fs::write(&file, text.replacen("height_mm@x=0mm", "gauge_3", 1)).expect("written");
    }
    let refused = load(&scratch.path("mine")).expect_err("no recording is left").to_string();
    assert!(refused.contains("'gauge_3': it names no place behind @x="), "{refused}");
}

#[test]
fn bad_folders_are_refused_with_what_is_wrong_and_the_rest_is_kept() {
    let scratch = Scratch::new("bad");
    let refusal = |why: &str| {
        let said = match load(&scratch.0) {
            Ok(set) => set.left_out.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "),
            Err(error) => error.to_string(),
        };
        assert!(said.contains(why), "'{why}' is not in: {said}");
    };
    refusal("setup.toml");
    let records = glass(&KNOWN, &[], 30);
    write(&scratch.0, &records, -1.0);
    refusal("viscosity_pa_s = -1 is out of range");
    write(&scratch.0, &records, 0.2);
    assert_eq!(load(&scratch.0).expect("a folder").records.len(), 4);
    // A motion that ends while the glass moves.
    let motion: String =
        MotionPlan::jolt(0.28, 0.6, 2.2).csv().lines().take(150).map(|line| format!("{line}\n")).collect();
    std::fs::write(scratch.path("a.motion.csv"), motion).expect("written");
    refusal("a: the motion ends at 0.59 s while the glass moves");
    // A glass that moves from the first frame.
    let early: String = (0..600)
        .map(|n| (0.004 * f64::from(n), (0.08 * f64::from(n)).sin()))
        .map(|(t, x)| format!("{t},{}\n", 0.01 * x))
        .collect();
    std::fs::write(scratch.path("b.motion.csv"), early).expect("written");
    refusal("b: the glass rests for only 0 frames");
    let text = std::fs::read_to_string(scratch.path("c.profile.csv")).expect("read");
    std::fs::write(scratch.path("c.profile.csv"), text.replacen(",0.07", ",nan", 1)).expect("written");
    refusal("c.profile.csv: line 2");
    assert_eq!(load(&scratch.0).expect("one is left").records.len(), 1);
    // Constant heights.
    let flat: String = (0..100).map(|n| format!("{:.4},1.5\n", f64::from(n) / 60.0)).collect();
    std::fs::write(scratch.path("e.peak.csv"), flat).expect("written");
    std::fs::write(scratch.path("e.motion.csv"), MotionPlan::jolt(0.28, 0.6, 2.2).csv()).expect("written");
    refusal("e: the peak never changes");
    // A motion that says nothing, one on a clock that counts from elsewhere, and one that starts late.
    write(&scratch.0, &records, 0.2);
    let plan = MotionPlan::jolt(0.28, 0.6, 2.2).csv();
    let rows = |late: f64| -> String {
        let row = |line: &str| {
            let (t, x) = line.split_once(',').expect("two columns");
            format!("{:.3},{x}\n", t.parse::<f64>().expect("a time") + late)
        };
        plan.lines().skip(1).map(row).collect()
    };
    std::fs::write(scratch.path("a.motion.csv"), plan.replacen(",0.000000000", ",nan", 1)).expect("written");
    refusal("is not finite");
    std::fs::write(scratch.path("a.motion.csv"), rows(1.7e9)).expect("written");
    refusal("it starts at 1700000000.00 s, after the end of the recording");
    std::fs::write(scratch.path("a.motion.csv"), rows(0.5)).expect("written");
    refusal("a: the camera shows the glass move 0.50 s earlier than its motion file");
    let still: String = (0..600).map(|n| format!("{},0.0\n", 0.004 * f64::from(n))).collect();
    std::fs::write(scratch.path("a.motion.csv"), still).expect("written");
    refusal("a: the glass never moves");
    std::fs::remove_file(scratch.path("a.motion.csv")).expect("it was there");
    refusal("a.motion.csv");
    assert_eq!(load(&scratch.0).expect("three are left").records.len(), 3);
    let few = discover(&records[..1], KNOWN, &[], &Thresholds::default(), &Settings::default());
    assert!(few.expect_err("one shake").to_string().contains("1 recording is too few"));
}

#[test]
fn what_was_fitted_is_kept_and_only_what_changes_is_fitted_again() {
    let scratch = Scratch::new("kept");
    let records = glass(&KNOWN, &[("actuation_gain", 1.08)], 40);
    write(&scratch.path("mine"), &records, 0.2);
    for (i, mu) in [0.17, 0.2, 0.235].into_iter().enumerate() {
        let known = Known { viscosity_pa_s: mu, ..KNOWN };
        write(&scratch.path("known").join(format!("{i}")), &glass(&known, &[], 50 + i as u64), mu);
    }
    let path = |name: &str| scratch.path(name).to_string_lossy().into_owned();
    let run = || -> (serde_json::Value, [u64; 2]) {
        let done = std::process::Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
            .args(["discover", "--library", "actuation_gain,camera_pitch", "--quick", "--json"])
            .args(["--recordings", &path("mine"), "--reference", &path("known"), "--out", &path("out")])
            .output()
            .expect("the command starts");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        let mut said: serde_json::Value = serde_json::from_slice(&done.stdout).expect("one JSON object");
        let fits = ["taken", "made"].map(|word| said["fits"][word].as_u64().expect("a count"));
        said["fits"].take();
        (said, fits)
    };
    let (first, [_, made]) = run();
    assert!(made > 10, "{made} fits");
    let (again, fits) = run();
    assert_eq!((again, fits[1]), (first.clone(), 0), "nothing is left to fit");
    // As after an interruption: half of the fits are there, one of them cut short.
    let kept: Vec<_> = std::fs::read_dir(scratch.path("out/fits")).expect("a folder").flatten().collect();
    assert!(kept.len() as u64 <= fits[0], "{} files", kept.len());
    for file in kept.iter().step_by(2) {
        std::fs::remove_file(file.path()).expect("it was there");
    }
    std::fs::write(kept[1].path(), [0; 5]).expect("written");
    let (resumed, [taken, more]) = run();
    assert_eq!(resumed, first);
    assert!(more > 0 && taken > 0 && more < made, "{taken} taken, {more} made");
    // Another recording: the references stay as they are, the rest is fitted anew.
    write(&scratch.path("mine"), &glass(&KNOWN, &[("actuation_gain", 1.08)], 41), 0.2);
    let (_, [taken, more]) = run();
    assert!(taken >= 3 && more > 0, "{taken} taken, {more} made");
}
