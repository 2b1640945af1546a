//! The `meniscus run` command as a person or a script meets it: real files, real refusals, and real time where time
//! is what is asked about. A machine that is shared may stand still for a tenth of a second at any moment, and a
//! camera does not wait for that; so errors are held against their targets with a camera that does (`--patient`).

#[path = "command/camera.rs"]
mod camera;
#[path = "command/refusals.rs"]
mod refusals;

use meniscus::blob::KnownGroups;
use meniscus::runtime::output::HostTime;
use meniscus_data::recording::EstimateRecording;
use nalgebra::DMatrix;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Mutex;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// One run at a time: each is a real-time program.
static ONE: Mutex<()> = Mutex::new(());

/// Checks that depend on what else the machine is doing; benches and studies judge them.
const OF_TIME: [&str; 4] = ["deadline_misses", "turns_late", "turn_us_median", "turn_us_p99"];

/// Every check of the command, in its order.
const NAMES: [&str; 28] = [
    "surface_slosh_rel",
    "baseline_flat_slosh_rel",
    "baseline_persistence_slosh_rel",
    "baseline_linear_slosh_rel",
    "surface_error_mean",
    "surface_error_max",
    "interval_coverage",
    "forecast_250ms_slosh_rel",
    "forecast_250ms_unplanned_slosh_rel",
    "baseline_persistence_250ms_slosh_rel",
    "forecast_250ms_coverage",
    "field_error_q",
    "field_error_v",
    "field_error_e",
    "field_error_sigma",
    "field_error_sigma_frame_late",
    "field_error_tau",
    "energy_drift_step",
    "entropy_falls",
    "deadline_misses",
    "frames_taken",
    "frames_late",
    "frames_lost",
    "frames_never_handled",
    "turns_late",
    "turn_us_median",
    "turn_us_p99",
    "allocations",
];

/// A folder of its own for each test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("command").join(name);
    let _old = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// Runs the command from `folder`.
fn meniscus(folder: &Path, arguments: &[&str]) -> Output {
    let _turn = ONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("it starts")
}

/// Its JSON object.
fn json(output: &Output) -> Value {
    let text = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}{errors}"))
}

/// It has to fail, and to say each of `words`.
fn refused(output: &Output, words: &[&str]) {
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success(), "this must be refused");
    for word in words {
        assert!(errors.contains(word), "`{word}` is missing in: {errors}");
    }
    assert!(!errors.contains("panicked") && !errors.contains("backtrace"), "{errors}");
}

#[test]
fn the_main_job_meets_its_targets_on_a_recording_never_seen() {
    let folder = folder("main");
    let output = meniscus(&folder, &["run", "--seconds", "10", "--patient", "--json"]);
    let report = json(&output);
    let checks = report["checks"].as_array().expect("an array of checks");
    let names: Vec<&str> = checks.iter().filter_map(|check| check["name"].as_str()).collect();
    assert_eq!(names, NAMES);
    for check in checks {
        assert!(check["value"].is_number(), "{check} must be measured");
        let name = check["name"].as_str().expect("a name");
        let informational = check["target"] == "informational";
        assert_eq!(check["ok"].is_null(), informational, "a verdict where there is a target: {check}");
        assert!(informational || !OF_TIME.contains(&name), "the camera is patient: {check}");
        assert!(informational || check["ok"] == true, "{check}");
    }
    assert_eq!(report["frames"].as_u64(), Some(600));
    assert_eq!(
        report["modes"]["tracking"].as_u64(),
        Some(585),
        "all but a window less one: {}",
        report["modes"]
    );
    let written = fs::read_to_string(folder.join("out/run.json")).expect("the report as a file");
    assert_eq!(serde_json::from_str::<Value>(&written).expect("JSON"), report);
    let picture = image_size(&folder.join("out/run.png"));
    assert_eq!(picture, (1500, 1000));
}

