//! A model that was corrected from the free surface: no output of the program shows a field group that it does not know.

#[path = "support/corrected.rs"]
mod corrected;

use corrected::corrected;
use meniscus::blob::{FieldGroup, KnownGroups, Model};
use meniscus::reduced::effects::{Active, find};
use meniscus_data::liquids::Liquid;
use meniscus_data::recording::{EstimateRecording, Recording};
use meniscus_discover::insert::{TrainedLiquid, insert, resistance};
use meniscus_platform::files::AlignedBytes;
use meniscus_score::unknown_groups::in_outputs;
use meniscus_virtual::observe_recording::{perfect, turns};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const SENTENCE: &str = "This model was corrected from the free surface alone. Velocity, internal energy, normal stress and \
                        shear stress are not known for this liquid. Learn it: meniscus learn";

/// A folder of its own for each test, with the corrected model in it.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("validity").join(name);
    let _old = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder");
    fs::write(folder.join("corrected.blob"), &*corrected()).expect("written");
    folder
}

/// Runs the command from `folder`.
fn meniscus(folder: &Path, arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_meniscus-under-test");
    let done = Command::new(program).args(arguments).current_dir(folder).output().expect("it starts");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    done
}

#[test]
fn no_output_of_a_turn_shows_a_group_that_is_not_known() {
    let recording =
        Recording::from_bytes(Path::new("shipped"), meniscus_shipped::RECORDING).expect("the recording");
    let bytes = corrected();
    let model = Model::load(&bytes).expect("sound");
    assert_eq!(model.header.known(), KnownGroups::KINEMATICS);
    let turns = turns(&model, &perfect(&recording));
    assert_eq!(in_outputs(&model, &recording, &turns), []);
}

/// The shipped model with one effect, at the value `value` of its first parameter.
fn with(name: &str, value: f64) -> AlignedBytes {
    let entry = find(name).expect("in the library");
    let mut values = entry.neutral();
    values[0] = value;
    let liquid = Liquid::load("glycerine").expect("a known liquid");
    let trained =
        TrainedLiquid { density_kg_m3: liquid.density_kg_m3, rheology: resistance(&liquid.rheology) };
    let shipped = AlignedBytes::copy(meniscus_shipped::MODEL);
    let inserted = insert(&shipped, trained, &[Active { entry, values }]).expect("inserted");
    let blob = AlignedBytes::copy(&inserted.blob);
    let removed = insert(&blob, trained, &[]).expect("removed");
    let removed = AlignedBytes::copy(&removed.blob);
    let plain = Model::load(&removed).expect("sound");
    assert_eq!(plain.header.known(), KnownGroups::ALL, "without {name} all is known again");
    blob
}

#[test]
fn an_inserted_effect_of_the_liquid_takes_its_stress_and_one_of_the_motion_nothing() {
    let known = |name: &str, value: f64| Model::load(&with(name, value)).expect("sound").header.known();
    let velocity = KnownGroups::KINEMATICS.with(FieldGroup::Velocity);
    assert_eq!(known("viscosity", 0.8), velocity);
    assert_eq!(known("yield_stress", 3.0), velocity);
    assert_eq!(known("wall_slip", 1e-3), KnownGroups::KINEMATICS);
    assert_eq!(known("contact_line", 0.03), velocity.with(FieldGroup::ShearStress));
    assert_eq!(known("actuation_gain", 1.05), KnownGroups::ALL);
}

#[test]
fn the_report_of_a_run_has_the_known_groups_and_the_sentence() {
    let folder = folder("report");
    let run =
        ["run", "--patient", "--seconds", "2", "--model", "corrected.blob", "--estimates", "run.safetensors"];
    let done = meniscus(&folder, &[&run[..], &["--json"]].concat());
    let report: Value = serde_json::from_slice(&done.stdout).expect("JSON");
    assert_eq!(report["known"], serde_json::json!(["q", "surface"]));
    assert!(report["unknown"].as_str().is_some_and(|sentence| sentence.starts_with(SENTENCE)), "{report}");
    let errors: Vec<&String> = report["field_error"].as_object().expect("an object").keys().collect();
    assert_eq!(errors, ["q"]);
    let checks = report["checks"].as_array().expect("an array");
    let rows = checks.iter().filter_map(|check| check["name"].as_str());
    let fields: Vec<&str> = rows.filter(|name| name.starts_with("field_error")).collect();
    assert_eq!(fields, ["field_error_q"]);

    let estimates = EstimateRecording::load(&folder.join("run.safetensors")).expect("a file of estimates");
    assert_eq!(estimates.known, KnownGroups::KINEMATICS);
    for (halves, energy) in estimates.group_half.chunks_exact(5).zip(estimates.energy_j.chunks_exact(3)) {
        assert!(halves[1..].iter().all(|half| half.is_nan()), "{halves:?}");
        assert!(energy.iter().all(|joules| joules.is_nan()), "{energy:?}");
    }
    assert!(estimates.group_half.chunks_exact(5).any(|halves| halves[0] > 0.0), "q has half-widths");
    assert!(folder.join("out/run.png").exists());

    let done = meniscus(&folder, &run);
    let text = String::from_utf8_lossy(&done.stdout);
    assert!(text.contains(SENTENCE) && text.contains("field_error_q"), "{text}");
    for absent in ["field_error_v", "field_error_e", "field_error_sigma", "field_error_tau"] {
        assert!(!text.contains(absent), "{text}");
    }
}

/// A stored model has no figures of groups that it does not know.
#[test]
fn quantisation_shows_no_group_that_is_not_known() {
    let folder = folder("quantised");
    let words = ["quantize", "--model", "corrected.blob", "--to", "bf16", "--out", "small.blob"];
    let table = meniscus(&folder, &words);
    let table = String::from_utf8_lossy(&table.stdout);
    assert!(table.lines().any(|line| line.starts_with("q ")), "{table}");
    for absent in ["v ", "e ", "sigma ", "tau "] {
        assert!(!table.lines().any(|line| line.starts_with(absent)), "{table}");
    }
    let json = meniscus(&folder, &[&words[..], &["--json", "--force"]].concat());
    let json: Value = serde_json::from_slice(&json.stdout).expect("JSON");
    let names: Vec<&str> = json["checks"]
        .as_array()
        .expect("checks")
        .iter()
        .filter_map(|check| check["name"].as_str())
        .collect();
    assert!(names.contains(&"field_error_q_after"), "{names:?}");
    for absent in ["_v_", "_e_", "_sigma_", "_tau_"] {
        assert!(!names.iter().any(|name| format!("{name}_").contains(absent)), "{names:?}");
    }
}
