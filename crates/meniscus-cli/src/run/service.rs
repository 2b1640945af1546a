//! The run as a service: what systemd is told, and what the journal.
//!
//! systemd's protocol (sd_notify): datagrams of `KEY=VALUE` lines to the socket that NOTIFY_SOCKET names. The unit's
//! watchdog is told that the program is alive only while the worker takes turns: with a camera that has gone
//! it goes on taking them, in the mode halted; a worker that hangs is started anew by systemd.

use meniscus::runtime::Mode;
use meniscus_service::live::Watch;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::time::{Duration, Instant};

/// Pause between two looks at the worker.
const LOOK: Duration = Duration::from_millis(100);
/// Pause between two signs of life.
const ALIVE: Duration = Duration::from_secs(1);

/// The way to systemd; none outside of a unit.
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

    fn tell(&self, what: &str) {
        if let Some((socket, address)) = &self.0 {
            // A systemd that does not listen changes nothing here; its watchdog will say so.
            let _told = socket.send_to_addr(what.as_bytes(), address);
        }
    }
}

/// Attends the run until it has finished.
pub(super) fn attend(watch: &Watch, finished: impl Fn() -> bool) {
    let notify = Notify::by_environment();
    notify.tell("READY=1\nSTATUS=waiting for the first frame");
    let (mut mode, mut time, mut told): (Option<Mode>, _, Option<Instant>) = (None, None, None);
    while !finished() {
        let last = watch.last.lock().ok().and_then(|last| *last);
        if let Some(logged) = last {
            let now = logged.turn.estimate.mode;
            if mode != Some(now) {
                eprintln!("mode: {now:?}");
                notify.tell(&format!("STATUS={now:?}"));
                mode = Some(now);
            }
            let alive = time != Some(logged.turn.time);
            time = Some(logged.turn.time);
            if alive && told.is_none_or(|told| told.elapsed() >= ALIVE) {
                notify.tell("WATCHDOG=1");
                told = Some(Instant::now());
            }
        } else if told.is_none_or(|told| told.elapsed() >= ALIVE) {
            // Before the first frame there is no turn: the camera's session has its own patience.
            notify.tell("WATCHDOG=1");
            told = Some(Instant::now());
        }
        std::thread::sleep(LOOK);
    }
    notify.tell("STOPPING=1");
}
