//! The edge board's verdict on the steps of its two boots.

mod facts;

use super::Failure;
use super::checks::{self, Check, at_most, check, informational, must};
use super::log::Log;
use facts::{
    Before, Disabled, Install, Journal, Node, PowerOn, Remove, Replug, Rest, Restart, Rights, Upgrade, is,
    or_nan, step,
};
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
/// Limit of the service's journal, bytes, and the bytes that have to be written to reach it.
const JOURNAL_BYTES: f64 = 32.0 * 1048576.0;
const WRITTEN_BYTES: f64 = 36.0 * 1048576.0;

/// Judges the boot in which the package was installed and the one behind it. `true` when every check is met.
pub(crate) fn judge(logs: [&Path; 2], json: bool, wall_s: f64) -> Result<bool, Failure> {
    let [install, power_on] = [Log::read(logs[0])?, Log::read(logs[1])?];
    let mut checks = of(&install, &power_on)?;
    let passed = checks.iter().all(Check::passed);
    checks.push(informational("wall_s", wall_s, "s"));
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

/// Facts of both boots.
#[derive(Clone, Debug, Default)]
struct Boots {
    before: Before,
    install: Install,
    rights: Rights,
    replug: Replug,
    kill: Restart,
    hang: Restart,
    journal: Journal,
    upgrade: Upgrade,
    disabled: Disabled,
    left: Rest,
    power_on: PowerOn,
    remove: Remove,
}

fn of(install: &Log, power_on: &Log) -> Result<Vec<Check>, Failure> {
    let boots = Boots {
        before: step(install, "before")?,
        install: step(install, "install")?,
        rights: step(install, "rights")?,
        replug: step(install, "replug")?,
        kill: step(install, "kill")?,
        hang: step(install, "hang")?,
        journal: step(install, "journal")?,
        upgrade: step(install, "upgrade")?,
        disabled: step(install, "disabled")?,
        left: step(install, "left")?,
        power_on: step(power_on, "power-on")?,
        remove: step(power_on, "remove")?,
    };
    let parts = [installed(&boots), rights(&boots), troubles(&boots), upgraded(&boots), second_boot(&boots)];
    Ok(parts.into_iter().flatten().collect())
}

/// Checks of the first start behind the installation.
fn installed(boots: &Boots) -> Vec<Check> {
    let Boots { before, install, replug, power_on, .. } = boots;
    let by_the_rule = |node: &Option<Node>| node.as_ref().is_some_and(Node::by_the_rule);
    vec![
        must(
            "boot_installed",
            install.dpkg.well()
                && before.user == Some(false)
                && is(&install.enabled, "enabled")
                && install.restarts == Some(0),
        ),
        informational("boot_install_to_tracking_s", or_nan(install.to_tracking_s), "s"),
        // Without the rule the node is root's alone: it is the rule that made it so.
        must(
            "boot_udev_rule_applied",
            before.node.as_ref().is_some_and(|node| !node.by_the_rule())
                && [&install.node, &replug.node, &power_on.node].into_iter().all(by_the_rule),
        ),
    ]
}

/// Checks of the rights of the service's process.
fn rights(boots: &Boots) -> Vec<Check> {
    let Rights { rights, refused, watchdog } = &boots.rights;
    let priorities = &rights.fifo_priorities;
    vec![
        must(
            "boot_realtime_granted",
            priorities.len() >= 2
                && priorities.iter().all(|priority| *priority == 40)
                && refused.as_ref().is_some_and(Vec::is_empty)
                && rights.locked_kib.is_some_and(|kib| kib > 0),
        ),
        must(
            "boot_unprivileged",
            is(&rights.user, "meniscus")
                && is(&rights.group, "plugdev")
                && is(&rights.capabilities, "0000000000000000")
                && is(&rights.no_new_privileges, "1"),
        ),
        must("boot_watchdog_armed", is(watchdog, "5s")),
    ]
}

/// Checks of a re-plug, a kill, a hang and a full journal.
fn troubles(boots: &Boots) -> Vec<Check> {
    let Boots { replug, kill, hang, journal, .. } = boots;
    let (kept, written) = (or_nan(journal.kept_bytes), or_nan(journal.written_bytes));
    vec![
        must(
            "boot_replug_survived",
            replug.noticed == Some(true) && replug.same_process == Some(true) && replug.restarted == Some(0),
        ),
        at_most("boot_replug_to_tracking_s", or_nan(replug.to_tracking_s), "s", REPLUG_S),
        must("boot_restarted_after_kill", kill.restarts == Some(1)),
        at_most("boot_kill_to_tracking_s", or_nan(kill.to_tracking_s), "s", KILL_S),
        must("boot_restarted_after_watchdog", hang.restarts == Some(1) && hang.by_watchdog == Some(true)),
        at_most("boot_hang_to_tracking_s", or_nan(hang.to_tracking_s), "s", HANG_S),
        check(
            "boot_journal_mib",
            kept / 1048576.0,
            "MiB",
            "<= 32, tracking on",
            written >= WRITTEN_BYTES
                && kept <= JOURNAL_BYTES
                && kept > 0.0
                && journal.tracks_on == Some(true),
        ),
    ]
}

/// Checks of an upgrade: the person's model, profile and switch stay as they are.
fn upgraded(boots: &Boots) -> Vec<Check> {
    let Boots { install, upgrade, disabled, .. } = boots;
    vec![
        must(
            "boot_upgraded",
            upgrade.before != upgrade.behind
                && upgrade.behind.is_some()
                && is(&upgrade.program, "/usr/bin/meniscus")
                && is(&upgrade.enabled, "enabled"),
        ),
        // The person's model, not the shipped one that the first installation wrote.
        must(
            "boot_upgrade_keeps_blob",
            upgrade.slot_before.same_as(&upgrade.slot) && upgrade.slot.sha256 != install.slot.sha256,
        ),
        must("boot_upgrade_keeps_profile", upgrade.profile_kept == Some(true)),
        must(
            "boot_upgrade_keeps_it_off",
            is(&disabled.enabled, "disabled") && is(&disabled.active, "inactive"),
        ),
    ]
}

/// Checks of the boot behind a power cycle, and of the removal at its end.
fn second_boot(boots: &Boots) -> Vec<Check> {
    let Boots { left, power_on, remove, .. } = boots;
    let tracked_s = or_nan(power_on.tracked_s);
    vec![
        must(
            "boot_service_started",
            tracked_s.is_finite() && power_on.restarts == Some(0) && is(&power_on.state, "running"),
        ),
        at_most("boot_to_tracking_s", tracked_s, "s", BOOT_S),
        informational("boot_systemd_to_tracking_s", tracked_s - or_nan(power_on.systemd_s), "s"),
        at_most("boot_start_to_tracking_s", tracked_s - or_nan(power_on.started_s), "s", START_S),
        must("boot_keeps_blob", left.slot.same_as(&power_on.rest.slot)),
        must(
            "boot_removed",
            remove.removed.well()
                && remove.purged.well()
                && is(&remove.active, "inactive")
                && power_on.rest.slot.same_as(&remove.slot_kept)
                && remove.left.as_ref().is_some_and(Vec::is_empty),
        ),
        must("boot_no_complaint", left.quiet() && power_on.rest.quiet()),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passed(install: &Log, power_on: &Log) -> Vec<String> {
        let checks = of(install, power_on).expect("facts of the stated types");
        checks.into_iter().filter_map(|check| check.passed().then_some(check.name)).collect()
    }

    fn log(facts: &[(&str, Value)]) -> Log {
        let facts = facts.iter().map(|(step, facts)| (String::from(*step), facts.clone())).collect();
        Log { facts, ..Log::default() }
    }

    fn slot(digit: &str) -> Value {
        json!({ "active": "A", "sha256": digit.repeat(64) })
    }

    /// Facts of two boots in which everything went well, in the guest's form.
    fn good() -> [Log; 2] {
        let node = json!({ "owner": "root", "group": "plugdev", "mode": "0660" });
        let install = log(&[
            (
                "before",
                json!({ "user": false, "failed": "", "up_s": 3.5,
                "node": { "owner": "root", "group": "root", "mode": "0664" } }),
            ),
            (
                "install",
                json!({ "dpkg": { "exit": 0 }, "enabled": "enabled", "restarts": 0,
                "to_tracking_s": 3.0, "node": node, "slot": slot("1") }),
            ),
            (
                "rights",
                json!({ "refused": [], "watchdog": "5s", "rights": { "user": "meniscus",
                "group": "plugdev", "capabilities": "0000000000000000", "no_new_privileges": "1",
                "locked_kib": 9000, "resident_kib": 9000, "fifo_priorities": [40, 40] } }),
            ),
            (
                "replug",
                json!({ "noticed": true, "same_process": true, "restarted": 0, "node": node,
                "to_tracking_s": 1.0 }),
            ),
            ("kill", json!({ "restarts": 1, "to_tracking_s": 2.0 })),
            ("hang", json!({ "restarts": 1, "by_watchdog": true, "watchdog_s": 5.0, "to_tracking_s": 8.0 })),
            ("journal", json!({ "written_bytes": 40_000_000, "kept_bytes": 30_000_000, "tracks_on": true })),
            (
                "upgrade",
                json!({ "before": "0.1.0", "behind": "0.1.1", "program": "/usr/bin/meniscus",
                "enabled": "enabled", "slot_before": slot("2"), "slot": slot("2"), "profile_kept": true }),
            ),
            ("disabled", json!({ "enabled": "disabled", "active": "inactive" })),
            ("left", json!({ "slot": slot("2"), "failed": "", "kernel_complaints": [] })),
        ]);
        let power_on = log(&[
            (
                "power-on",
                json!({ "tracked_s": 12.0, "systemd_s": 3.0, "started_s": 11.0, "restarts": 0,
                "state": "running", "node": node, "slot": slot("2"), "failed": "", "kernel_complaints": [] }),
            ),
            (
                "remove",
                json!({ "removed": { "exit": 0 }, "purged": { "exit": 0 }, "active": "inactive",
                "slot_kept": slot("2"), "left": [] }),
            ),
        ]);
        [install, power_on]
    }

    #[test]
    fn nothing_passes_on_empty_logs() {
        assert_eq!(passed(&Log::default(), &Log::default()), Vec::<String>::new());
    }

    #[test]
    fn everything_passes_on_good_facts() {
        let [install, power_on] = good();
        assert_eq!(passed(&install, &power_on).len(), of(&install, &power_on).expect("facts").len());
    }

    /// A fact that is wrong fails the checks named beside it, and no others.
    #[test]
    fn a_wrong_fact_fails_its_checks() {
        let cases: [(&str, &str, Value, &[&str]); 8] = [
            ("before", "/user", json!(true), &["boot_installed"]),
            ("rights", "/rights/fifo_priorities", json!([40]), &["boot_realtime_granted"]),
            ("rights", "/rights/user", json!("root"), &["boot_unprivileged"]),
            ("replug", "/node/group", json!("root"), &["boot_udev_rule_applied"]),
            ("hang", "/by_watchdog", json!(false), &["boot_restarted_after_watchdog"]),
            ("journal", "/kept_bytes", json!(40_000_000), &["boot_journal_mib"]),
            ("upgrade", "/slot", slot("1"), &["boot_upgrade_keeps_blob"]),
            ("left", "/kernel_complaints", json!(["BUG"]), &["boot_no_complaint"]),
        ];
        for (step, path, value, wanted) in cases {
            let [mut install, power_on] = good();
            let facts = install.facts.iter_mut().find(|facts| facts.0 == step).expect("a step");
            *facts.1.pointer_mut(path).expect("a fact") = value;
            let checks = of(&install, &power_on).expect("facts of the stated types");
            let missed: Vec<&str> = checks.iter().filter(|c| !c.passed()).map(|c| c.name.as_str()).collect();
            assert_eq!(missed, wanted, "{step}{path}");
        }
    }

    #[test]
    fn a_step_that_ended_with_an_error_passes_nothing_and_a_fact_of_another_type_is_named() {
        let [mut install, power_on] = good();
        install.facts[4].1 = json!({ "error": "no tracking within 30 s" });
        let missed = of(&install, &power_on).expect("facts").into_iter().filter(|check| !check.passed());
        let missed: Vec<String> = missed.map(|check| check.name).collect();
        assert_eq!(missed, ["boot_restarted_after_kill", "boot_kill_to_tracking_s"]);
        install.facts[4].1 = json!({ "restarts": "one" });
        let error = of(&install, &power_on).expect_err("no number").to_string();
        assert!(error.contains("`kill`"), "{error}");
    }
}
