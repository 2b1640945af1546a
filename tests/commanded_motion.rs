//! The motion of the glass from a controller or a sensor: `meniscus run --motion`.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).expect("a folder");
    folder
}

fn meniscus(folder: &Path, arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_meniscus-under-test");
    Command::new(program).args(arguments).current_dir(folder).output().expect("it starts")
}

fn json(output: &Output) -> Value {
    let message = || String::from_utf8_lossy(&output.stderr).into_owned();
    serde_json::from_slice(&output.stdout).unwrap_or_else(|why| panic!("{why}: {}", message()))
}

fn refused(output: &Output, words: &[&str]) {
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        !output.status.success() && words.iter().all(|word| message.contains(word)),
        "{words:?}: {message}"
    );
}

/// The same run by the edges of the glass and by the motion that the recording was made with.
#[test]
fn a_commanded_motion_halves_the_error_of_the_stresses() {
    let folder = folder("commanded");
    let run = |motion: &[&str]| {
        let words = [&["run", "--patient", "--seconds", "6", "--json"], motion].concat();
        json(&meniscus(&folder, &words))
    };
    let (seen, commanded) = (run(&[]), run(&["--motion", "truth"]));
    let sigma = |report: &Value| report["field_error"]["sigma"].as_f64().expect("scored");
    assert!(sigma(&commanded) < 0.65 * sigma(&seen), "{} {}", sigma(&commanded), sigma(&seen));
    assert_eq!(
        (&seen["motion"], &commanded["motion"]["commanded"]),
        (&Value::Null, &Value::from(360)),
        "{commanded:#}"
    );
    assert_eq!(commanded["motion"]["contradictions"], 0, "the camera sees the true motion: {commanded:#}");

    // A table that ends after two seconds: from there on the edges of the glass tell.
    let table: String = std::iter::once("t,x_m\n".to_owned())
        .chain((0..=200).map(|k| format!("{:.2},0\n", 0.01 * f64::from(k))))
        .collect();
    fs::write(folder.join("still.csv"), table).expect("written");
    let still = run(&["--motion", "still.csv"]);
    assert!(sigma(&still) > sigma(&commanded), "a wrong motion is worth less than the right one: {still:#}");
    assert_eq!(
        still["motion"]["contradictions"], 1,
        "the camera sees that the glass is not still: {still:#}"
    );
    let turns = still["motion"]["commanded"].as_u64().expect("a number");
    assert!((119..=123).contains(&turns) && still["motion"]["tracked"] == 360 - turns, "{still:#}");
    let lifted: String = std::iter::once("t,x_m,z_m\n".to_owned())
        .chain((0..=200).map(|k| format!("{:.2},0,{:.4}\n", 0.01 * f64::from(k), 1e-4 * f64::from(k))))
        .collect();
    fs::write(folder.join("lifted.csv"), lifted).expect("written");
    let lifted = meniscus(&folder, &["run", "--patient", "--motion", "lifted.csv"]);
    refused(&lifted, &["lifted", "motion along x alone"]);
    refused(&meniscus(&folder, &["run", "--motion", "udp:nowhere"]), &["udp:HOST:PORT"]);
}
