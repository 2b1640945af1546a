//! The rig with QEMU's host controller: QEMU as a child, the camera behind its usb-redir, and the verdict.
//!
//! The guest says on its console when a camera is to be plugged in and taken out; what the camera's side has met goes
//! into the same log. Time is the machine's own: nothing of it is asserted.

use super::Failure;
use super::checks::{self, Check, informational, must};
use super::judge::{at, number};
use super::log::Log;
use super::watch::started;
use meniscus_hil::FaultList;
use meniscus_hil::device::{Device, Film, Trouble};
use meniscus_hil::usbredir::{self, Counts, Redirected, Request};
use serde_json::{Value, json};
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// Words of the guest before the name of a plan, and at its end.
const PLUG: &str = "HIL-PLUG ";
const UNPLUG: &str = "HIL-UNPLUG";

/// The plans: `NAME[:TROUBLE[:SECONDS]]`, as in the gate. Seconds are frames of the camera, however long they take.
pub(crate) const PLANS: [&str; 5] =
    ["run::4", "run:transfer-stall:6", "run:quiet-halt:6", "run:quiet-reset:14", "run:unplug:10"];

enum Input {
    Link(UnixStream),
    Asked(Request),
    Said(String),
    Over,
}

/// Runs `command` with the camera behind the socket, for at most `seconds`. `false` when it ended badly.
pub(crate) fn run(
    log: &str,
    seconds: &str,
    socket: &str,
    film: &str,
    command: &[&str],
) -> Result<bool, Failure> {
    let limit = Duration::from_secs(seconds.parse().map_err(|_| format!("{seconds}: no number of seconds"))?);
    let (begun, mut kept) = (Instant::now(), File::create(log)?);
    let _old = std::fs::remove_file(socket);
    let listener = UnixListener::bind(socket).map_err(|error| format!("{socket}: {error}"))?;
    let (mut child, output) = started(command)?;
    let (to, inputs) = channel();
    let asked = to.clone();
    // Ends with the program: nobody waits for these two.
    std::thread::spawn(move || listen(&listener, &asked));
    std::thread::spawn(move || {
        for line in BufReader::new(output).split(b'\n').map_while(Result::ok) {
            let text = String::from_utf8_lossy(&line).trim_end_matches('\r').to_owned();
            if to.send(Input::Said(text)).is_err() {
                return;
            }
        }
        let _gone = to.send(Input::Over);
    });
    let (mut port, mut plan): (Option<Redirected>, _) = (None, String::new());
    let in_time = loop {
        if begun.elapsed() > limit {
            eprintln!("the guest did not end within {seconds} s; its log is {log}");
            child.kill()?;
            break false;
        }
        let wait = port.as_ref().map_or(Duration::from_millis(100), Redirected::wait);
        match inputs.recv_timeout(wait) {
            Ok(Input::Link(link)) => port = Some(Redirected::new(link)?),
            Ok(Input::Asked(request)) => {
                if let Some(port) = &mut port {
                    port.take(request)?;
                }
            }
            Ok(Input::Said(line)) => {
                writeln!(kept, "{line}")?;
                if let (Some(named), Some(port)) =
                    (line.find(PLUG).map(|at| &line[at + PLUG.len()..]), &mut port)
                {
                    plan = named.trim().to_owned();
                    port.plug(camera(&plan, film)?);
                } else if let (true, Some(port)) = (line.contains(UNPLUG), &mut port) {
                    let facts = counts_json(port.unplug()?);
                    writeln!(kept, "HIL {}", json!({ "scenario": format!("{plan} bus"), "facts": facts }))?;
                }
            }
            Ok(Input::Over) => break true,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break true,
        }
        if let Some(port) = &mut port {
            port.pump()?;
        }
    };
    let _gone = std::fs::remove_file(socket);
    Ok(child.wait()?.success() && in_time)
}

