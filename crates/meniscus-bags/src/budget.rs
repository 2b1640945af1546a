//! Budget of memory and time for a file that may be made to exhaust both.
//!
//! Small files can unpack to gigabytes, or hold millions of records of nothing. What counts is the work between one image and
//! the next: a recording that gives images may be as long as it likes.

use std::time::{Duration, Instant};

/// Longest record, chunk and image, bytes: the largest depth image that is read has 32 MiB.
pub(super) const LONGEST: usize = 48 << 20;
/// Bytes between two images.
const BYTES: u64 = 512 << 20;
/// Time that a reader may spend between two images.
pub(super) const TIME: Duration = Duration::from_secs(5);

/// Work left to a reader until the next image.
#[derive(Debug)]
pub(super) struct Budget {
    bytes: u64,
    spent: Duration,
}

impl Budget {
    /// Returns a whole budget.
    pub(super) fn new() -> Self {
        Self { bytes: BYTES, spent: Duration::ZERO }
    }

    /// Returns the time left.
    pub(super) fn time_left(&self) -> Duration {
        TIME.saturating_sub(self.spent)
    }

    /// Takes a record of so many bytes, `least` at the least, that took the time since `begun`.
    pub(super) fn take(&mut self, bytes: usize, least: u64, begun: Instant) -> Result<(), String> {
        self.spent += begun.elapsed();
        let bytes = (bytes as u64).max(least);
        self.bytes = self
            .bytes
            .checked_sub(bytes)
            .ok_or_else(|| format!("it unpacks to more than {} MiB without an image", BYTES >> 20))?;
        if self.spent > TIME {
            return Err(format!("it takes longer than {} s to find an image in it", TIME.as_secs()));
        }
        Ok(())
    }
}
