//! The first boot: a person installs the package on a board that does not have it, and then things go wrong.

use super::service::{self, SLOTS, UNIT};
use super::system::{self, ProgramOutput, run, up_s, wait};
use super::{Board, Facts, Step};
use serde_json::json;
use std::error::Error;
use std::os::unix::net::UnixDatagram;
use std::time::Duration;

/// The package, and the next version of it.
const PACKAGE: &str = "/hil/meniscus.deb";
const NEXT: &str = "/hil/meniscus-next.deb";
/// A model of the person's own.
const OWN: &str = "/hil/own.blob";
/// The profile of the board, which a person may have edited.
const PROFILE: &str = "/etc/meniscus/board.toml";
/// Where programs of the service's namespace log to.
const LOG: &str = "/run/systemd/journal.meniscus/dev-log";

/// Longest time for the service to track, seconds.
const PATIENCE_S: u64 = 30;

pub(super) const STEPS: &[Step] = &[
    ("before", before),
    ("install", install),
    ("rights", rights),
    ("replug", replug),
    ("kill", kill),
    ("hang", hang),
    ("journal", journal),
    ("upgrade", upgrade),
    ("disabled", disabled),
    ("left", left),
];

/// A word of a step that has to be there.
fn done(said: &ProgramOutput, what: &str) -> Result<(), Box<dyn Error>> {
    match said.exit {
        0 => Ok(()),
        _ => Err(format!("{what}: {}", said.facts()).into()),
    }
}

fn signal(which: &str, pid: &str) -> std::io::Result<ProgramOutput> {
    run(&["busybox", "kill", which, pid])
}

fn main_pid() -> Result<String, Box<dyn Error>> {
    Ok(service::properties()?.remove("MainPID").unwrap_or_default())
}

fn before(_: &mut Board) -> Facts {
    let state = wait(60, || {
        let said = run(&["systemctl", "is-system-running"]).ok()?;
        ["running", "degraded"].contains(&said.out.as_str()).then_some(said.out)
    });
    let failed = run(&["systemctl", "list-units", "--failed", "--plain", "--no-legend"])?.out;
    Ok(json!({ "state": state, "failed": failed, "node": system::node(), "up_s": up_s(),
               "user": run(&["id", "meniscus"])?.exit == 0 }))
}

fn install(_: &mut Board) -> Facts {
    let begun_s = up_s();
    let said = run(&["dpkg", "--install", PACKAGE])?;
    let ended_s = up_s();
    done(&said, "dpkg --install")?;
    let pid = service::tracking("0", PATIENCE_S)?;
    let tracked_s = service::tracked_at(&pid);
    Ok(json!({ "dpkg": said.facts(), "dpkg_s": ended_s - begun_s,
               "to_tracking_s": tracked_s.map(|at_s| at_s - begun_s),
               "enabled": service::properties()?.get("UnitFileState"), "slot": service::slot(),
               "restarts": service::restarts(), "node": system::node() }))
}

fn rights(_: &mut Board) -> Facts {
    let pid = main_pid()?;
    let refused: Vec<String> = service::journal()?
        .into_iter()
        .filter(|line| line.pid == pid && line.text.starts_with("real time:"))
        .map(|line| line.text)
        .collect();
    let watchdog = service::properties()?.get("WatchdogUSec").cloned();
    Ok(json!({ "rights": system::rights(&pid), "refused": refused, "watchdog": watchdog }))
}

/// Waits until udev has given the camera's node away, and looks often: it is a matter of milliseconds.
fn wait_for_node() -> Option<()> {
    (0..500).find_map(|_| {
        std::thread::sleep(Duration::from_millis(10));
        (system::node()["group"] == "plugdev").then_some(())
    })
}

/// The plug is pulled and put in again; the kernel makes another node.
fn replug(board: &mut Board) -> Facts {
    let (pid, restarts) = (main_pid()?, service::restarts());
    board.unplug()?;
    let lost =
        wait(PATIENCE_S, || (service::properties().ok()?.get("StatusText")? != "Tracking").then_some(()));
    board.plug()?;
    let plugged_s = up_s();
    let permitted_s = wait_for_node().map(|()| up_s() - plugged_s);
    let again = service::tracking("0", PATIENCE_S)?;
    let lines: Vec<service::Line> =
        service::journal()?.into_iter().filter(|line| line.pid == pid && line.at_s >= plugged_s).collect();
    let back = lines.iter().rev().find(|line| line.text == "mode: Tracking");
    let words: Vec<String> =
        lines.iter().map(|line| format!("{:.3} {}", line.at_s - plugged_s, line.text)).collect();
    Ok(json!({ "noticed": lost.is_some(), "same_process": again == pid, "node": system::node(),
               "restarted": service::restarts() - restarts, "journal": words, "permitted_s": permitted_s,
               "to_tracking_s": back.map(|line| line.at_s - plugged_s) }))
}

