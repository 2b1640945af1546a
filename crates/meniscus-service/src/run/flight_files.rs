//! Files of the flight recorder: a table of the last ten seconds for each missed deadline.

use super::turn_table::csv;
use crate::live::FlightRecorder;
use meniscus_platform::files::write_whole;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Files that are kept; the next record replaces the oldest.
const FILES: usize = 20;

/// Interval at which the end of the run is checked.
const LOOK: Duration = Duration::from_millis(100);

/// Files that a run has written.
#[derive(Debug, Default)]
pub struct FlightFiles {
    written: Vec<PathBuf>,
    number: usize,
    /// Records that could not be written.
    failed: u64,
    /// Reason for the last of them.
    reason: String,
    /// Whether the last record could not be written.
    failing: bool,
    /// Records that came while another one was being written.
    pub(super) lost: u64,
}

impl FlightFiles {
    /// Writes `flight-NN.csv` into `folder` for every record, until the run has `ended`. A disk that does not take one, and one
    /// that takes them again, are reported by `say` at once.
    pub(super) fn keep(
        recorder: &FlightRecorder,
        folder: &Path,
        ended: &AtomicBool,
        say: &dyn Fn(&str),
    ) -> Self {
        let mut files = Self::default();
        loop {
            // Read before the wait, so that the record of a run's last turns is not left behind.
            let over = ended.load(Ordering::Relaxed);
            let table = recorder.take(LOOK, csv);
            if let Some(table) = &table {
                files.write(folder, table, say);
            }
            if over && table.is_none() {
                return files;
            }
        }
    }

    fn write(&mut self, folder: &Path, table: &str, say: &dyn Fn(&str)) {
        let path = folder.join(format!("flight-{:02}.csv", self.number % FILES + 1));
        let written = write_whole(&path, table.as_bytes());
        let failing = written.is_err();
        match written {
            Ok(()) => {
                self.number += 1;
                if self.number <= FILES {
                    self.written.push(path);
                }
                if self.failing {
                    say(&format!("records of missed deadlines are written again; {} were not", self.failed));
                }
            }
            // A full disk must not stop the liquid from being watched.
            Err(error) => {
                self.failed += 1;
                self.reason = error.to_string();
                if !self.failing {
                    say(&format!("a record of a missed deadline is lost: {error}; the run goes on"));
                }
            }
        }
        self.failing = failing;
    }

    /// Returns the lines for a person; none if no deadline was missed.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if let (Some(first), Some(last)) = (self.written.first(), self.written.last()) {
            let to = if first == last { String::new() } else { format!(" to {}", last.display()) };
            lines.push(format!("the deadline was missed; the seconds around it: {}{to}", first.display()));
        }
        if self.number > FILES {
            lines.push(format!("of {} such records the last {FILES} are kept", self.number));
        }
        if self.lost > 0 {
            lines.push(format!("{} more records came while one was being written, and are lost", self.lost));
        }
        if self.failed > 0 {
            let Self { failed, reason, .. } = self;
            lines.push(format!(
                "records of missed deadlines that could not be written: {failed}; the last one: {reason}"
            ));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    #[test]
    fn a_disk_that_takes_nothing_is_reported_once_and_what_is_lost_is_counted() {
        let folder = std::env::temp_dir().join(format!("meniscus-flights-{}", std::process::id()));
        // A file in the place of the folder: nothing can be written, for root neither.
        std::fs::write(&folder, "").expect("a file");
        let (mut files, said) = (FlightFiles::default(), RefCell::new(Vec::new()));
        let say = |line: &str| said.borrow_mut().push(line.to_owned());
        files.write(&folder, "a", &say);
        files.write(&folder, "b", &say);
        assert_eq!(said.borrow().len(), 1, "{said:?}");
        assert!(said.borrow()[0].starts_with("a record of a missed deadline is lost: cannot"), "{said:?}");
        std::fs::remove_file(&folder).expect("removed");
        files.write(&folder, "c", &say);
        assert_eq!(said.borrow()[1], "records of missed deadlines are written again; 2 were not");
        assert_eq!(std::fs::read_to_string(folder.join("flight-01.csv")).expect("written"), "c");
        let lines = files.lines();
        assert!(lines.iter().any(|line| line.contains("could not be written: 2")), "{lines:?}");
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
