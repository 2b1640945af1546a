//! The log: nothing unless `RUST_LOG` asks for it, then the targets and levels that it names, on standard error.

use std::process::{Command, Output, Stdio};

fn run(rust_log: Option<&str>, arguments: &[&str]) -> Output {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("logging");
    std::fs::create_dir_all(&folder).expect("a folder");
    let mut command = Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"));
    command.args(arguments).current_dir(folder).stdin(Stdio::null()).env_remove("RUST_LOG");
    rust_log.map(|value| command.env("RUST_LOG", value));
    command.output().expect("it starts")
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Arguments that record half a second of a simulated camera into `file`.
fn record(file: &str) -> [&str; 8] {
    ["record", "--source", "simulated-usb", "--seconds", "0.5", "--out", file, "--force"]
}

#[test]
fn nothing_is_logged_unless_it_is_asked_for() {
    for rust_log in [None, Some(""), Some("off"), Some("meniscus_nothing=trace")] {
        let output = run(rust_log, &record("quiet.mcap"));
        assert!(output.status.success(), "{}", errors(&output));
        assert!(
            !errors(&output).contains(" INFO ") && !errors(&output).contains("connected:"),
            "{}",
            errors(&output)
        );
    }
}

#[test]
fn targets_and_levels_are_those_that_are_named() {
    let camera = run(Some("meniscus_usb=info"), &record("log.mcap"));
    let said = errors(&camera);
    assert!(said.contains("INFO  meniscus_usb::camera::session] connected: "), "{said}");
    assert!(!said.contains("streams:") && !said.contains("meniscus_cli"), "{said}");
    // Results stay on standard output.
    assert!(!String::from_utf8_lossy(&camera.stdout).contains("meniscus_usb"));
    let deeper = errors(&run(Some("warn,meniscus_usb=debug"), &record("log.mcap")));
    assert!(deeper.contains("DEBUG meniscus_usb::camera::session] streams: "), "{deeper}");
    let all = errors(&run(Some("info"), &record("log.mcap")));
    assert!(all.contains("INFO  meniscus_cli::logging] meniscus "), "{all}");
}

#[test]
fn trouble_of_the_camera_is_a_warning() {
    let mut arguments = record("trouble.mcap");
    (arguments[2], arguments[4]) = ("simulated-usb:unplug", "4");
    let said = errors(&run(Some("warn"), &arguments));
    assert!(said.contains("WARN  meniscus_usb::camera::sink] "), "{said}");
    assert!(!said.contains("INFO "), "{said}");
}
