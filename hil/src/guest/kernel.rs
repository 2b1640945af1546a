//! Facts of the guest's kernel: the camera in sysfs, and the kernel's own complaints.

use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// The camera as the kernel enumerated it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Enumerated {
    port: String,
    speed_mbit: String,
    interfaces: usize,
    product: String,
    serial: String,
}

impl Enumerated {
    pub(crate) fn json(&self) -> Value {
        json!({ "port": self.port, "speed_mbit": self.speed_mbit, "interfaces": self.interfaces,
                "product": self.product, "serial": self.serial })
    }
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_default().trim().to_owned()
}

/// The camera in sysfs, with all of its interfaces.
fn look() -> Option<Enumerated> {
    let devices = fs::read_dir("/sys/bus/usb/devices").ok()?;
    devices.flatten().find_map(|entry| {
        let path = entry.path();
        if text(&path.join("idVendor")) != "8086" {
            return None;
        }
        let stated = text(&path.join("bNumInterfaces")).parse().unwrap_or(0);
        let name = entry.file_name().to_string_lossy().into_owned();
        let there = fs::read_dir(&path).ok()?.flatten();
        let interfaces = there.filter(|e| e.file_name().to_string_lossy().contains(':')).count();
        (stated > 0 && stated == interfaces).then(|| Enumerated {
            port: name,
            speed_mbit: text(&path.join("speed")),
            interfaces,
            product: text(&path.join("idProduct")),
            serial: text(&path.join("serial")),
        })
    })
}

/// Waits until the kernel has enumerated the camera; how long that took.
pub(crate) fn wait_for_camera(limit: Duration) -> Option<(Enumerated, Duration)> {
    let begun = Instant::now();
    while begun.elapsed() < limit {
        if let Some(found) = look() {
            return Some((found, begun.elapsed()));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    None
}

/// Lines of the kernel's log that tell of a fault of the kernel.
pub(crate) fn complaints() -> Vec<String> {
    const WORDS: [&str; 7] = [
        "WARNING:",
        "BUG:",
        "Oops",
        "Call trace",
        "blocked for more",
        "Out of memory",
        // The first file system is not whole: the rest of a film is black.
        "Initramfs unpacking failed",
    ];
    let Ok(log) = Command::new("/bin/busybox").arg("dmesg").output() else {
        return vec!["the kernel's log cannot be read".into()];
    };
    let log = String::from_utf8_lossy(&log.stdout).into_owned();
    log.lines().filter(|line| WORDS.iter().any(|word| line.contains(word))).map(str::to_owned).collect()
}
