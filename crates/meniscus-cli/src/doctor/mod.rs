//! `meniscus doctor`: is this machine ready, and what is to be done if not.

mod look;

use super::bus;
use anyhow::bail;
pub(crate) use look::Camera;
use look::look;
use meniscus_platform::realtime;
use meniscus_report::checks::{Check, table};
use meniscus_service::camera_facts::{camera_json, camera_line};
use meniscus_usb::camera::{CameraError, Note, Settings};
use meniscus_usb::transport::Speed;
use serde_json::{Value, json};
use std::time::Duration;

/// Frames a second that a camera must reach: 60 less what the two ends of the counting cost.
const RATE_HZ: f64 = 58.0;
/// Memory that should be lockable: model, field and buffers.
const LOCKED_MB: f64 = 64.0;

/// Check camera and machine, with a remedy for each fault.
///
/// Camera: found, permission, link speed, calibration, frame rate over 2 s. Machine: real-time rights, lockable memory, memory
/// for USB transfers. The exit status is 1 if anything is missing.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus doctor\n  meniscus doctor --json\n  meniscus doctor --simulated\n  meniscus doctor --simulated usb2"
)]
pub(crate) struct Arguments {
    /// Look at a simulated camera instead, with a trouble by name or number.
    #[arg(
        long,
        value_name = "TROUBLE",
        num_args = 0..=1,
        default_missing_value = "",
        help_heading = "Camera"
    )]
    simulated: Option<String>,
    /// Serial number of the only camera that is taken, as USB shows it.
    #[arg(long, help_heading = "Camera")]
    serial: Option<String>,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let settings = Settings {
        serial: arguments.serial.clone(),
        patience: Duration::from_secs(10),
        ..Settings::default()
    };
    let bar = crate::bars::spinner().with_message("looking at the camera");
    bar.enable_steady_tick(Duration::from_millis(100));
    let camera = match &arguments.simulated {
        Some(trouble) => look(bus::simulated(trouble)?, settings),
        None => match bus::machine() {
            Ok(machine) => look(machine, settings),
            Err(error) => Camera { rate_hz: f64::NAN, error: Some(error), ..Camera::default() },
        },
    };
    bar.finish_and_clear();
    let findings = findings(&camera);
    let checks: Vec<&Check> = findings.iter().map(|(check, _)| check).collect();
    let missed: Vec<&(Check, String)> = findings.iter().filter(|(check, _)| check.missed()).collect();
    if arguments.json {
        let remedies: serde_json::Map<String, Value> =
            missed.iter().map(|(check, remedy)| (check.name.clone(), json!(remedy))).collect();
        let report = json!({
            "command": "meniscus doctor",
            "version": env!("CARGO_PKG_VERSION"),
            "camera": camera.connected.as_ref().map(camera_json),
            "camera_error": camera.error.as_ref().map(CameraError::to_string),
            "camera_health": camera.health,
            "remedies": remedies,
            "checks": checks,
        });
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        print!("{}", text(&camera, &findings));
    }
    if missed.is_empty() { Ok(()) } else { bail!("{} of {} checks missed", missed.len(), findings.len()) }
}

/// Every check with what to do if it is missed.
fn findings(camera: &Camera) -> Vec<(Check, String)> {
    let mut all = camera_findings(camera);
    all.extend(machine_findings(camera));
    all
}

/// The camera's checks, each with what to do if it is missed.
pub(crate) fn camera_findings(camera: &Camera) -> Vec<(Check, String)> {
    let is = |it: bool| f64::from(u8::from(it));
    let connected = camera.connected.as_ref();
    let error = camera.error.as_ref().map_or(String::new(), CameraError::to_string);
    let known = |value: Option<bool>| value.map_or(f64::NAN, is);
    let permitted = match &camera.error {
        Some(CameraError::NoAccess(_)) => Some(false),
        Some(
            CameraError::NoBus(_)
            | CameraError::NoCamera(_)
            | CameraError::OtherCamera { .. }
            | CameraError::Recovery(_)
            | CameraError::SlowLink(_),
        ) => None,
        // Every other error comes from behind the opening.
        _ => Some(true),
    };
    let calibrated = match &camera.error {
        Some(CameraError::Table(_) | CameraError::Calibration(_) | CameraError::Monitor { .. }) => {
            Some(false)
        }
        _ => connected.map(|_| true),
    };
    let fast = match &camera.error {
        Some(CameraError::SlowLink(_)) => Some(false),
        _ => connected.map(|camera| camera.device.speed == Speed::Super),
    };
    let found = connected.is_some()
        || !matches!(
            camera.error,
            Some(CameraError::NoCamera(_) | CameraError::OtherCamera { .. } | CameraError::NoBus(_))
        );
    let lost = camera.health.damaged + camera.health.errors + camera.health.overflows + camera.health.stalls;
    let slow = CameraError::SlowLink(String::new());
    vec![
        (Check::exactly("camera_found", is(found), "1", 1.0), error.clone()),
        (Check::exactly("camera_permitted", known(permitted), "1", 1.0), error.clone()),
        (
            Check::exactly("link_usb3", known(fast), "1", 1.0),
            if fast == Some(false) { slow.remedy().into() } else { error.clone() },
        ),
        (Check::exactly("calibration_read", known(calibrated), "1", 1.0), error.clone()),
        (
            Check::exactly(
                "depth_unit_um",
                connected.map_or(f64::NAN, |c| f64::from(c.depth_unit_um)),
                "um",
                100.0,
            ),
            if connected.is_some() {
                "turn the advanced mode on with Intel's viewer: 1 mm steps hide small waves".into()
            } else {
                error.clone()
            },
        ),
        (
            Check::at_least(
                "frame_rate_hz",
                if connected.is_some() { camera.rate_hz } else { f64::NAN },
                "Hz",
                RATE_HZ,
            ),
            if error.is_empty() {
                "leave the machine alone for 2 s, plug the camera into a port of its own".into()
            } else {
                error.clone()
            },
        ),
        (Check::informational("transfers_damaged", lost as f64, "1"), String::new()),
        (Check::exactly("camera_errors", camera.reported.len() as f64, "1", 0.0), reported(camera)),
    ]
}