/// The model of another liquid misses every target of an error but that of e, which it does not know. A flat surface, the last frame and the
/// linear model with the true motion miss those that are relative to the slosh. A target that one of them met would say nothing.
#[test]
fn trivial_estimates_and_the_model_of_another_liquid_miss_the_targets_of_the_errors() {
    let folder = folder("trivial");
    let water = concat!(env!("CARGO_MANIFEST_DIR"), "/../models/water.blob");
    let report = json(&meniscus(&folder, &["run", "--patient", "--json", "--model", water]));
    let checks = report["checks"].as_array().expect("an array of checks");
    let of = |name: &str| checks.iter().find(|check| check["name"] == name).expect(name);
    let errors = NAMES.iter().take_while(|name| **name != "energy_drift_step");
    // The heat of water is not known, and is not shown.
    for name in errors.filter(|name| **name != "field_error_e") {
        assert_ne!(of(name)["ok"], true, "{}", of(name));
    }
    let least = |name: &str| {
        let target = of(name)["target"].as_str().expect("a target");
        target.trim_start_matches("<= ").parse::<f64>().expect("a number")
    };
    let value = |name: &str| of(name)["value"].as_f64().expect("measured");
    for baseline in ["flat", "persistence", "linear"] {
        assert!(value(&format!("baseline_{baseline}_slosh_rel")) > least("surface_slosh_rel"), "{baseline}");
    }
    for baseline in ["baseline_persistence_250ms_slosh_rel", "forecast_250ms_unplanned_slosh_rel"] {
        assert!(value(baseline) > least("forecast_250ms_slosh_rel"), "{baseline}");
    }
}

/// Width and height from the header of a PNG file.
fn image_size(path: &Path) -> (u32, u32) {
    let bytes = fs::read(path).expect("the picture");
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
    (number(16), number(20))
}

/// Invariants of a real-time run on any machine: the camera's pace, the laws, no allocation, a turn for every interval.
#[test]
fn in_real_time_the_laws_hold_whatever_else_the_machine_does() {
    const TIMELESS: [&str; 3] = ["energy_drift_step", "entropy_falls", "allocations"];
    let folder = folder("real-time");
    let begun = Instant::now();
    let wall_ns = || SystemTime::now().duration_since(UNIX_EPOCH).expect("after 1970").as_nanos() as u64;
    let started_ns = wall_ns();
    let report =
        json(&meniscus(&folder, &["run", "--seconds", "5", "--json", "--estimates", "run.safetensors"]));
    assert!(begun.elapsed() >= Duration::from_millis(4900), "sixty frames a second, and no more");
    for check in report["checks"].as_array().expect("an array of checks") {
        let name = check["name"].as_str().expect("a name");
        assert!(!TIMELESS.contains(&name) || check["ok"] == true, "{check}");
    }
    let count = |pointer: &str| report.pointer(pointer).and_then(Value::as_u64).expect("a counter");
    assert!(count("/frames") >= 295, "a turn for every interval, with a frame or without");
    let modes = ["filling", "tracking", "coasting", "halted"].map(|mode| count(&format!("/modes/{mode}")));
    assert_eq!(modes.iter().sum::<u64>(), count("/frames"), "every turn has one mode");
    assert!(modes[1] > 50, "{}", report["modes"]);

    let estimates = EstimateRecording::load(&folder.join("run.safetensors")).expect("a file of estimates");
    assert_eq!(estimates.turns() as u64, count("/frames"));
    assert!(estimates.number.iter().copied().eq(0..count("/frames")), "numbers without gaps");
    assert_eq!(estimates.known, KnownGroups::ALL, "the shipped model was trained on its own liquid");
    let host: Vec<HostTime> = estimates.host.iter().copied().map(|host| host.expect("a host time")).collect();
    let first_ns = host[0].unix_ns;
    for (host, camera_us) in host.iter().zip(&estimates.camera_us) {
        // The wall clock may be set during a test, but not by a second.
        assert!((started_ns - 1_000_000_000..wall_ns() + 1_000_000_000).contains(&host.unix_ns), "{host:?}");
        assert!(host.std_ns > 5_000_000, "the latency of the camera is not known: {host:?}");
        let apart_ns = (host.unix_ns - first_ns) as f64 - 1e3 * (camera_us - estimates.camera_us[0]) as f64;
        // Both clocks are this machine's here: the map may only learn its least delay in the first frames.
        assert!(apart_ns.abs() < 2e7, "frame at {camera_us} us is {apart_ns} ns off");
    }
    for packed in estimates.covariance.chunks_exact(91) {
        let covariance = DMatrix::from_fn(13, 13, |i, j| {
            let (row, column) = (i.max(j), i.min(j));
            f64::from(packed[row * (row + 1) / 2 + column])
        });
        assert!(covariance.cholesky().is_some(), "a covariance is positive definite");
    }
}
