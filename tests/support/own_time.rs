//! Time that a thread runs or is held up by others, without that in which it is ready and waits for a processor.
//!
//! On a busy machine any call may seem long, because the thread does not run. What a test asks is whether a lock or a peer held
//! it up.

use std::time::{Duration, Instant};

/// A stretch of the calling thread's time.
pub(crate) struct OwnTime {
    ready: Duration,
    begun: Instant,
}

impl OwnTime {
    /// Begins now.
    pub(crate) fn start() -> Self {
        Self { ready: ready(), begun: Instant::now() }
    }

    /// Time since the start, without waits for a processor.
    pub(crate) fn elapsed(&self) -> Duration {
        let wall = self.begun.elapsed();
        wall.saturating_sub(ready().saturating_sub(self.ready))
    }
}

/// All time in which the calling thread was ready and did not run.
///
/// Source: Linux, `Documentation/scheduler/sched-stats.rst`: `/proc/PID/schedstat` has the time on the processor, the time in the
/// run queue, both in ns, and the number of time slices.
fn ready() -> Duration {
    let text =
        std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux with scheduler statistics");
    let nanoseconds = text.split_whitespace().nth(1).and_then(|field| field.parse().ok());
    Duration::from_nanos(nanoseconds.expect("a time in the run queue"))
}
