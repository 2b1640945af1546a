//! The service as systemd and its journal tell of it.

use super::system::{run, show, wait};
use serde_json::{Value, json};
use std::collections::HashMap;
use std::io;

/// Its unit.
pub(super) const UNIT: &str = "meniscus.service";
/// Where its slots are.
pub(super) const SLOTS: &str = "/var/lib/meniscus";

/// Its properties, as far as anybody asks.
pub(super) fn properties() -> io::Result<HashMap<String, String>> {
    let keys = "MainPID,NRestarts,ActiveState,UnitFileState,StatusText,WatchdogUSec,Result,\
                ExecMainStartTimestampMonotonic,ActiveEnterTimestampMonotonic";
    show(&[UNIT, "--property", keys])
}

/// Waits until a process other than `old` tracks, for at most `seconds`; its number.
pub(super) fn tracking(old: &str, seconds: u64) -> Result<String, Box<dyn std::error::Error>> {
    let found = wait(seconds, || {
        let now = properties().ok()?;
        let pid = now.get("MainPID")?.clone();
        (pid != "0" && pid != old && now.get("StatusText")? == "Tracking").then_some(pid)
    });
    found.ok_or_else(|| {
        let lines =
            journal().map(|lines| lines.into_iter().map(|line| line.text).collect()).unwrap_or_default();
        let last: Vec<String> = Vec::into_iter(lines).rev().take(6).collect();
        format!("no tracking within {seconds} s; {:?}; the journal ends with {last:?}", properties().ok())
            .into()
    })
}

/// A line of the service's journal.
#[derive(Clone, Debug)]
pub(super) struct Line {
    /// When, seconds since the kernel's first moment.
    pub(super) at_s: f64,
    /// Process that wrote it.
    pub(super) pid: String,
    /// The text.
    pub(super) text: String,
}

/// The journal of this boot, in the service's own namespace.
pub(super) fn journal() -> io::Result<Vec<Line>> {
    lines(&["--namespace=meniscus"])
}

/// Lines of systemd itself about the unit.
pub(super) fn about() -> io::Result<Vec<Line>> {
    lines(&["--unit", UNIT, "_PID=1"])
}

fn lines(which: &[&str]) -> io::Result<Vec<Line>> {
    let said = run(&[&["journalctl", "--boot", "--output=json"], which].concat())?;
    let read = |line: &str| {
        let value: Value = serde_json::from_str(line).ok()?;
        let word = |key: &str| value[key].as_str().unwrap_or_default().to_owned();
        let at_us: f64 = word("__MONOTONIC_TIMESTAMP").parse().ok()?;
        Some(Line { at_s: at_us * 1e-6, pid: word("_PID"), text: word("MESSAGE") })
    };
    Ok(said.out.lines().filter_map(read).collect())
}

/// When a process first tracked, seconds since the kernel's first moment, by the journal.
pub(super) fn tracked_at(pid: &str) -> Option<f64> {
    let journal = journal().ok()?;
    journal.iter().find(|line| line.pid == pid && line.text == "mode: Tracking").map(|line| line.at_s)
}

/// Number of restarts by systemd.
pub(super) fn restarts() -> u64 {
    let count = properties().ok().and_then(|all| all.get("NRestarts")?.parse().ok());
    count.unwrap_or(u64::MAX)
}

/// The slot that boots, and a sum of what it holds.
pub(super) fn slot() -> Value {
    let active = std::fs::read_to_string(format!("{SLOTS}/active")).unwrap_or_default();
    let active = active.trim();
    let sum = run(&["sha256sum", &format!("{SLOTS}/slot-{active}.blob")]);
    let sum = sum.map(|said| said.out.split(' ').next().unwrap_or_default().to_owned()).unwrap_or_default();
    json!({ "active": active, "sha256": sum })
}
