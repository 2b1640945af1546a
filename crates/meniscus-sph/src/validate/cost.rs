//! Processor time of a computation.

use std::time::Instant;

/// Measures from its start.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch {
    clock: Instant,
    processor_s: Option<f64>,
}

impl Stopwatch {
    /// Starts now.
    #[must_use]
    pub fn start() -> Self {
        Self { clock: Instant::now(), processor_s: processor_s() }
    }

    /// Processor time of the whole process since the start, s; the time of the clock where the
    /// system does not tell.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        let processor = processor_s().zip(self.processor_s).map(|(now, then)| now - then);
        processor.unwrap_or_else(|| self.wall_s())
    }

    /// Time of the clock since the start, s.
    #[must_use]
    pub fn wall_s(&self) -> f64 {
        self.clock.elapsed().as_secs_f64()
    }
}

/// Processor time of this process so far, s, where the system tells (Linux).
fn processor_s() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let (user, system): (f64, f64) = (fields.next()?.parse().ok()?, fields.next()?.parse().ok()?);
    // Linux reports hundredths of a second on every architecture.
    Some((user + system) / 100.0)
}
