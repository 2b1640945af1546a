//! The log of a night, `docs/nightly/DATE.log`: the machine, then a record of each step.
//!
//! A step that is run again on the same day replaces its own record and leaves the others. So a night can be made in pieces.

use anyhow::{Context, Result};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// First characters of a record.
const RECORD: &str = "== ";

/// Log of a day.
pub(super) struct Log {
    path: PathBuf,
    /// Lines above the records.
    head: String,
    records: Vec<String>,
}

impl Log {
    /// Reads the log at `path`, or begins one under `head`.
    pub(super) fn open(path: PathBuf, head: String) -> Result<Self> {
        match std::fs::read_to_string(&path) {
            Ok(text) => Ok(Self::parse(path, &text)),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                Ok(Self { path, head, records: Vec::new() })
            }
            Err(error) => Err(error).with_context(|| format!("{} cannot be read", path.display())),
        }
    }

    fn parse(path: PathBuf, text: &str) -> Self {
        let mut head = String::new();
        let mut records: Vec<String> = Vec::new();
        for line in text.lines() {
            if line.starts_with(RECORD) {
                records.push(String::new());
            }
            let _ = writeln!(records.last_mut().unwrap_or(&mut head), "{line}");
        }
        for record in &mut records {
            record.truncate(record.trim_end().len());
            record.push('\n');
        }
        head.truncate(head.trim_end().len());
        head.push('\n');
        Self { path, head, records }
    }

    /// Puts `record` in the place of the one of the same step, or behind all others.
    pub(super) fn put(&mut self, record: String) {
        let name = step_of(&record).to_owned();
        match self.records.iter_mut().find(|earlier| step_of(earlier) == name) {
            Some(earlier) => *earlier = record,
            None => self.records.push(record),
        }
    }

    /// File of the log.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    fn text(&self) -> String {
        self.records.iter().fold(self.head.clone(), |text, record| text + "\n" + record)
    }

    /// Writes the log.
    pub(super) fn write(&self) -> Result<()> {
        let folder = self.path.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder).with_context(|| format!("{} cannot be made", folder.display()))?;
        let written = std::fs::write(&self.path, self.text());
        written.with_context(|| format!("{} cannot be written", self.path.display()))
    }
}

/// Name of the step of a record.
fn step_of(record: &str) -> &str {
    record.strip_prefix(RECORD).and_then(|rest| rest.split_whitespace().next()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_that_runs_again_replaces_its_own_record_alone() {
        let text = "cpu     one\n\n== build passed in 1 s\nstatus  0\n  a line\n\n== fuzz FAILED in 2 s\nstatus  1\n";
        let mut log = Log::parse("x.log".into(), text);
        assert_eq!(log.text(), text);
        log.put("== build FAILED in 9 s\nstatus  2\n".into());
        log.put("== camera passed in 3 s\nstatus  0\n".into());
        let wanted = "cpu     one\n\n== build FAILED in 9 s\nstatus  2\n\n== fuzz FAILED in 2 s\nstatus  1\n\n\
                      == camera passed in 3 s\nstatus  0\n";
        assert_eq!(log.text(), wanted);
    }

    #[test]
    fn a_day_without_a_log_begins_one() {
        let log = Log::open("no-such-folder/x.log".into(), "cpu     one\n".into()).expect("a new log");
        assert_eq!(log.text(), "cpu     one\n");
    }
}
