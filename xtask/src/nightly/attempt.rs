//! Runs a step and puts what it said into a record of the log.

use super::state::State;
use crate::process::{Step, cargo};
use anyhow::{Context, Result};
use serde_json::Value;
use std::fmt::Write as _;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Last lines of a step's output that the log keeps, where it is no report.
const KEPT_LINES: usize = 20;

/// Outcome of a step.
pub(super) struct Done {
    /// Exit status, or why there is none.
    status: String,
    exit_zero: bool,
    /// Names of the checks in its report that missed their target.
    missed: Vec<String>,
    took: Duration,
    /// Its checks, or the last lines that it printed.
    lines: Vec<String>,
}

impl Done {
    /// Whether the step ended with status 0 and missed no target.
    pub(super) fn passed(&self) -> bool {
        self.exit_zero && self.missed.is_empty()
    }

    /// The step's part of the log, for a tree in this state.
    pub(super) fn record(&self, step: &Step, state: &State) -> String {
        let verdict = if self.passed() { "passed" } else { "FAILED" };
        let mut text = format!("== {} {verdict} in {:.0} s\n", step.name, self.took.as_secs_f64());
        let _ = writeln!(text, "date    {}", state.date);
        let _ = writeln!(text, "commit  {}", state.commit);
        let _ = writeln!(text, "command {}", portable(&step.line(), &state.root));
        let _ = writeln!(text, "status  {}", self.status);
        if !self.missed.is_empty() {
            let _ = writeln!(text, "missed  {}", self.missed.join(", "));
        }
        for line in &self.lines {
            let _ = writeln!(text, "  {line}");
        }
        text
    }
}

/// Runs a step; one that does not start has failed like any other.
pub(super) fn attempt(root: &Path, step: &Step) -> Done {
    let begin = Instant::now();
    let ran = output_of(root, step);
    let took = begin.elapsed();
    match ran {
        Ok((status, lines)) => {
            let checks = checks_of(&lines.join("\n"));
            let missed = checks
                .iter()
                .filter(|check| check["ok"] == false)
                .map(|check| text_of(&check["name"]))
                .collect();
            let lines = match &checks[..] {
                [] => lines[lines.len().saturating_sub(KEPT_LINES)..].to_vec(),
                _ => checks.iter().map(row).collect(),
            };
            Done { status: status.to_string(), exit_zero: status.success(), missed, took, lines }
        }
        Err(error) => Done {
            status: format!("{error:#}"),
            exit_zero: false,
            missed: Vec::new(),
            took,
            lines: Vec::new(),
        },
    }
}

/// Exit status and output of a step; its messages go to the terminal and are kept where it prints nothing else.
fn output_of(root: &Path, step: &Step) -> Result<(std::process::ExitStatus, Vec<String>)> {
    let mut command = step.command(root)?;
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).stdin(Stdio::null());
    let mut child = command.spawn().with_context(|| format!("`{}` did not start", step.line()))?;
    // Both pipes are emptied at the same time: a child that fills one of them would wait for ever.
    let messages = child.stderr.take().map(|pipe| {
        std::thread::spawn(move || {
            let lines = BufReader::new(pipe).lines().map_while(Result::ok);
            lines.inspect(|line| eprintln!("{line}")).collect::<Vec<_>>()
        })
    });
    let printed: Vec<String> = child
        .stdout
        .take()
        .map_or(Vec::new(), |pipe| BufReader::new(pipe).lines().map_while(Result::ok).collect());
    let said = messages.and_then(|thread| thread.join().ok()).unwrap_or_default();
    let status = child.wait().with_context(|| format!("`{}` was lost", step.line()))?;
    Ok((status, if status.success() { printed } else { printed.into_iter().chain(said).collect() }))
}

/// The checks of a report `{"checks": [{"name", "value", "unit", "target", "ok"}]}`; none where `output` is another. The
/// studies print such a report, and end with status 0 whatever it says.
fn checks_of(output: &str) -> Vec<Value> {
    // Messages may follow the report.
    let report = output
        .find('{')
        .and_then(|at| serde_json::Deserializer::from_str(&output[at..]).into_iter::<Value>().next()?.ok());
    report.and_then(|report| report["checks"].as_array().cloned()).unwrap_or_default()
}

/// A check in a line.
fn row(check: &Value) -> String {
    // The target of an informational row says the same in another word.
    let (target, verdict) = match check["ok"].as_bool() {
        Some(true) => (text_of(&check["target"]), "ok"),
        Some(false) => (text_of(&check["target"]), "MISSED"),
        None => (String::new(), "informational"),
    };
    let value =
        check["value"].as_f64().map_or_else(|| text_of(&check["value"]), |value| format!("{value:.4}"));
    let said = [text_of(&check["name"]), value, text_of(&check["unit"]), target, verdict.into()];
    said.into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>().join("  ")
}

/// Text of a value, nothing of an absent one.
fn text_of(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// Where cargo and the checkout lie on this machine is of no use to a reader of the log.
fn portable(line: &str, root: &Path) -> String {
    line.replace(&cargo(), "cargo").replace(&format!("{}/", root.display()), "")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state() -> State {
        State { root: "/w".into(), date: "2026-01-02T03:04:05Z".into(), commit: "abc Subject (clean)".into() }
    }

    #[test]
    fn a_step_that_fails_is_recorded_with_its_messages() {
        let step = Step::new("bad", ["sh", "-c", "echo printed; echo reason >&2; exit 4"]);
        let done = attempt(Path::new("."), &step);
        assert!(!done.passed());
        let record = done.record(&step, &state());
        assert!(record.starts_with("== bad FAILED") && record.contains("exit status: 4"), "{record}");
        assert!(record.contains("commit  abc Subject (clean)\n"), "{record}");
        assert!(record.contains("  printed\n  reason\n"), "{record}");
        let absent = attempt(Path::new("."), &Step::new("absent", ["./no-such-program"]));
        assert!(!absent.passed() && absent.status.contains("did not start"), "{}", absent.status);
    }

    #[test]
    fn a_missed_target_in_a_report_fails_the_step() {
        let report = r#"{"checks": [{"name": "a", "value": 1.5, "unit": "mm", "target": "<= 2", "ok": true},
            {"name": "b", "value": 3.0, "ok": false}, {"name": "c", "value": null, "ok": null}]}"#;
        let step = Step::new("study", ["echo", &format!("{report}\nerror: a check missed its target")]);
        let done = attempt(Path::new("."), &step);
        assert!(done.exit_zero && !done.passed());
        assert_eq!(done.missed, ["b"]);
        assert_eq!(done.lines, ["a  1.5000  mm  <= 2  ok", "b  3.0000  MISSED", "c  informational"]);
        assert!(checks_of("no report").is_empty());
    }

    #[test]
    fn places_on_this_machine_are_not_in_the_log() {
        let line = format!("{} build /w/target/release/meniscus", cargo());
        assert_eq!(portable(&line, Path::new("/w")), "cargo build target/release/meniscus");
    }
}
