//! Keeps what the flight recorder hands on: a table of the last ten seconds for each missed deadline.

use super::turns;
use meniscus_platform::files::write_whole;
use meniscus_service::live::Flight;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Files that are kept; the next record takes the place of the oldest.
const FILES: usize = 20;

/// Pause between two looks at whether the run has ended.
const LOOK: Duration = Duration::from_millis(100);

/// What was written.
#[derive(Debug, Default)]
pub(super) struct Records {
    written: Vec<PathBuf>,
    number: usize,
    failed: Option<String>,
}

/// Writes `flight-NN.csv` into `folder` for every record, until the run has `ended`.
pub(super) fn keep(flight: &Flight, folder: &Path, ended: &AtomicBool) -> Records {
    let mut records = Records::default();
    loop {
        // Asked before the look, so that the record of a run's last turns is not left behind.
        let over = ended.load(Ordering::Relaxed);
        let table = flight.take(LOOK, turns::csv);
        if let Some(table) = &table {
            records.write(folder, table);
        }
        if over && table.is_none() {
            return records;
        }
    }
}

impl Records {
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

    /// Tells a person, if there is anything to tell; `lost` records found the keeper busy.
    pub(super) fn tell(&self, lost: u64) {
        if let (Some(first), Some(last)) = (self.written.first(), self.written.last()) {
            let to = if first == last { String::new() } else { format!(" to {}", last.display()) };
            eprintln!("the deadline was missed; the seconds around it: {}{to}", first.display());
        }
        if self.number > FILES {
            eprintln!("of {} such records the last {FILES} are kept", self.number);
        }
        if lost > 0 {
            eprintln!("{lost} more records came while one was being written, and are lost");
        }
        if let Some(why) = &self.failed {
            eprintln!("a record of a missed deadline cannot be written: {why}");
        }
    }
}
