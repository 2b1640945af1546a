//! The `meniscus run` command as a person or a script meets it: real files, real refusals, and real time where time
//! is what is asked about. A machine that is shared may stand still for a tenth of a second at any moment, and a
//! camera does not wait for that; so errors are held against their targets with a camera that does (`--patient`).

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

#[test]
fn faults_on_the_wire_are_counted_and_survived() {
    let folder = folder("faults");
    let faults = "drop:0.05,tear:0.03,err:0.02,duplicate:0.03,length2:0.01,late:0.01";
    let report =
        json(&meniscus(&folder, &["run", "--seconds", "5", "--patient", "--json", "--faults", faults]));
    let count = |pointer: &str| report.pointer(pointer).and_then(Value::as_u64).expect("a counter");
    for lost in ["short_frame", "error_bit", "duplicate", "bad_header"] {
        let both = count(&format!("/losses/depth/{lost}")) + count(&format!("/losses/infrared/{lost}"));
        assert!(both > 0, "no {lost} was counted: {}", report["losses"]);
    }
    assert!(count("/modes/coasting") > 10, "{}", report["modes"]);
    assert!(count("/modes/tracking") > 150, "{}", report["modes"]);
    assert_eq!(count("/entropy_falls"), 0);
    let turns = count("/frames");
    assert!((295..=310).contains(&turns), "a turn a frame interval, whatever is lost: {turns}");
    let slosh_rel = report.pointer("/surface_error/slosh_rel").and_then(Value::as_f64).expect("measured");
    assert!(slosh_rel < 0.5, "the prediction must carry the gaps: {slosh_rel}");
}

