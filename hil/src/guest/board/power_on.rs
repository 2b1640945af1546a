//! The second boot: the board as the first one left it. Nobody touches it until it tracks.

use super::service::{self, SLOTS, UNIT};
use super::system::{self, run, show, up_s};
use super::{Board, Facts, Step};
use serde_json::json;
use std::path::Path;

/// Longest time for the board to track, seconds.
const PATIENCE_S: u64 = 60;

pub(super) const STEPS: &[Step] = &[("power-on", power_on), ("remove", remove)];

fn power_on(_: &mut Board) -> Facts {
    // The guest's first process starts this one, and then becomes systemd.
    let begun_s = up_s();
    let pid = service::tracking("0", PATIENCE_S)?;
    let tracked_s = service::tracked_at(&pid);
    let first = service::journal()?.into_iter().find(|line| line.pid == pid).map(|line| line.at_s);
    let seconds = |value: Option<&String>| value.and_then(|us| us.parse::<f64>().ok()).map(|us| us * 1e-6);
    // A start that failed says why in its last line.
    let refusals: Vec<String> = service::journal()?
        .into_iter()
        .map(|line| line.text)
        .filter(|text| text.starts_with("error:"))
        .collect();
    let unit = service::properties()?;
    let manager = show(&["--property", "UserspaceTimestampMonotonic,FinishTimestampMonotonic"])?;
    let state = system::wait(PATIENCE_S, || {
        let said = run(&["systemctl", "is-system-running"]).ok()?;
        ["running", "degraded"].contains(&said.out.as_str()).then_some(said.out)
    });
    Ok(json!({ "tracked_s": tracked_s, "first_process_s": begun_s,
               "systemd_s": seconds(manager.get("UserspaceTimestampMonotonic")),
               "started_s": seconds(unit.get("ExecMainStartTimestampMonotonic")), "first_line_s": first,
               "restarts": service::restarts(), "refusals": refusals, "state": state,
               "failed": run(&["systemctl", "list-units", "--failed", "--plain", "--no-legend"])?.out,
               "node": system::node(), "slot": service::slot(),
               "kernel_complaints": super::super::kernel::complaints() }))
}

/// The package goes: first as `apt remove` does, then as `apt purge`.
fn remove(_: &mut Board) -> Facts {
    let removed = run(&["dpkg", "--remove", "meniscus"])?;
    let active = service::properties()?.get("ActiveState").cloned();
    let kept = service::slot();
    let purged = run(&["dpkg", "--purge", "meniscus"])?;
    let wants = format!("/etc/systemd/system/multi-user.target.wants/{UNIT}");
    // A link that leads nowhere is there, too.
    let left: Vec<&str> =
        [SLOTS, "/usr/bin/meniscus", "/etc/meniscus", "/lib/udev/rules.d/60-meniscus-d435.rules", &wants]
            .into_iter()
            .filter(|path| Path::new(path).symlink_metadata().is_ok())
            .collect();
    Ok(json!({ "removed": removed.facts(), "active": active, "slot_kept": kept, "purged": purged.facts(),
               "left": left }))
}
