//! The run as a service: messages to systemd and to the journal.
//!
//! systemd's protocol (sd_notify): datagrams of `KEY=VALUE` lines to the socket that NOTIFY_SOCKET names. The unit's
//! watchdog hears from the program only while the worker takes turns: with a camera that has gone
//! it goes on taking them, in the mode halted; a worker that hangs is started anew by systemd.

use super::RunState;
use meniscus::runtime::Mode;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::time::{Duration, Instant};

/// Interval at which the worker is observed.
const LOOK: Duration = Duration::from_millis(100);
/// Interval of the watchdog's messages.
const ALIVE: Duration = Duration::from_secs(1);

/// Socket of systemd; `None` outside of a unit.
struct Notify(Option<(UnixDatagram, SocketAddr)>);

impl Notify {
    /// By NOTIFY_SOCKET: a path, or a name that begins with `@`.
    fn by_environment() -> Self {
        let name = std::env::var("NOTIFY_SOCKET").ok();
        let address = name.and_then(|name| match name.strip_prefix('@') {
            Some(name) => SocketAddr::from_abstract_name(name).ok(),
            None => SocketAddr::from_pathname(name).ok(),
        });
        Self(address.and_then(|address| Some((UnixDatagram::unbound().ok()?, address))))
    }

    fn send(&self, what: &str) {
        if let Some((socket, address)) = &self.0 {
            // A systemd that does not listen changes nothing here; its watchdog will say so.
            let _sent = socket.send_to_addr(what.as_bytes(), address);
        }
    }
}

/// Tells systemd why the program ends, for `systemctl status`; outside of a unit nothing happens.
pub fn tell_failure(line: &str) {
    Notify::by_environment().send(&format!("STATUS={}", line.replace('\n', " ")));
}

/// Reports the run to systemd until it has `finished`; every change of the mode goes to `say`, too.
pub fn attend(state: &RunState, say: &dyn Fn(&str), finished: &dyn Fn() -> bool) {
    let notify = Notify::by_environment();
    notify.send("READY=1\nSTATUS=waiting for the first frame");
    let (mut mode, mut time, mut sent): (Option<Mode>, _, Option<Instant>) = (None, None, None);
    while !finished() {
        let due = sent.is_none_or(|sent| sent.elapsed() >= ALIVE);
        if let Some(logged) = state.latest.get() {
            let now = logged.turn.estimate.mode;
            if mode != Some(now) {
                say(&format!("mode: {now:?}"));
                notify.send(&format!("STATUS={now:?}"));
                mode = Some(now);
            }
            let alive = time != Some(logged.turn.time);
            time = Some(logged.turn.time);
            if alive && due {
                notify.send("WATCHDOG=1");
                sent = Some(Instant::now());
            }
        } else if due {
            // Before the first frame there is no turn: the camera's session has its own patience.
            notify.send("WATCHDOG=1");
            sent = Some(Instant::now());
        }
        std::thread::sleep(LOOK);
    }
    notify.send("STOPPING=1");
}
