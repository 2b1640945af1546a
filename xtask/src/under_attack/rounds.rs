//! One run of the program, alone or attacked, and its figures.

use super::attackers::{Attack, Doors};
use super::instructions;
use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Longest wait for the page of a program that starts; callgrind makes it some ten times slower.
const PATIENCE: Duration = Duration::from_secs(120);

/// Measure of a turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meter {
    /// The clock, at the camera's 60 Hz.
    Time,
    /// Callgrind, with a camera that waits.
    Instructions,
}

/// The program, and the length of its runs.
#[derive(Debug)]
pub(super) struct Program {
    pub(super) path: PathBuf,
    pub(super) meter: Meter,
    /// Length of a run, s of the camera's time.
    pub(super) seconds: u32,
    /// Folder for its outputs.
    pub(super) folder: PathBuf,
}

/// Figures of a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Round {
    /// Median time of a turn, us.
    pub(super) turn_us: f64,
    /// Relative error of v.
    pub(super) v_error: f64,
    /// Frames that were lost or never handled.
    pub(super) lost: f64,
    /// Turns that used a sample of the motion.
    pub(super) samples_used: f64,
    /// Foreign pages that were let in.
    pub(super) let_in: f64,
    /// Connections, requests and datagrams of the attackers.
    pub(super) attempts: f64,
}

impl Program {
    /// A run that nobody attacks.
    pub(super) fn quiet(&self) -> Result<Round> {
        let doors = self.doors()?;
        let report = report_of(self.start(&doors)?)?;
        round(&report, &Attack::default())
    }

    /// A run that is attacked from its first second on.
    pub(super) fn attacked(&self) -> Result<Round> {
        let (doors, attack) = (self.doors()?, Attack::default());
        let report = std::thread::scope(|scope| {
            let run = self.start(&doors)?;
            let report = attack.start(scope, &doors).context("cannot start the attackers");
            let report = report.and_then(|()| report_of(run));
            attack.over.store(true, Ordering::Relaxed);
            report
        })?;
        round(&report, &attack)
    }

    /// Doors that were free a moment ago.
    fn doors(&self) -> Result<Doors> {
        let [page, foxglove] = [TcpListener::bind("127.0.0.1:0")?, TcpListener::bind("127.0.0.1:0")?];
        Ok(Doors {
            page: page.local_addr()?,
            foxglove: foxglove.local_addr()?,
            motion: UdpSocket::bind("127.0.0.1:0")?.local_addr()?,
            socket: self.folder.join("publish.sock"),
        })
    }

    /// Returns the median of the instructions of a turn in the last run.
    pub(super) fn instructions(&self) -> Result<f64> {
        instructions::median_of_turns(&self.counts())
    }

    fn counts(&self) -> PathBuf {
        self.folder.join("counts")
    }

    /// Starts the program and waits until its page answers.
    fn start(&self, doors: &Doors) -> Result<Child> {
        let (mut command, patience): (_, &[&str]) = match self.meter {
            Meter::Time => (Command::new(&self.path), &[]),
            Meter::Instructions => (instructions::counting(&self.path, &self.counts())?, &["--patient"]),
        };
        command
            .arg("run")
            .args(patience)
            .args(["--json", "--view", "--seconds", &self.seconds.to_string()])
            .args(["--listen", &doors.page.to_string(), "--foxglove", &doors.foxglove.to_string()])
            .args(["--motion", &format!("udp:{}", doors.motion)])
            .args(["--publish", &format!("unix:{}", doors.socket.display())])
            .arg("--out")
            .arg(self.folder.join("out"))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let mut run = command.spawn().with_context(|| format!("cannot start {}", self.path.display()))?;
        let begun = Instant::now();
        while !answers(doors.page) {
            if run.try_wait()?.is_some() || begun.elapsed() > PATIENCE {
                let _ended = run.kill();
                let said = run.wait_with_output()?;
                bail!("the program shows no page: {}", String::from_utf8_lossy(&said.stderr));
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        Ok(run)
    }
}

fn answers(page: SocketAddr) -> bool {
    TcpStream::connect_timeout(&page, Duration::from_millis(200)).is_ok()
}

/// Waits for the end of a run and reads its report.
fn report_of(run: Child) -> Result<Value> {
    let output = run.wait_with_output()?;
    let said = String::from_utf8_lossy(&output.stderr);
    // A run that misses a target ends with 1, and its report says so.
    ensure!(
        output.status.code().is_some_and(|code| code <= 1),
        "the run ended with {}: {said}",
        output.status
    );
    serde_json::from_slice(&output.stdout).with_context(|| format!("the run printed no report: {said}"))
}

/// Reads the figures of a report.
fn round(report: &Value, attack: &Attack) -> Result<Round> {
    let checks = report["checks"].as_array().context("the report has no checks")?;
    let value = |name: &str| {
        let check = checks.iter().find(|check| check["name"] == name);
        check.and_then(|check| check["value"].as_f64()).with_context(|| format!("the report has no {name}"))
    };
    Ok(Round {
        turn_us: value("turn_us_median")?,
        v_error: value("field_error_v")?,
        lost: value("frames_lost")? + value("frames_never_handled")?,
        samples_used: report["motion"]["commanded"].as_f64().context("the report has no motion")?,
        let_in: attack.let_in.load(Ordering::Relaxed) as f64,
        attempts: attack.attempts.load(Ordering::Relaxed) as f64,
    })
}
