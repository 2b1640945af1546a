//! The program with a motion from outside, and what it reports at its end.

use crate::stuffing::unstuffed;
use meniscus::runtime::output::Packet;
use meniscus_data::recording::EstimateRecording;
use serde_json::Value;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// Camera time of frame 0 of the simulated camera, us.
pub(super) const FRAME_0_US: u64 = 1_000_000;

/// Time for the start of a run on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// Time from the first packet to a settled map between the clocks: the first frames of runs that start at once wait for each other.
const SETTLED: Duration = Duration::from_millis(2500);

/// A run of ten seconds at the most.
pub(super) struct MotionRun {
    child: Child,
    folder: PathBuf,
    /// Frame 0 on the host's clock by the newest packet, ns since 1970; the largest number before the first packet.
    newest_ns: Arc<AtomicU64>,
    /// The same when the stream was made.
    begun_ns: OnceLock<u64>,
    /// First packet.
    first: Instant,
}

/// The end of a run.
pub(super) struct Report {
    pub(super) motion: Value,
    pub(super) said: String,
    pub(super) estimates: EstimateRecording,
    deadlines: Value,
    /// Change of the map between the clocks behind the beginning of the stream.
    pub(super) map_moved: Duration,
}

impl MotionRun {
    /// Starts a run in a domain of its own.
    pub(super) fn spawn(name: &str, domain: usize, arguments: &[&str]) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("ros2-motion-{name}"));
        // A folder of an earlier run.
        let _gone = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).expect("a folder");
        let file = |name: &str| File::create(folder.join(name)).expect("a file");
        let child = Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
            .args(["run", "--json", "--fields", "none", "--camera-latency-ms", "8.3", "--out", "out"])
            .args(["--publish", "unix:socket", "--estimates", "estimates.safetensors"])
            .args(["--ros2", &domain.to_string()])
            .args(arguments)
            .current_dir(&folder)
            .stdout(file("report"))
            .stderr(file("said"))
            .spawn()
            .expect("it starts");
        let newest_ns = Arc::new(AtomicU64::new(u64::MAX));
        Self { child, folder, newest_ns, begun_ns: OnceLock::new(), first: Instant::now() }
    }

    fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.folder.join(name)).expect("it is text")
    }

    /// Waits for its first packet. Each packet states the run's map between the clocks: a frame that comes earlier than all before it
    /// moves the map.
    pub(super) fn begin(&mut self) {
        let (begun, socket) = (Instant::now(), self.folder.join("socket"));
        while !socket.exists() {
            assert!(begun.elapsed() < PATIENCE, "the socket is there from the start: {}", self.text("said"));
            std::thread::sleep(Duration::from_millis(5));
        }
        let stream = UnixStream::connect(socket).expect("connected");
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        let (mut reader, newest_ns) = (BufReader::new(stream), Arc::clone(&self.newest_ns));
        std::thread::spawn(move || {
            let mut stuffed = Vec::new();
            while reader.read_until(0, &mut stuffed).is_ok_and(|length| length > 0) {
                let packet = Packet::read(&unstuffed(&stuffed)).ok();
                let host = packet.and_then(|packet| Some((packet.time.0, packet.host?.unix_ns)));
                if let Some((camera_us, unix_ns)) = host {
                    newest_ns.store(unix_ns - 1000 * (camera_us - FRAME_0_US), Ordering::Relaxed);
                }
                stuffed.clear();
            }
        });
        while self.newest_ns.load(Ordering::Relaxed) == u64::MAX {
            assert!(begun.elapsed() < PATIENCE, "it has a first packet: {}", self.text("said"));
            std::thread::sleep(Duration::from_millis(5));
        }
        self.first = Instant::now();
    }

    /// Returns the time of frame 0 on the host's clock, ns since 1970, by the run's map at the first call, which waits until the map has
    /// settled.
    pub(super) fn begun_ns(&self) -> u64 {
        *self.begun_ns.get_or_init(|| {
            std::thread::sleep(SETTLED.saturating_sub(self.first.elapsed()));
            self.newest_ns.load(Ordering::Relaxed)
        })
    }

    /// Asks it to end.
    pub(super) fn stop(&self) {
        let sent = Command::new("kill").args(["-s", "INT", &self.child.id().to_string()]).status();
        assert!(sent.is_ok_and(|status| status.success()), "it still runs: {}", self.text("said"));
    }

    /// Waits for its end.
    pub(super) fn report(mut self) -> Report {
        let status = self.child.wait().expect("it ends");
        let said = self.text("said");
        assert!(status.success(), "{said}");
        let report: Value =
            serde_json::from_str(&self.text("report")).unwrap_or_else(|error| panic!("{error}: {said}"));
        let estimates =
            EstimateRecording::load(&self.folder.join("estimates.safetensors")).expect("estimates");
        let map_moved =
            Duration::from_nanos(self.begun_ns().abs_diff(self.newest_ns.load(Ordering::Relaxed)));
        Report {
            motion: report["motion"].clone(),
            said,
            estimates,
            deadlines: report["deadlines"].clone(),
            map_moved,
        }
    }
}

impl Drop for MotionRun {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _killed = self.child.kill();
        let _waited = self.child.wait();
    }
}

impl Report {
    /// Returns the share of frames whose turn ended behind its deadline.
    pub(super) fn late_share(&self) -> f64 {
        let of = |name: &str| self.deadlines[name].as_f64().unwrap_or_else(|| panic!("no {name}"));
        of("late") / of("taken")
    }

    /// Returns a counter of the stamped samples.
    pub(super) fn count(&self, name: &str) -> u64 {
        self.motion["stamped"][name].as_u64().unwrap_or_else(|| panic!("no {name} in {}", self.motion))
    }
}
