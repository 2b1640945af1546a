//! `meniscus setup` without a person, and runs with the file that it writes.

use super::{folder, optional};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn meniscus(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("it starts")
}

fn json(output: &Output) -> Value {
    let text = String::from_utf8_lossy(&output.stdout);
    serde_json::from_str(&text)
        .unwrap_or_else(|e| panic!("{e}: {text}{}", String::from_utf8_lossy(&output.stderr)))
}

#[test]
fn a_script_sets_up_and_a_run_takes_the_file() {
    let folder = folder("script");
    let asked = ["setup", "--source", "simulated-usb", "--yes", "--pairs", "20", "--json"];
    let with = |rest: &[&str]| meniscus(&folder, &[&asked[..], rest].concat());
    let wrong = with(&["--radius-mm", "29", "--fill-mm", "70", "--rim-mm", "110"]);
    assert!(!wrong.status.success() && !folder.join("glass.toml").exists(), "nothing is written");
    assert!(json(&wrong)["remedies"]["radius_seen_mm"].is_string());

    // A machine that other programs load may fall below 60 Hz for some seconds: then once more.
    let attempt = || with(&["--radius-mm", "35", "--fill-mm", "70", "--rim-mm", "110"]);
    let mut right = attempt();
    for _ in 0..2 {
        if right.status.success() {
            break;
        }
        right = attempt();
    }
    let report = json(&right);
    let checks = report["checks"].as_array().expect("checks");
    // The rate is the machine's; everything else is of the glass.
    let late = |check: &&Value| check["ok"] == false && check["name"] != "frame_rate_hz";
    assert_eq!(checks.iter().filter(late).count(), 0, "{report:#}");
    if !right.status.success() {
        return optional::skip(&format!("this machine does not reach the camera's 60 Hz: {report:#}"));
    }
    assert_eq!(report["model"]["fits"], true);
    let run = meniscus(&folder, &["run", "--patient", "--seconds", "3", "--setup", "glass.toml", "--json"]);
    let run = json(&run);
    let rel = run["checks"]
        .as_array()
        .and_then(|all| all.iter().find(|c| c["name"] == "surface_slosh_rel").cloned());
    assert!(rel.is_some_and(|check| check["ok"] == true), "{run:#}");

    let file = folder.join("glass.toml");
    let text = fs::read_to_string(&file).expect("the file");
    let spoilt = |name: &str, from: &str, to: &str| {
        let path = folder.join(name);
        assert!(text.contains(from), "{text}");
        fs::write(&path, text.replace(from, to)).expect("written");
        let run = meniscus(&folder, &["run", "--patient", "--setup", name]);
        assert!(!run.status.success(), "{name}");
        String::from_utf8_lossy(&run.stderr).into_owned()
    };
    let other = spoilt("other.toml", "radius_mm = 35.0", "radius_mm = 30.0");
    assert!(
        other.contains("other.toml") && other.contains("radius 35.0 mm, the setup says 30.0 mm"),
        "{other}"
    );
    assert!(spoilt("odd.toml", "fill_mm", "fil_mm").contains("odd.toml is no settings file"));
    assert!(spoilt("far.toml", "fill_mm = 70.0", "fill_mm = 700.0").contains("15 to 200 mm"));
}
