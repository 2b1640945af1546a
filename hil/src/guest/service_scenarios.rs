//! Scenarios of the machine around the camera: the service, a flash while it streams, and scarce memory, disk and
//! processor.

use super::facts;
use super::program::{self, PROGRAM};
use meniscus_hil::vhci::Plugged;
use serde_json::{Map, Value, json};
use std::error::Error;
use std::os::unix::net::UnixDatagram;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

type Done = Result<Map<String, Value>, Box<dyn Error>>;

/// Where systemd would listen.
const NOTIFY: &str = "/tmp/notify";
/// The two slots.
const SLOTS: &str = "/tmp/slots";
/// Memory for USB transfers, MiB; 0 is no limit.
const USBFS_MB: &str = "/sys/module/usbcore/parameters/usbfs_memory_mb";

/// The program as a service under a systemd that only listens: its notifications, with their times.
pub(crate) fn service(seconds: f64) -> Done {
    let _old = std::fs::remove_file(NOTIFY);
    let socket = UnixDatagram::bind(NOTIFY)?;
    socket.set_read_timeout(Some(Duration::from_millis(100)))?;
    let begun = Instant::now();
    let mut command = Command::new(PROGRAM);
    command.args(["run", "--source", "usb", "--service", "--json", "--out", program::OUT]);
    command.env("NOTIFY_SOCKET", NOTIFY).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = command.spawn()?;
    let (mut ready_s, mut tracking_s, mut signs, mut longest_s) = (None, None, 0, 0.0_f64);
    let (mut last, mut bytes) = (begun, [0; 256]);
    while begun.elapsed().as_secs_f64() < seconds {
        let Ok(length) = socket.recv(&mut bytes) else { continue };
        let (text, now_s) =
            (String::from_utf8_lossy(&bytes[..length]).into_owned(), begun.elapsed().as_secs_f64());
        if text.contains("READY=1") {
            ready_s.get_or_insert(now_s);
        }
        if text.contains("STATUS=Tracking") {
            tracking_s.get_or_insert(now_s);
        }
        if text.contains("WATCHDOG=1") {
            signs += 1;
            longest_s = longest_s.max(last.elapsed().as_secs_f64());
            last = Instant::now();
        }
    }
    // SIGTERM, as systemd stops a unit.
    Command::new("/bin/busybox").args(["kill", &child.id().to_string()]).status()?;
    let ran = program::finish(child)?;
    let mut facts = facts::of(&ran);
    let notified = json!({ "ready_s": ready_s, "tracking_s": tracking_s, "signs_of_life": signs,
                           "longest_silence_s": longest_s });
    facts.insert("notified".into(), notified);
    Ok(facts)
}

/// The model is flashed while the camera streams, and started from its slot afterwards.
pub(crate) fn flash(plugged: &Plugged, seconds: f64) -> Done {
    let _old = std::fs::remove_dir_all(SLOTS);
    let mut child = program::start(&program::arguments(seconds, &[]))?;
    std::thread::sleep(Duration::from_secs_f64(0.5 * seconds));
    let flashed = program::run(&["flash", "shipped", "--to", SLOTS, "--json"].map(str::to_owned))?;
    let again = program::run(&["flash", "shipped", "--to", SLOTS, "--json"].map(str::to_owned))?;
    let streamed_on = child.try_wait()?.is_none();
    let ran = program::finish(child)?;
    let mut facts = facts::with_turns(&ran, &plugged.witness());
    facts.insert("streamed_on".into(), streamed_on.into());
    facts.insert("slots".into(), json!([flashed.report["slot"], again.report["slot"]]));
    facts.insert("flashed".into(), json!([flashed.exit, again.exit]));
    // The active slot is damaged: the other one has to start, and that has to be said.
    let active = std::fs::read_to_string(format!("{SLOTS}/active"))?;
    std::fs::write(format!("{SLOTS}/slot-{}.blob", active.trim()), b"torn")?;
    let mut arguments = program::arguments(2.0, &[]);
    arguments.extend(["--model", SLOTS].map(str::to_owned));
    let started = program::run(&arguments)?;
    facts.insert("started_from_the_other_slot".into(), (started.exit == 0).into());
    facts.insert("fell_back".into(), started.words.contains("slot A is used").into());
    Ok(facts)
}

/// A disk of 1 MiB that a recording does not fit on.
pub(crate) fn full_disk(seconds: f64) -> Done {
    let busybox = |arguments: &[&str]| Command::new("/bin/busybox").args(arguments).status();
    busybox(&["mkdir", "-p", "/tmp/small"])?;
    busybox(&["mount", "-t", "tmpfs", "-o", "size=1m", "small", "/tmp/small"])?;
    let seconds = seconds.to_string();
    let arguments =
        ["record", "--source", "usb", "--seconds", &seconds, "--out", "/tmp/small/x.mcap"].map(str::to_owned);
    let ran = program::run(&arguments);
    busybox(&["umount", "/tmp/small"])?;
    Ok(facts::of(&ran?))
}

/// Less memory for USB transfers than two streams need.
pub(crate) fn low_memory(seconds: f64) -> Done {
    let before = std::fs::read_to_string(USBFS_MB)?;
    std::fs::write(USBFS_MB, "2")?;
    let ran = program::run(&program::arguments(seconds, &[]));
    std::fs::write(USBFS_MB, before.trim())?;
    Ok(facts::of(&ran?))
}

/// Ends a child, whatever happens.
struct Spinning(Child);

impl Drop for Spinning {
    fn drop(&mut self) {
        let _gone = self.0.kill();
        let _waited = self.0.wait();
    }
}

/// A program of the same priority that never rests, beside the run on the only processor.
pub(crate) fn busy(plugged: &Plugged, seconds: f64) -> Done {
    let mut spin = Command::new("/bin/busybox");
    spin.args(["sh", "-c", "while :; do :; done"]);
    let _spinning = Spinning(spin.spawn()?);
    let ran = program::run(&program::arguments(seconds, &[]))?;
    Ok(facts::with_turns(&ran, &plugged.witness()))
}
