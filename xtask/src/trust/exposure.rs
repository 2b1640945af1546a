//! Exposure of the systemd unit, by `systemd-analyze security`.

use crate::built;
use crate::report::{Check, Target};
use anyhow::{Context, Result};
use std::path::Path;
use std::process::Command;

/// The unit.
const UNIT: &str = "firmware-config/systemd/meniscus.service";

/// Configuration of a service that publishes, listens and shows its page in the network.
const NETWORK: &str = r#"
[images]
source = "usb"
[time]
service = true
[publishing]
publish = ["udp:192.168.1.5:9000", "unix:/run/meniscus/estimates"]
[live_view]
view = true
listen = "0.0.0.0:8060"
[motion_of_the_glass]
motion = "udp:0.0.0.0:9001"
motion_from = "192.168.1.5"
[output]
out = "/var/lib/meniscus/last-run"
"#;

/// Returns the checks of the unit alone, and with the drop-in. Where systemd's tool is missing both are missed: a value that
/// nobody measured is no value.
pub(super) fn checks(root: &Path, most: f64, most_network: f64) -> Result<Vec<Check>> {
    let folder = root.join("target/trust");
    std::fs::create_dir_all(&folder)?;
    let read = |path: &str| std::fs::read_to_string(root.join(path)).with_context(|| path.to_owned());
    let unit = read(UNIT)?;
    let opened = folder.join("meniscus.service");
    // A drop-in is read behind the unit; lists of addresses add up.
    std::fs::write(&opened, format!("{unit}\n{}", drop_in(root, &folder)?))?;
    let check = |name, path: &Path, most| {
        let value = exposure(path);
        let offenders =
            value.is_none().then(|| "systemd-analyze security --offline=true is missing".to_owned());
        let value = value.unwrap_or(f64::INFINITY);
        Check {
            name,
            value,
            unit: "of 10",
            target: Target::AtMost(most),
            offenders: offenders.into_iter().collect(),
        }
    };
    Ok(vec![
        check("unit_exposure", &root.join(UNIT), most),
        check("unit_exposure_network", &opened, most_network),
    ])
}

/// Returns the drop-in that the program writes for [`NETWORK`].
fn drop_in(root: &Path, folder: &Path) -> Result<String> {
    let config = folder.join("network.toml");
    std::fs::write(&config, NETWORK)?;
    let status = Command::new(built::program(root, "release", "meniscus-under-test")?)
        .args(["service", "configure", "--config"])
        .arg(&config)
        .arg("--to")
        .arg(folder)
        .current_dir(root)
        .stdout(std::process::Stdio::null())
        .status()?;
    anyhow::ensure!(status.success(), "meniscus service configure failed for {}", config.display());
    std::fs::read_to_string(folder.join("configured.conf")).context("the drop-in is missing")
}

fn exposure(unit: &Path) -> Option<f64> {
    let words = ["security", "--offline=true", "--no-pager"];
    let output = Command::new("systemd-analyze").args(words).arg(unit).output().ok()?;
    parse(&String::from_utf8_lossy(&output.stdout))
}

/// Reads `Overall exposure level for NAME: 1.4 OK`.
fn parse(text: &str) -> Option<f64> {
    let line = text.lines().find(|line| line.contains("Overall exposure level"))?;
    line.split(": ").nth(1)?.split(' ').next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_level_is_read() {
        assert_eq!(parse("x\n→ Overall exposure level for meniscus.service: 7.7 EXPOSED 🙁\n"), Some(7.7));
        assert_eq!(parse("no such tool"), None);
    }
}
