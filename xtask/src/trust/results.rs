//! Results of the attack tests, as the test runner prints them.

use crate::process;
use anyhow::{Context, Result, ensure};
use std::path::Path;

/// Result of one test.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Outcome {
    /// Class and name.
    pub(super) test: String,
    /// Whether it passed.
    pub(super) passed: bool,
    /// Whether it passed only because something was missing on this machine.
    pub(super) skipped: bool,
}

/// Whether `test` ran, passed, and was not skipped.
pub(super) fn passed(outcomes: &[Outcome], test: &str) -> bool {
    outcomes.iter().any(|outcome| outcome.test == test && outcome.passed && !outcome.skipped)
}

/// Runs the attack tests one after the other, so that times and memory are their own.
pub(super) fn run(root: &Path) -> Result<Vec<Outcome>> {
    let words = ["test", "--release", "--workspace", "--test", "attacks", "--"];
    let output = process::command(&process::cargo())
        .args(words)
        .args(["--test-threads", "1", "--show-output"])
        .current_dir(root)
        .stderr(std::process::Stdio::inherit())
        .output()?;
    let outcomes = parse(&String::from_utf8_lossy(&output.stdout));
    ensure!(!outcomes.is_empty(), "cargo {} printed no results", words.join(" "));
    Ok(outcomes)
}

/// Returns the results that the test command has printed into `file`.
pub(super) fn read(file: &Path) -> Result<Vec<Outcome>> {
    let text = std::fs::read_to_string(file).with_context(|| file.display().to_string())?;
    let outcomes = parse(&text);
    ensure!(!outcomes.is_empty(), "{} has no results of tests: `cargo test` prints them", file.display());
    Ok(outcomes)
}

/// Reads `test CLASS::NAME ... ok` and, below, what each test has printed.
fn parse(text: &str) -> Vec<Outcome> {
    let mut outcomes: Vec<Outcome> = Vec::new();
    let mut printing = String::new();
    for line in text.lines() {
        if let Some((test, verdict)) = line.strip_prefix("test ").and_then(|rest| rest.split_once(" ... ")) {
            outcomes.push(Outcome { test: test.into(), passed: verdict.trim() == "ok", skipped: false });
        } else if let Some(of) = line.strip_prefix("---- ").and_then(|rest| rest.split(' ').next()) {
            printing = of.into();
        } else if line.starts_with("skipped: ")
            && let Some(outcome) = outcomes.iter_mut().find(|outcome| outcome.test == printing)
        {
            outcome.skipped = true;
        }
    }
    outcomes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_read_and_a_skipped_test_has_not_passed() {
        let text = "running 3 tests\ntest a::x ... ok\ntest a::y ... FAILED\ntest a::z ... ok\n\nsuccesses:\n\n\
                    ---- a::z stdout ----\nskipped: no disk\n\n";
        let outcomes = parse(text);
        let all = ["a::x", "a::y", "a::z", "a::w"].map(|test| passed(&outcomes, test));
        assert_eq!(all, [true, false, false, false]);
        assert_eq!(outcomes.iter().filter(|outcome| outcome.skipped).count(), 1);
    }
}
