//! The installed service's configuration: `meniscus run --config` and `meniscus service`.

#[path = "support/program.rs"]
mod program;

use program::{errors, folder, json, meniscus};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

fn value(report: &Value, name: &str) -> Option<f64> {
    let check = report["checks"].as_array()?.iter().find(|check| check["name"] == name)?;
    check["value"].as_f64()
}

#[test]
fn a_run_by_its_file_is_the_run_by_its_options() {
    let folder = folder("service", "run");
    fs::write(folder.join("a.toml"), "[time]\npatient = true\nseconds = 2\n[output]\njson = true\n")
        .expect("written");
    let errors_of = |report: &Value| (report["frames"].clone(), report["surface_error"].clone());
    let by_file = json(&meniscus(&folder, "run --config a.toml"));
    let by_options = json(&meniscus(&folder, "run --patient --seconds 2 --json"));
    assert!(by_file["surface_error"].is_object(), "{by_file:#}");
    assert_eq!(errors_of(&by_file), errors_of(&by_options));
    let longer = json(&meniscus(&folder, "run --config a.toml --seconds 3"));
    assert_eq!(longer["frames"], 180, "the command line goes before the file");
}

#[test]
fn a_wrong_line_is_named_with_its_number_and_reported_to_systemd() {
    let folder = folder("service", "wrong");
    fs::write(folder.join("a.toml"), "[time]\nservice = true\n\n[images]\nsorce = \"usb\"\n")
        .expect("written");
    let socket = folder.join("notify");
    let notify = std::os::unix::net::UnixDatagram::bind(&socket).expect("a socket");
    let run = Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
        .args(["run", "--config", "a.toml"])
        .current_dir(&folder)
        .env("NOTIFY_SOCKET", &socket)
        .output()
        .expect("it starts");
    let words = ["a.toml, line 5", "'sorce'", "source"];
    assert!(
        !run.status.success() && words.iter().all(|word| errors(&run).contains(word)),
        "{}",
        errors(&run)
    );
    let mut message = [0; 1024];
    let length = notify.recv(&mut message).expect("systemd is informed");
    let message = String::from_utf8_lossy(&message[..length]).into_owned();
    assert!(message.starts_with("STATUS=error: a.toml, line 5"), "{message}");
}

#[test]
fn check_says_what_is_missing_and_configure_mends_it() {
    let folder = folder("service", "check");
    let config = "[images]\nsource = \"usb\"\n[time]\nservice = true\n\
                  [publishing]\npublish = [\"udp:192.168.1.5:9000\", \"unix:/run/meniscus/estimates\"]\n\
                  [output]\nout = \"/var/lib/meniscus/last-run\"\n";
    fs::write(folder.join("a.toml"), config).expect("written");
    let check = || json(&meniscus(&folder, "service check --config a.toml --to drop-ins --json"));
    let before = check();
    assert_eq!(
        (value(&before, "configuration_good"), value(&before, "sandbox_opened")),
        (Some(1.0), Some(0.0))
    );
    let opens = before["opens"].as_array().expect("lines");
    assert!(opens.contains(&Value::from("network: 192.168.1.5")), "{before:#}");
    let made = meniscus(&folder, "service configure --config a.toml --to drop-ins");
    assert!(made.status.success(), "{}", errors(&made));
    let text = fs::read_to_string(folder.join("drop-ins/configured.conf")).expect("the drop-in");
    assert!(
        text.contains("IPAddressAllow=192.168.1.5\n") && text.contains("RuntimeDirectory=meniscus\n"),
        "{text}"
    );
    assert_eq!(value(&check(), "sandbox_opened"), Some(1.0));
    // A file that asks for more than what was opened.
    fs::write(folder.join("a.toml"), config.replace("192.168.1.5", "192.168.1.6")).expect("written");
    assert_eq!(value(&check(), "sandbox_opened"), Some(0.0));
    fs::write(
        folder.join("a.toml"),
        config.replace("source = \"usb\"", "source = \"usb\"\nsetup = \"/none.toml\""),
    )
    .expect("written");
    let faulty = check();
    assert_eq!(value(&faulty, "configuration_good"), Some(0.0));
    assert!(
        faulty["remedies"]["configuration_good"].as_str().is_some_and(|why| why.contains("/none.toml")),
        "{faulty:#}"
    );
    fs::write(folder.join("a.toml"), config.replace("service = true", "service = false")).expect("written");
    let ends = check();
    assert!(
        ends["remedies"]["configuration_good"].as_str().is_some_and(|why| why.contains("service = true")),
        "{ends:#}"
    );
}

/// Nodes of ROS 2 find each other by multicast, at addresses that nobody knows before.
#[test]
fn the_sandbox_is_opened_for_the_networks_of_ros_2() {
    let folder = folder("service", "ros2");
    for (name, options, allowed) in [
        ("all", "ros2 = 5\n", "localhost link-local 192.168.0.0/16 10.0.0.0/8 172.16.0.0/12 multicast"),
        ("alone", "ros2 = true\nros2_network = [\"127.0.0.1\"]\n", "localhost multicast"),
    ] {
        let text = format!("[images]\nsource = \"usb\"\n[time]\nservice = true\n[ros2]\n{options}");
        fs::write(folder.join("a.toml"), text).expect("written");
        let made = meniscus(&folder, &format!("service configure --config a.toml --to {name}"));
        assert!(made.status.success(), "{}", errors(&made));
        let text = fs::read_to_string(folder.join(name).join("configured.conf")).expect("the drop-in");
        assert!(text.contains(&format!("IPAddressAllow={allowed}\n")), "{text}");
        assert!(text.contains("RestrictAddressFamilies=AF_INET AF_INET6\n"), "{text}");
    }
}

/// The configuration of the package, with a model that was flashed.
#[test]
fn the_file_of_the_package_is_good() {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware-config/systemd/meniscus.toml");
    let folder = folder("service", "package");
    let text = fs::read_to_string(shipped).expect("the file");
    let board = Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware-config/boards/raspberry-pi-5.toml");
    let text = text
        .replace("/etc/meniscus/board.toml", &board.canonicalize().expect("a profile").display().to_string())
        .replace("\"/var/lib/meniscus\"", "\"slots\"");
    fs::write(folder.join("meniscus.toml"), text).expect("written");
    let flashed = meniscus(&folder, "flash shipped --to slots");
    assert!(flashed.status.success(), "{}", errors(&flashed));
    let check = json(&meniscus(&folder, "service check --config meniscus.toml --to none --json"));
    assert_eq!(value(&check, "configuration_good"), Some(1.0), "{check:#}");
}