#[test]
fn a_bad_model_is_refused_with_its_reason() {
    let folder = folder("models");
    let run = |model: &str| meniscus(&folder, &["run", "--model", model, "--json"]);
    refused(&run("nowhere.blob"), &["nowhere.blob", "cannot read"]);

    let sound = fs::read(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../models/glycerine.blob")))
        .expect("shipped");
    fs::write(folder.join("cut.blob"), &sound[..sound.len() / 2]).expect("written");
    refused(&run("cut.blob"), &["cut.blob", "cut short"]);

    let mut flipped = sound.clone();
    flipped[sound.len() / 2] ^= 4;
    fs::write(folder.join("flipped.blob"), &flipped).expect("written");
    refused(&run("flipped.blob"), &["flipped.blob", "CRC-32"]);

    let mut newer = sound;
    newer[8] = 7;
    fs::write(folder.join("newer.blob"), &newer).expect("written");
    refused(&run("newer.blob"), &["version 7", "versions 3 to 4"]);

    fs::write(folder.join("text.blob"), "not a blob, though long enough to be one").expect("written");
    refused(&run("text.blob"), &["not a weight blob"]);
}

#[test]
fn bad_words_are_refused_before_anything_runs() {
    let folder = folder("words");
    let run = |arguments: &[&str]| meniscus(&folder, &[&["run"], arguments].concat());
    refused(&run(&["--faults", "gremlins:0.1"]), &["gremlins", "drop"]);
    refused(&run(&["--faults", "drop:1.5"]), &["drop:1.5", "from 0 to 1"]);
    refused(&run(&["--seconds", "-3"]), &["-3"]);
    refused(&run(&["--seconds", "0.2"]), &["0.2", "out of range"]);
    refused(&run(&["--source", "nowhere.safetensors"]), &["nowhere.safetensors"]);
    fs::write(folder.join("noise.safetensors"), [7; 100]).expect("written");
    refused(&run(&["--source", "noise.safetensors"]), &["noise.safetensors", "not a recording"]);
    assert!(!folder.join("out").exists(), "nothing is written for a run that never began");
}

#[test]
fn an_output_folder_that_cannot_be_written_is_refused_before_the_run() {
    let folder = folder("out");
    fs::write(folder.join("taken"), "a file stands where the folder should be").expect("written");
    let started = Instant::now();
    let output = meniscus(&folder, &["run", "--seconds", "10", "--out", "taken/inside"]);
    refused(&output, &["--out", "taken/inside"]);
    for flag in ["--estimates", "--turns"] {
        let output = meniscus(&folder, &["run", "--seconds", "10", flag, "taken/inside"]);
        refused(&output, &["cannot make the folder of", "taken/inside"]);
    }
    assert!(started.elapsed().as_secs() < 9, "it must not run for ten seconds first");
    assert_eq!(fs::read_to_string(folder.join("taken")).expect("kept").len(), 40);
}

#[test]
fn help_teaches() {
    let folder = folder("help");
    let help =
        |arguments: &[&str]| String::from_utf8_lossy(&meniscus(&folder, arguments).stdout).into_owned();
    let all = help(&["--help"]);
    for verb in ["run", "simulate", "train", "doctor", "dump"] {
        assert!(all.contains(verb), "{all}");
    }
    let run = help(&["run", "--help"]);
    for word in ["Coasting", "--faults", "drop:0.05", "--json", "Examples"] {
        assert!(run.contains(word), "`{word}` is missing in: {run}");
    }
}

/// As `meniscus ... | head` does, which closes its end early.
#[test]
fn nobody_who_reads_on_is_no_panic() {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let mut command = Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"));
    let output = command.args(["simulate", "--list"]).stdout(writer).output().expect("it starts");
    assert_eq!(output.status.code(), Some(141), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_camera_on_a_bus_goes_into_the_same_turn_and_is_held_against_no_truth() {
    let folder = folder("usb");
    let report = json(&meniscus(&folder, &["run", "--source", "simulated-usb", "--seconds", "4", "--json"]));
    let names: Vec<&str> =
        report["checks"].as_array().expect("checks").iter().filter_map(|c| c["name"].as_str()).collect();
    assert!(names.contains(&"energy_drift_step") && names.contains(&"allocations"), "{names:?}");
    for truth in ["surface", "baseline", "field_error"] {
        assert!(names.iter().all(|name| !name.starts_with(truth)), "{names:?}");
    }
    // A machine with other work delivers late, which costs turns and not correctness.
    assert!(report["modes"]["tracking"].as_u64().is_some_and(|turns| turns > 60), "{}", report["modes"]);
    assert_eq!(report["camera"]["firmware"], "5.16.0.100");
    assert_eq!(report["camera_health"]["frames"], report["camera_health"]["completed"]);

    let refused_run = meniscus(&folder, &["run", "--source", "simulated-usb:recovery"]);
    refused(&refused_run, &["in recovery", "What to do", "rs-fw-update"]);
    refused(&meniscus(&folder, &["run", "--source", "simulated-usb:gremlins"]), &["gremlins", "unplug"]);
}

#[test]
fn the_doctor_finds_what_is_wrong_and_says_what_to_do() {
    let folder = folder("doctor");
    let look = |trouble: &str| -> Value {
        let output = meniscus(&folder, &["doctor", "--json", "--simulated", trouble]);
        serde_json::from_slice(&output.stdout).expect("JSON, whatever is missing")
    };
    let of = |report: &Value, name: &str| -> Value {
        let checks = report["checks"].as_array().expect("checks");
        checks.iter().find(|check| check["name"] == name).expect(name).clone()
    };
    let well = look("");
    for name in ["camera_found", "camera_permitted", "link_usb3", "calibration_read", "depth_unit_um"] {
        assert_eq!(of(&well, name)["ok"], true, "{name}");
    }
    assert!(of(&well, "frame_rate_hz")["value"].as_f64().is_some_and(|rate| rate > 30.0), "{well}");
    let table = [
        ("absent", "camera_found", "USB 3 port"),
        ("denied", "camera_permitted", "60-meniscus-d435.rules"),
        ("usb2", "link_usb3", "flip"),
        ("table-crc", "calibration_read", "calibrate"),
        ("advanced-off", "depth_unit_um", "advanced mode"),
    ];
    for (trouble, check, remedy) in table {
        let report = look(trouble);
        assert_eq!(
            of(&report, check)["value"].as_f64().map(|value| value == 1.0),
            Some(false),
            "{trouble}: {report}"
        );
        let found = report["remedies"][check].as_str().expect("a remedy");
        assert!(found.contains(remedy), "{trouble}: {found}");
    }
}

#[test]
fn a_dump_is_a_file_of_json() {
    let folder = folder("dump");
    let output = meniscus(&folder, &["dump", "--simulated", "--out", "camera.json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = fs::read_to_string(folder.join("camera.json")).expect("the file");
    let dump: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!((dump["format"].as_u64(), dump["product"].as_u64()), (Some(1), Some(0x0b07)));
    assert_eq!(dump["depth"][0]["header"].as_str().map(str::len), Some(2 * 232));

    let broken = meniscus(&folder, &["dump", "--simulated", "probe-format", "--out", "broken.json"]);
    refused(&broken, &["ends early", "format 7"]);
    assert!(folder.join("broken.json").exists(), "what was said until then is kept");
    refused(
        &meniscus(&folder, &["dump", "--simulated", "absent", "--out", "none.json"]),
        &["no depth camera"],
    );
    assert!(!folder.join("none.json").exists());
}