/// Errors that the camera reported, in one line.
fn reported(camera: &Camera) -> String {
    let reported: Vec<String> = camera.reported.iter().map(Note::to_string).collect();
    format!("the camera said: {}; let it cool, give it air, or plug it in again", reported.join("; "))
}

/// The machine's checks, each with what to do if it is missed.
fn machine_findings(camera: &Camera) -> Vec<(Check, String)> {
    let is = |it: bool| f64::from(u8::from(it));
    let usbfs_mb = std::fs::read_to_string("/sys/module/usbcore/parameters/usbfs_memory_mb");
    let usbfs_mb = usbfs_mb.ok().and_then(|text| text.trim().parse::<f64>().ok());
    // 0 stands for "no limit" there.
    let usbfs_mb = usbfs_mb.map_or(f64::NAN, |mb| if mb == 0.0 { f64::MAX } else { mb });
    let realtime = std::thread::spawn(realtime::become_realtime).join();
    let granted = matches!(realtime, Ok(Ok(())));
    let limits = "add to /etc/security/limits.d/meniscus.conf the lines \"@plugdev - rtprio 40\" and \
                  \"@plugdev - memlock unlimited\", join the group plugdev, log in again";
    let usbfs = "echo 64 | sudo tee /sys/module/usbcore/parameters/usbfs_memory_mb";
    let limit = |limit: Option<u64>| limit.map_or(f64::MAX, |limit| limit as f64);
    vec![
        (priority_limit(granted), limits.into()),
        (Check::exactly("realtime_granted", is(granted), "1", 1.0), limits.into()),
        (
            Check::at_least(
                "locked_memory_mb",
                limit(realtime::locked_memory_limit()) / f64::from(1 << 20),
                "MiB",
                LOCKED_MB,
            ),
            limits.into(),
        ),
        (
            Check::at_least("usbfs_memory_mb", usbfs_mb, "MiB", camera.transfers_mb.max(5.0).ceil()),
            if usbfs_mb.is_nan() {
                "this kernel has no USB (module usbcore): use a machine that has".into()
            } else {
                usbfs.into()
            },
        ),
    ]
}

/// The limit on real-time priorities; informational where the right comes from elsewhere, as for root.
fn priority_limit(granted: bool) -> Check {
    let (name, limit) =
        ("realtime_priority_limit", realtime::priority_limit().map_or(99.0, |limit| limit as f64));
    if granted {
        Check::informational(name, limit, "1")
    } else {
        Check::at_least(name, limit, "1", realtime::PRIORITY.into())
    }
}

/// For a person: the table, then what to do, each remedy once.
fn text(camera: &Camera, findings: &[(Check, String)]) -> String {
    let mut text = camera.connected.as_ref().map_or(String::new(), |camera| camera_line(camera) + "\n");
    let checks: Vec<Check> = findings.iter().map(|(check, _)| check.clone()).collect();
    text += &table(&checks);
    let mut remedies: Vec<&str> = Vec::new();
    // What was measured and missed first: the rest could not be measured because of it.
    let missed = || findings.iter().filter(|(check, _)| check.missed());
    let (measured, unmeasured) =
        (missed().filter(|(c, _)| c.value.is_some()), missed().filter(|(c, _)| c.value.is_none()));
    for (check, remedy) in measured.chain(unmeasured) {
        if !remedies.contains(&remedy.as_str()) {
            remedies.push(remedy);
            text += &format!("{}: {remedy}\n", check.name);
        }
    }
    text
}
