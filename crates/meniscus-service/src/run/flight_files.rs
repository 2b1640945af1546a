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
    failed: Option<String>,
    /// Records that came while another one was being written.
    pub(super) lost: u64,
}

impl FlightFiles {
    /// Writes `flight-NN.csv` into `folder` for every record, until the run has `ended`.
    pub(super) fn keep(recorder: &FlightRecorder, folder: &Path, ended: &AtomicBool) -> Self {
        let mut files = Self::default();
        loop {
            // Read before the wait, so that the record of a run's last turns is not left behind.
            let over = ended.load(Ordering::Relaxed);
            let table = recorder.take(LOOK, csv);
            if let Some(table) = &table {
                files.write(folder, table);
            }
            if over && table.is_none() {
                return files;
            }
        }
    }

    fn write(&mut self, folder: &Path, table: &str) {
        let path = folder.join(format!("flight-{:02}.csv", self.number % FILES + 1));
        self.number += 1;
        match write_whole(&path, table.as_bytes()) {
            Ok(()) if self.number <= FILES => self.written.push(path),
            Ok(()) => {}
            // A full disk must not stop the liquid from being watched.
            Err(error) => self.failed = Some(error.to_string()),
        }
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
        if let Some(why) = &self.failed {
            lines.push(format!("a record of a missed deadline cannot be written: {why}"));
        }
        lines
    }
}
