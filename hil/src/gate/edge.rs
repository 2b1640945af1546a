//! The edge board's verdict: what the two boots' steps came to.

use super::Failure;
use super::checks::{self, Check, at_most, check, must};
use super::judge::{at, number};
use super::log::Log;
use serde_json::{Value, json};
use std::path::Path;

/// From the kernel's first moment to the first tracked frame, seconds of the guest.
const BOOT_S: f64 = 20.0;
/// From systemd's start of the service to the same.
const START_S: f64 = 2.0;
/// From a plug to the same. The gate allows 1.5 s, and there the program is root and nobody waits for udev.
const REPLUG_S: f64 = 2.0;
/// From a kill to the same: a second of rest, and a start.
const KILL_S: f64 = 4.0;
/// From a hang to the same: the watchdog's 5 s, the end, a second of rest, a start.
const HANG_S: f64 = 12.0;
/// What the service's journal may hold, bytes; and what has to be written for that to be a test.
const JOURNAL_BYTES: f64 = 32.0 * 1048576.0;
const WRITTEN_BYTES: f64 = 36.0 * 1048576.0;

/// Judges the boot in which the package was installed and the one behind it. `true` when every check is met.
pub(crate) fn judge(logs: [&Path; 2], json: bool, wall_s: f64) -> Result<bool, Failure> {
    let [install, power_on] = [Log::read(logs[0])?, Log::read(logs[1])?];
    let mut checks = of(&install, &power_on);
    let passed = checks.iter().all(|check| check.4);
    checks.push(check("wall_s", wall_s, "s", "told", true));
    let steps: Vec<&(String, Value)> = install.facts.iter().chain(&power_on.facts).collect();
    if json {
        let steps: Vec<Value> =
            steps.iter().map(|(step, facts)| json!({ "step": step, "facts": facts })).collect();
        let report = json!({ "command": "hil/run boot", "steps": steps, "checks": checks::json(&checks) });
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        checks::print(&checks);
    }
    for (step, facts) in steps {
        if let Some(error) = facts["error"].as_str() {
            eprintln!("{step}: {error}");
        }
    }
    Ok(passed)
}

/// The camera's node as the rule makes it.
fn by_the_rule(node: &Value) -> bool {
    node["owner"] == "root" && node["group"] == "plugdev" && node["mode"] == "0660"
}

/// A slot that holds something, and the same in both.
fn same_slot(one: &Value, other: &Value) -> bool {
    one["sha256"].as_str().is_some_and(|sum| sum.len() == 64) && one == other
}

fn of(install: &Log, power_on: &Log) -> Vec<Check> {
    let nothing = Value::Null;
    let first = |step| install.of(step).unwrap_or(&nothing);
    let second = |step| power_on.of(step).unwrap_or(&nothing);
    let (before, installed, rights) = (first("before"), first("install"), first("rights"));
    let (replug, kill, hang) = (first("replug"), first("kill"), first("hang"));
    let (journal, upgrade, disabled, left) =
        (first("journal"), first("upgrade"), first("disabled"), first("left"));
    let (on, removed) = (second("power-on"), second("remove"));
    let priorities = at(rights, "rights.fifo_priorities").as_array().cloned().unwrap_or_default();
    let tracked_s = number(on, "tracked_s");
    let quiet = |facts: &Value| facts["failed"] == "" && facts["kernel_complaints"] == json!([]);
    vec![
        must(
            "boot_installed",
            installed["dpkg"]["exit"] == 0
                && before["user"] == false
                && installed["enabled"] == "enabled"
                && installed["restarts"] == 0,
        ),
        check(
            "boot_install_to_tracking_s",
            number(installed, "to_tracking_s"),
            "s",
            "told",
            installed["to_tracking_s"].is_number(),
        ),
        // Without the rule the node is root's alone: it is the rule that made it so.
        must(
            "boot_udev_rule_applied",
            !before["node"].is_null()
                && !by_the_rule(&before["node"])
                && by_the_rule(&installed["node"])
                && by_the_rule(&replug["node"])
                && by_the_rule(&on["node"]),
        ),
        must(
            "boot_realtime_granted",
            priorities.len() >= 2
                && priorities.iter().all(|it| *it == 40)
                && rights["refused"] == json!([])
                && number(rights, "rights.locked_kib") > 0.0,
        ),
        must(
            "boot_unprivileged",
            at(rights, "rights.user") == "meniscus"
                && at(rights, "rights.group") == "plugdev"
                && at(rights, "rights.capabilities") == "0000000000000000"
                && at(rights, "rights.no_new_privileges") == "1",
        ),
        must("boot_watchdog_armed", rights["watchdog"] == "5s"),
        must(
            "boot_replug_survived",
            replug["noticed"] == true && replug["same_process"] == true && replug["restarted"] == 0,
        ),
        at_most("boot_replug_to_tracking_s", number(replug, "to_tracking_s"), "s", REPLUG_S),
        must("boot_restarted_after_kill", kill["restarts"] == 1),
        at_most("boot_kill_to_tracking_s", number(kill, "to_tracking_s"), "s", KILL_S),
        must("boot_restarted_after_watchdog", hang["restarts"] == 1 && hang["by_watchdog"] == true),
        at_most("boot_hang_to_tracking_s", number(hang, "to_tracking_s"), "s", HANG_S),
        check(
            "boot_journal_mib",
            number(journal, "kept_bytes") / 1048576.0,
            "MiB",
            "<= 32, tracking on",
            number(journal, "written_bytes") >= WRITTEN_BYTES
                && number(journal, "kept_bytes") <= JOURNAL_BYTES
                && number(journal, "kept_bytes") > 0.0
                && journal["tracks_on"] == true,
        ),
        must(
            "boot_upgraded",
            upgrade["before"] != upgrade["behind"]
                && upgrade["behind"].is_string()
                && upgrade["program"] == "/usr/bin/meniscus"
                && upgrade["enabled"] == "enabled",
        ),
        // The person's model, not the shipped one that the first installation wrote.
        must(
            "boot_upgrade_keeps_blob",
            same_slot(&upgrade["slot_before"], &upgrade["slot"])
                && upgrade["slot"]["sha256"] != installed["slot"]["sha256"],
        ),
        must("boot_upgrade_keeps_profile", upgrade["profile_kept"] == true),
        must(
            "boot_upgrade_keeps_it_off",
            disabled["enabled"] == "disabled" && disabled["active"] == "inactive",
        ),
        must(
            "boot_service_started",
            tracked_s.is_finite() && on["restarts"] == 0 && on["state"] == "running",
        ),
        at_most("boot_to_tracking_s", tracked_s, "s", BOOT_S),
        check(
            "boot_systemd_to_tracking_s",
            tracked_s - number(on, "systemd_s"),
            "s",
            "told",
            on["systemd_s"].is_number(),
        ),
        at_most("boot_start_to_tracking_s", tracked_s - number(on, "started_s"), "s", START_S),
        must("boot_keeps_blob", same_slot(&left["slot"], &on["slot"])),
        must(
            "boot_removed",
            removed["removed"]["exit"] == 0
                && removed["purged"]["exit"] == 0
                && removed["active"] == "inactive"
                && same_slot(&on["slot"], &removed["slot_kept"])
                && removed["left"] == json!([]),
        ),
        must("boot_no_complaint", quiet(left) && quiet(on)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_passes_on_empty_logs() {
        let passed: Vec<String> = of(&Log::default(), &Log::default())
            .into_iter()
            .filter_map(|check| check.4.then_some(check.0))
            .collect();
        assert_eq!(passed, Vec::<String>::new());
    }
}