fn kill(_: &mut Board) -> Facts {
    let (pid, restarts, begun_s) = (main_pid()?, service::restarts(), up_s());
    done(&signal("-KILL", &pid)?, "kill")?;
    let next = service::tracking(&pid, PATIENCE_S)?;
    Ok(json!({ "restarts": service::restarts() - restarts,
               "to_tracking_s": service::tracked_at(&next).map(|at_s| at_s - begun_s) }))
}

/// A program that takes no turns any more: it is stopped, and nobody lets it go on.
fn hang(_: &mut Board) -> Facts {
    let (pid, restarts, begun_s) = (main_pid()?, service::restarts(), up_s());
    done(&signal("-STOP", &pid)?, "kill")?;
    let next = service::tracking(&pid, PATIENCE_S)?;
    let about: Vec<service::Line> =
        service::about()?.into_iter().filter(|line| line.at_s >= begun_s - 0.01).collect();
    let watchdog = about.iter().find(|line| line.text.contains("Watchdog timeout"));
    Ok(json!({ "restarts": service::restarts() - restarts,
               "watchdog_s": watchdog.map(|line| line.at_s - begun_s),
               "by_watchdog": about.iter().any(|line| line.text.contains("result 'watchdog'")),
               "to_tracking_s": service::tracked_at(&next).map(|at_s| at_s - begun_s) }))
}

/// More lines than the service's journal may hold; it tracks on meanwhile.
fn journal(_: &mut Board) -> Facts {
    const LINES: u32 = 1_000;
    const LINE: usize = 40_000;
    let pid = main_pid()?;
    let socket = UnixDatagram::unbound()?;
    // Digits without order, by a linear congruential generator (Knuth's constants): they compress to a half at most.
    let mut state = 1_u64;
    let mut digits = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        char::from(b'!' + (state >> 33) as u8 % 90)
    };
    let mut written = 0;
    for _ in 0..LINES {
        let line: String = std::iter::repeat_with(&mut digits).take(LINE).collect();
        written += socket.send_to(format!("<14>fill: {line}").as_bytes(), LOG)?;
    }
    run(&["journalctl", "--namespace=meniscus", "--sync"])?;
    let machine = std::fs::read_to_string("/etc/machine-id")?;
    let folder = format!("/var/log/journal/{}.meniscus", machine.trim());
    let (mut kept, mut files) = (0, 0);
    for file in std::fs::read_dir(&folder)?.flatten() {
        kept += file.metadata()?.len();
        files += 1;
    }
    Ok(json!({ "written_bytes": written, "kept_bytes": kept, "files": files,
               "tracks_on": service::tracking("0", PATIENCE_S)? == pid }))
}

/// A person flashes a model, edits the profile, and installs the next version.
fn upgrade(_: &mut Board) -> Facts {
    done(&run(&["meniscus", "flash", OWN, "--to", SLOTS])?, "flash")?;
    done(&run(&["systemctl", "restart", UNIT])?, "restart")?;
    let first = service::tracking("0", PATIENCE_S)?;
    let profile = format!("{}# This board stands in the window.\n", std::fs::read_to_string(PROFILE)?);
    std::fs::write(PROFILE, &profile)?;
    let slot = service::slot();
    let before = run(&["dpkg-query", "--show", "--showformat=${Version}", "meniscus"])?.out;
    done(&run(&["dpkg", "--install", NEXT])?, "dpkg --install")?;
    let second = service::tracking(&first, PATIENCE_S)?;
    let program = std::fs::read_link(format!("/proc/{second}/exe"))?;
    Ok(json!({ "before": before,
               "behind": run(&["dpkg-query", "--show", "--showformat=${Version}", "meniscus"])?.out,
               "program": program, "slot_before": slot, "slot": service::slot(),
               "profile_kept": std::fs::read_to_string(PROFILE)? == profile,
               "enabled": service::properties()?.get("UnitFileState") }))
}

/// A service that was switched off stays off through an upgrade: the package's script behind the new files.
fn disabled(_: &mut Board) -> Facts {
    const POSTINST: &str = "/var/lib/dpkg/info/meniscus.postinst";
    done(&run(&["systemctl", "disable", "--now", UNIT])?, "disable")?;
    done(&run(&["env", "DPKG_MAINTSCRIPT_PACKAGE=meniscus", POSTINST, "configure", "0.0.1"])?, "postinst")?;
    let now = service::properties()?;
    let (enabled, active) = (now.get("UnitFileState").cloned(), now.get("ActiveState").cloned());
    done(&run(&["systemctl", "enable", "--now", UNIT])?, "enable")?;
    service::tracking("0", PATIENCE_S)?;
    Ok(json!({ "enabled": enabled, "active": active }))
}

/// State of the board at the end, for comparison with the next boot.
fn left(_: &mut Board) -> Facts {
    let failed = run(&["systemctl", "list-units", "--failed", "--plain", "--no-legend"])?.out;
    Ok(
        json!({ "slot": service::slot(), "failed": failed, "kernel_complaints": super::super::kernel::complaints(),
               "up_s": up_s() }),
    )
}