/// QEMU's end of the socket, and what comes over it.
fn listen(listener: &UnixListener, to: &Sender<Input>) {
    let Ok((mut link, _)) = listener.accept() else { return };
    let Ok(own) = link.try_clone() else { return };
    if to.send(Input::Link(own)).is_err() {
        return;
    }
    while let Ok(request) = usbredir::read(&mut link) {
        if to.send(Input::Asked(request)).is_err() {
            return;
        }
    }
}

fn camera(plan: &str, film: &str) -> Result<Device, Failure> {
    let trouble = match plan.split(':').nth(1).unwrap_or_default() {
        "" => None,
        name => Some(Trouble::find(name).ok_or_else(|| format!("no trouble is called `{name}`"))?),
    };
    let film = Film::open(Path::new(film)).map_err(|error| format!("{film}: {error}"))?;
    Ok(Device::new(Box::new(film), trouble, FaultList::default(), 1))
}

fn counts_json(counts: Counts) -> Value {
    json!({ "connected": counts.connected, "configured": counts.configured, "resets": counts.resets,
            "cancelled": counts.cancelled, "cancelled_late": counts.cancelled_late,
            "halts_cleared": counts.halts_cleared, "stalls_cleared": counts.stalls_cleared, "stalled": counts.stalled, "filled": counts.filled,
            "unread": counts.unread })
}

/// Judges a log. `true` when every check is met.
pub(crate) fn judge(log: &Path, json: bool, wall_s: f64) -> Result<bool, Failure> {
    let log = Log::read(log)?;
    let mut checks = of(&log);
    let passed = checks.iter().all(Check::passed);
    checks.push(informational("wall_s", wall_s, "s"));
    if json {
        let facts: Vec<Value> =
            log.facts.iter().map(|(plan, facts)| json!({ "scenario": plan, "facts": facts })).collect();
        let report =
            json!({ "command": "hil/run xhci", "scenarios": facts, "checks": checks::json(&checks) });
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        checks::print(&checks);
    }
    Ok(passed)
}

fn of(log: &Log) -> Vec<Check> {
    let nothing = Value::Null;
    let program = |plan: &str| log.of(plan).unwrap_or(&nothing);
    let bus = |plan: &str| log.of(&format!("{plan} bus")).unwrap_or(&nothing);
    let [plain, stall, cancel, reset, unplug] = PLANS;
    // Ended well, frames came as turns, and the kernel's driver had nothing to complain about. Whether a guest that is
    // this slow tracks is a matter of time.
    let fine = |plan: &str| {
        let facts = program(plan);
        facts["exit"] == 0 && number(facts, "health.turns") > 0.0 && facts["kernel_complaints"] == json!([])
    };
    // Frames came again behind the trouble; that a slow guest is late once more is no matter.
    let back = |plan: &str| {
        let notes = program(plan)["camera_notes"].as_array();
        notes.is_some_and(|notes| notes.iter().any(|note| note == "the camera is back"))
    };
    let counted = |facts: &Value, path: &str| number(facts, path) >= 1.0;
    let speed = |plan: &str| at(program(plan), "enumerated.speed_mbit") == "5000";
    vec![
        must("xhci_enumerated", speed(plain) && counted(bus(plain), "configured")),
        must("xhci_streams", fine(plain) && number(bus(plain), "filled") > 100.0),
        must(
            "xhci_stall_cleared",
            fine(stall)
                && back(stall)
                && counted(bus(stall), "stalls_cleared")
                && counted(program(stall), "camera_health.stalls"),
        ),
        must("xhci_transfers_cancelled", fine(cancel) && back(cancel) && counted(bus(cancel), "cancelled")),
        // The kernel configures a device again that it has reset.
        must(
            "xhci_reset",
            fine(reset)
                && back(reset)
                && at(program(reset), "camera_health.rungs")[3] != 0
                && number(bus(reset), "configured") > number(bus(reset), "connected"),
        ),
        must("xhci_replugged", fine(unplug) && back(unplug) && number(bus(unplug), "connected") == 2.0),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_passes_on_an_empty_log() {
        assert!(of(&Log::default()).iter().all(|check| !check.passed()));
    }
}
