//! The board's own programs, and what the kernel shows of a process and of the camera's node.

use serde_json::{Value, json};
use std::collections::HashMap;
use std::fs;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Pause between two looks.
const LOOK: Duration = Duration::from_millis(200);

/// Exit status and output of a program.
pub(super) struct ProgramOutput {
    /// Exit status; -1 for a signal.
    pub(super) exit: i32,
    /// Standard output.
    pub(super) out: String,
    /// Standard error.
    pub(super) err: String,
}

impl ProgramOutput {
    /// For the facts: the status, and the last words when it is not 0.
    pub(super) fn facts(&self) -> Value {
        let last = |text: &str| text.lines().rev().take(4).collect::<Vec<_>>().join(" | ");
        match self.exit {
            0 => json!({ "exit": 0 }),
            exit => json!({ "exit": exit, "stderr": last(&self.err), "stdout": last(&self.out) }),
        }
    }
}

/// Runs a program as root at the board's prompt.
pub(super) fn run(words: &[&str]) -> io::Result<ProgramOutput> {
    let (program, arguments) = words.split_first().ok_or(io::ErrorKind::InvalidInput)?;
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::null()).env("PATH", "/usr/sbin:/usr/bin").env("LC_ALL", "C");
    let done = command.env("DEBIAN_FRONTEND", "noninteractive").output()?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
    Ok(ProgramOutput {
        exit: done.status.code().unwrap_or(-1),
        out: text(&done.stdout),
        err: text(&done.stderr),
    })
}

/// `KEY=VALUE` lines of `systemctl show`.
pub(super) fn show(words: &[&str]) -> io::Result<HashMap<String, String>> {
    let said = run(&[&["systemctl", "show"], words].concat())?;
    let pairs = said.out.lines().filter_map(|line| line.split_once('='));
    Ok(pairs.map(|(key, value)| (key.to_owned(), value.to_owned())).collect())
}

/// Looks until there is something, for at most `seconds`.
pub(super) fn wait<T>(seconds: u64, mut look: impl FnMut() -> Option<T>) -> Option<T> {
    let begun = Instant::now();
    loop {
        let found = look();
        if found.is_some() || begun.elapsed() > Duration::from_secs(seconds) {
            return found;
        }
        sleep(LOOK);
    }
}

/// Time since the kernel's first moment, seconds.
pub(super) fn up_s() -> f64 {
    let text = fs::read_to_string("/proc/uptime").unwrap_or_default();
    text.split(' ').next().and_then(|word| word.parse().ok()).unwrap_or(f64::NAN)
}

/// Owner, group and mode of the camera's node.
pub(super) fn node() -> Value {
    let devices = fs::read_dir("/sys/bus/usb/devices").into_iter().flatten().flatten();
    let text = |path: std::path::PathBuf| fs::read_to_string(path).unwrap_or_default().trim().to_owned();
    for device in devices {
        if text(device.path().join("idVendor")) != "8086" {
            continue;
        }
        let number = |key| text(device.path().join(key)).parse().unwrap_or(0_u16);
        let path = format!("/dev/bus/usb/{:03}/{:03}", number("busnum"), number("devnum"));
        let Ok(meta) = fs::metadata(&path) else { return json!({ "path": path, "missing": true }) };
        return json!({ "owner": name("/etc/passwd", meta.uid()), "group": name("/etc/group", meta.gid()),
                       "mode": format!("{:04o}", meta.mode() & 0o7777) });
    }
    Value::Null
}

/// The name that has this number in a file like /etc/passwd.
pub(super) fn name(file: &str, number: u32) -> String {
    let text = fs::read_to_string(file).unwrap_or_default();
    let found = text.lines().find_map(|line| {
        let mut words = line.split(':');
        let name = words.next()?;
        (words.nth(1)?.parse() == Ok(number)).then(|| name.to_owned())
    });
    found.unwrap_or_else(|| number.to_string())
}

/// Rights of a process: its user, and of its threads how many run under SCHED_FIFO and at which priority.
pub(super) fn rights(pid: &str) -> Value {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    let line = |key: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(key));
        line.unwrap_or_default().trim().to_owned()
    };
    let id = |key: &str| line(key).split_whitespace().nth(1).and_then(|id| id.parse().ok()).unwrap_or(0_u32);
    let threads = fs::read_dir(format!("/proc/{pid}/task")).into_iter().flatten().flatten();
    let priorities: Vec<u32> = threads
        .filter_map(|thread| fifo(&fs::read_to_string(thread.path().join("stat")).unwrap_or_default()))
        .collect();
    json!({ "user": name("/etc/passwd", id("Uid:")), "group": name("/etc/group", id("Gid:")),
            "no_new_privileges": line("NoNewPrivs:"), "capabilities": line("CapEff:"),
            "locked_kib": line("VmLck:").split(' ').next().and_then(|kib| kib.parse::<u64>().ok()),
            "resident_kib": line("VmRSS:").split(' ').next().and_then(|kib| kib.parse::<u64>().ok()),
            "fifo_priorities": priorities })
}

/// Real-time priority of a thread under SCHED_FIFO, from its line in `stat`. Fields are counted from 1, the name in
/// brackets is the second; 40 is the real-time priority, 41 the policy (proc(5)).
fn fifo(stat: &str) -> Option<u32> {
    let fields: Vec<&str> = stat.rsplit_once(") ")?.1.split_whitespace().collect();
    let field = |number: usize| fields.get(number - 3)?.parse::<u32>().ok();
    (field(41)? == 1).then(|| field(40))?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_under_fifo_is_known_by_its_policy() {
        let line = |priority: u32, policy: u32| {
            let before: Vec<String> = (4..40).map(|field| field.to_string()).collect();
            format!("77 (a (worse) name) S {} {priority} {policy} 0", before.join(" "))
        };
        assert_eq!(fifo(&line(40, 1)), Some(40));
        assert_eq!(fifo(&line(40, 2)), None, "round robin");
        assert_eq!(fifo(&line(0, 0)), None);
        assert_eq!(fifo("77 (cut) S 1"), None);
    }

    #[test]
    fn a_number_without_a_name_is_shown_as_it_is() {
        assert_eq!(name("/etc/passwd", 0), "root");
        assert_eq!(name("/etc/passwd", 4_000_000_000), "4000000000");
    }
}
