//! The program under test, as a child: its report, its words, its exit status.

use serde_json::Value;
use std::io;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Where the program lies in the guest.
pub(crate) const PROGRAM: &str = "/bin/meniscus";
/// Where it writes.
pub(crate) const OUT: &str = "/tmp/out";
/// Its table of turns.
pub(crate) const TURNS: &str = "/tmp/turns.csv";

/// Exit status and output of a child process.
#[derive(Clone, Debug)]
pub(crate) struct Ran {
    /// Exit status; -1 for a signal.
    pub(crate) exit: i32,
    /// JSON on standard output; null if it is none.
    pub(crate) report: Value,
    /// Last line on standard error.
    pub(crate) said: String,
    /// All of standard error.
    pub(crate) words: String,
    /// The table of turns, if there is one.
    pub(crate) turns: String,
}

/// Arguments of `meniscus run --source usb`, with `more` behind them.
pub(crate) fn arguments(seconds: f64, more: &[&str]) -> Vec<String> {
    let seconds = seconds.to_string();
    let own = ["run", "--source", "usb", "--json", "--out", OUT, "--turns", TURNS, "--seconds", &seconds];
    own.iter().chain(more).map(|word| (*word).to_owned()).collect()
}

/// Starts the program.
pub(crate) fn start(arguments: &[String]) -> io::Result<std::process::Child> {
    let _old = std::fs::remove_file(TURNS);
    let mut command = Command::new(PROGRAM);
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn()
}

/// Waits for its end.
pub(crate) fn finish(child: std::process::Child) -> io::Result<Ran> {
    let Output { status, stdout, stderr } = child.wait_with_output()?;
    let words = String::from_utf8_lossy(&stderr).into_owned();
    let said = words.lines().last().unwrap_or_default().to_owned();
    let turns = std::fs::read_to_string(Path::new(TURNS)).unwrap_or_default();
    let report = serde_json::from_slice(&stdout).unwrap_or(Value::Null);
    Ok(Ran { exit: status.code().unwrap_or(-1), report, said, words, turns })
}

/// Both.
pub(crate) fn run(arguments: &[String]) -> io::Result<Ran> {
    finish(start(arguments)?)
}
