//! The program with its node.

use serde_json::Value;
use std::fs::File;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Time limit of the start and of the end on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// A run of the simulated camera in real time.
pub(crate) struct Run {
    child: Child,
    folder: PathBuf,
}

/// A run that has ended.
pub(crate) struct Ended {
    /// Standard error.
    pub(crate) said: String,
    /// Its turns: time of the end, us since 1970, and length, us.
    pub(crate) turns: Vec<(u64, u64)>,
}

/// Returns now, us since 1970.
pub(crate) fn now_us() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).expect("after 1970").as_micros() as u64
}

impl Run {
    /// Starts a run that lasts for five minutes, unless it is ended, and waits for its socket.
    pub(crate) fn start(name: &str, arguments: &[&str]) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("ros2-{name}"));
        // A folder of an earlier run.
        let _gone = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).expect("a folder");
        let file = |name: &str| File::create(folder.join(name)).expect("a file");
        let child = Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
            .args(["run", "--ros2", "--json", "--view", "--listen", "127.0.0.1:0", "--seconds", "300"])
            .args(["--publish", "unix:socket", "--turns", "turns.csv", "--out", "out"])
            .args(arguments)
            .current_dir(&folder)
            .env_remove("ROS_DOMAIN_ID")
            .stdout(file("report"))
            .stderr(file("said"))
            .spawn()
            .expect("it starts");
        let run = Self { child, folder };
        let begun = Instant::now();
        while !run.folder.join("socket").exists() {
            assert!(begun.elapsed() < PATIENCE, "the socket is there from the start: {}", run.text("said"));
            std::thread::sleep(Duration::from_millis(10));
        }
        run
    }

    fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.folder.join(name)).expect("it is text")
    }

    /// Returns the end of a connection to its records.
    pub(crate) fn records(&self) -> UnixStream {
        let stream = UnixStream::connect(self.folder.join("socket")).expect("connected");
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        stream
    }

    /// Ends the run.
    pub(crate) fn end(mut self) -> Ended {
        let pid = self.child.id().to_string();
        let sent = Command::new("kill").args(["-s", "INT", &pid]).status();
        assert!(sent.is_ok_and(|status| status.success()), "it still runs: {}", self.text("said"));
        let begun = Instant::now();
        let status = loop {
            match self.child.try_wait().expect("its status") {
                Some(status) => break status,
                None => assert!(begun.elapsed() < PATIENCE, "it ends when it is asked to"),
            }
            std::thread::sleep(Duration::from_millis(20));
        };
        let said = self.text("said");
        assert!(status.success(), "{said}");
        let report: Value =
            serde_json::from_str(&self.text("report")).unwrap_or_else(|error| panic!("{error}: {said}"));
        assert!(report.is_object(), "{said}");
        let row = |line: &str| {
            let column = |place: usize| line.split(',').nth(place)?.parse().ok();
            Some((column(0)?, column(6)?))
        };
        let turns: Option<Vec<(u64, u64)>> = self.text("turns.csv").lines().skip(1).map(row).collect();
        Ended { said, turns: turns.expect("a table of turns") }
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _killed = self.child.kill();
        let _waited = self.child.wait();
    }
}
