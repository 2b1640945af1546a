//! Messages of a camera that is another one, is hot, or brings nothing that can be used.

#[path = "support/program.rs"]
mod program;

use program::{errors, folder, json, meniscus};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Output;

fn refused(output: &Output, words: &[&str]) {
    let message = errors(output);
    assert!(
        !output.status.success() && words.iter().all(|word| message.contains(word)),
        "{words:?}: {message}"
    );
}

#[test]
fn a_hot_laser_is_reported_while_the_run_goes_and_in_its_report() {
    let folder = folder("camera-messages", "hot");
    let run = meniscus(&folder, "run --source simulated-usb:interrupt-off --seconds 3 --json");
    let hot = "the laser is too hot, it was turned off (error 2 of the camera)";
    assert!(errors(&run).contains(&format!("camera: {hot}")), "{}", errors(&run));
    assert_eq!(json(&run)["camera_notes"], serde_json::json!([hot]));
}

#[test]
fn doctor_says_what_the_camera_says() {
    let folder = folder("camera-messages", "doctor");
    let doctor = json(&meniscus(&folder, "doctor --simulated interrupt-off --json"));
    let checks = doctor["checks"].as_array().expect("checks");
    let error = checks.iter().find(|check| check["name"] == "camera_errors").expect("the check");
    assert_eq!((error["value"].as_f64(), error["ok"].as_bool()), (Some(1.0), Some(false)), "{error}");
    let remedy = doctor["remedies"]["camera_errors"].as_str().expect("a remedy");
    assert!(remedy.contains("too hot") && remedy.contains("cool"), "{remedy}");
    let well = json(&meniscus(&folder, "doctor --simulated --json"));
    let quiet = |check: &Value| check["name"] == "camera_errors" && check["ok"] == true;
    assert!(well["checks"].as_array().expect("checks").iter().any(quiet), "{well:#}");
}

#[test]
fn another_realsense_is_named() {
    let folder = folder("camera-messages", "other");
    let words = ["RealSense L515", "use a D435 or D435i"];
    refused(&meniscus(&folder, "run --source simulated-usb:other-camera --seconds 2"), &words);
    refused(&meniscus(&folder, "record --source simulated-usb:other-camera --out a.mcap"), &words);
    let doctor = json(&meniscus(&folder, "doctor --simulated other-camera --json"));
    assert!(doctor["camera_error"].as_str().is_some_and(|why| why.contains("L515")), "{doctor:#}");
}

#[test]
fn a_camera_without_infrared_runs_by_its_colour_image() {
    let folder = folder("camera-messages", "colour");
    let words = ["no infrared images", "--outline colour"];
    refused(&meniscus(&folder, "record --source simulated-usb:no-infrared --out a.mcap"), &words);
    assert!(!folder.join("a.mcap").exists());
    let remedy = "record --source simulated-usb:no-infrared --outline colour --seconds 1 --out a.mcap";
    let made = meniscus(&folder, remedy);
    assert!(made.status.success(), "{}", errors(&made));
}

/// A real D435 whose recording has depth and colour images, and no infrared ones.
#[test]
fn a_recording_of_which_nothing_can_be_used_is_a_failure_and_leaves_nothing() {
    let folder = folder("camera-messages", "nothing");
    let bag = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/camera/single_depth_color_640x480.bag");
    for out in ["a.mcap", "b"] {
        let made = meniscus(&folder, &format!("record --source {} --out {out}", bag.display()));
        refused(&made, &["2 depth images came and no infrared image", "--outline"]);
        assert!(!folder.join(out).exists(), "{out} was left behind");
    }
    let own = folder.join("own");
    fs::create_dir_all(&own).expect("a folder");
    let silent = meniscus(&folder, "record --source simulated-usb:absent --out own/c.mcap");
    refused(&silent, &["no depth camera"]);
    assert_eq!(fs::read_dir(&own).expect("a folder").count(), 0);
}

#[test]
fn a_recording_at_30_hz_says_so() {
    let folder = folder("camera-messages", "slow");
    let made = meniscus(&folder, "record --source simulated-usb --seconds 2 --out fast");
    assert!(made.status.success(), "{}", errors(&made));
    let table = fs::read_to_string(folder.join("fast/frames.csv")).expect("the table");
    let whole = meniscus(&folder, "run --source fast --json");
    assert!(!errors(&whole).contains("images a second"), "{}", errors(&whole));
    let mut lines = table.lines();
    let half: String =
        lines.next().into_iter().chain(lines.step_by(2)).map(|line| format!("{line}\n")).collect();
    // 30, less what the recording lost: on a busy machine the simulated camera's host does not take every frame.
    let times: Vec<f64> =
        half.lines().skip(1).filter_map(|line| line.split(',').nth(1)?.parse().ok()).collect();
    let due = (times.len() - 1) as f64 / (times[times.len() - 1] - times[0]);
    fs::write(folder.join("fast/frames.csv"), half).expect("written");
    let run = meniscus(&folder, "run --source fast --json");
    let said = errors(&run);
    let rate = said.split(" depth images a second").next().and_then(|text| text.rsplit(' ').next());
    let rate: f64 = rate.and_then(|rate| rate.parse().ok()).unwrap_or_else(|| panic!("{said}"));
    // It is said as a whole number.
    assert!((rate - due).abs() <= 0.51 && (20.0..31.0).contains(&due), "{due} images a second: {said}");
}
