//! The program in the middle of a run: started, sent signals, read at its end.

use serde_json::Value;
use std::net::UdpSocket;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// Time limit of the first turn on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// The program as it runs, and the port on which it publishes its turns.
pub(crate) struct Running {
    child: Child,
    turns: UdpSocket,
}

impl Running {
    /// Starts `meniscus run` in `folder` and waits for its first turn.
    pub(crate) fn start(folder: &Path, arguments: &[&str]) -> Self {
        let turns = UdpSocket::bind("127.0.0.1:0").expect("a port");
        turns.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        let to = format!("udp:{}", turns.local_addr().expect("an address"));
        let child = Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
            .args(["run", "--json", "--publish", &to])
            .args(arguments)
            .current_dir(folder)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        let running = Self { child, turns };
        running.turns.recv(&mut [0; 4096]).expect("a first turn");
        running
    }

    /// Sends a signal to the program.
    pub(crate) fn signal(&self, name: &str) {
        let pid = self.child.id().to_string();
        let sent = Command::new("kill").args(["-s", name, &pid]).status();
        assert!(sent.is_ok_and(|status| status.success()), "kill -s {name}");
    }

    /// Returns its report.
    pub(crate) fn report(self) -> Value {
        let output = self.child.wait_with_output().expect("it ends");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{errors}");
        serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {errors}"))
    }
}
