//! A place for one value between the worker, who must not wait, and one thread that takes its time.
//!
//! ```text
//! reader: ask --------------------------> wait --> with the value --> ask ...
//! worker:      offer: fills the place, if it was asked for and nobody holds it, and wakes the reader
//! ```
//! The newest value wins: what the worker has while nobody asks is never copied. The value stays in its place, so
//! one with room inside allocates nothing.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::thread::Thread;
use std::time::{Duration, Instant};

/// The place.
#[derive(Debug)]
pub struct Handoff<T> {
    wanted: AtomicBool,
    place: Mutex<T>,
    reader: OnceLock<Thread>,
}

impl<T> Handoff<T> {
    /// A place that holds `value` until the first answer.
    pub fn new(value: T) -> Self {
        Self { wanted: AtomicBool::new(false), place: Mutex::new(value), reader: OnceLock::new() }
    }

    /// The worker's side: lets `fill` write the value, if the reader has asked and does not hold it. It
    /// never waits; whether `fill` was called.
    pub fn offer(&self, fill: impl FnOnce(&mut T)) -> bool {
        if !self.wanted.load(Ordering::Acquire) {
            return false;
        }
        let Ok(mut value) = self.place.try_lock() else { return false };
        fill(&mut value);
        drop(value);
        self.wanted.store(false, Ordering::Release);
        if let Some(reader) = self.reader.get() {
            reader.unpark();
        }
        true
    }

    /// Asks for a value.
    pub fn ask(&self) {
        self.wanted.store(true, Ordering::Release);
    }

    /// Whether the last question has been answered.
    #[must_use]
    pub fn answered(&self) -> bool {
        !self.wanted.load(Ordering::Acquire)
    }

    /// Waits for the answer, at most `patience`; whether it has come. Only one thread may wait here.
    pub fn wait(&self, patience: Duration) -> bool {
        let _first = self.reader.get_or_init(std::thread::current);
        let end = Instant::now() + patience;
        while !self.answered() {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            std::thread::park_timeout(left);
        }
        true
    }

    /// The value, for as long as `look` takes.
    pub fn with<R>(&self, look: impl FnOnce(&mut T) -> R) -> R {
        // A reader that panicked has left the value as it was.
        look(&mut self.place.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn only_what_was_asked_for_is_copied_and_nobody_waits() {
        let handoff = Handoff::new(0);
        assert!(!handoff.offer(|value| *value = 1), "nobody asked");
        handoff.ask();
        handoff.with(|held| {
            assert!(!handoff.offer(|value| *value = 2), "the reader holds it");
            assert_eq!(*held, 0);
        });
        assert!(handoff.offer(|value| *value = 3) && handoff.answered());
        assert!(!handoff.offer(|value| *value = 4), "one answer to a question");
        assert_eq!(handoff.with(|value| *value), 3);
    }

    #[test]
    fn the_reader_is_woken_by_the_answer() {
        let handoff = Arc::new(Handoff::new(0));
        assert!(!{
            handoff.ask();
            handoff.wait(Duration::from_millis(1))
        });
        let worker = Arc::clone(&handoff);
        let waiting = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(20));
            while !worker.offer(|value| *value = 7) {}
        });
        let started = Instant::now();
        while !handoff.wait(Duration::from_secs(20)) {}
        assert!(started.elapsed() < Duration::from_secs(10), "woken, not timed out");
        assert_eq!(handoff.with(|value| *value), 7);
        waiting.join().expect("it ended");
    }
}
