//! Exposure of the systemd unit, by `systemd-analyze security`.

use crate::report::{Check, Target};
use anyhow::{Context, Result};
use std::path::Path;
use std::process::Command;

/// The unit, and the drop-in that opens the network.
const UNIT: &str = "firmware-config/systemd/meniscus.service";
const NETWORK: &str = "firmware-config/systemd/network.conf";

/// Returns the checks of the unit alone, and with the drop-in. Where systemd's tool is missing both are missed: a value that
/// nobody measured is no value.
pub(super) fn checks(root: &Path, most: f64, most_network: f64) -> Result<Vec<Check>> {
    let folder = root.join("target/trust");
    std::fs::create_dir_all(&folder)?;
    let read = |path: &str| std::fs::read_to_string(root.join(path)).with_context(|| path.to_owned());
    let unit = read(UNIT)?;
    // A drop-in is read behind the unit; an empty assignment is not needed, as lists of addresses add up.
    let opened = folder.join("meniscus.service");
    std::fs::write(&opened, format!("{unit}\n{}", read(NETWORK)?))?;
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
