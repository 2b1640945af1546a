//! The flight recorder: the last ten seconds of turns, kept by the worker and handed on after a missed deadline.
//!
//! The worker writes every turn into a ring that was there before the first frame. Half a second after a turn that
//! missed its deadline, or before which frames were never handled, it offers the ring to whoever keeps records; if they are still busy with the one before, the
//! record is counted as lost, and the worker goes on.

use crate::sink::{RunCounters, TurnRecord, TurnSink};
use crate::timed_turn::TimedTurn;
use meniscus::runtime::DEADLINE_US;
use meniscus_platform::handoff::Handoff;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Turns that are kept: ten seconds.
pub const KEPT: usize = 600;

/// Turns after a miss that belong to its record: half a second.
const AFTER: usize = 30;

/// The hand-over of a record from the worker to its keeper.
#[derive(Debug)]
pub struct FlightRecorder<T = TimedTurn> {
    place: Handoff<Vec<T>>,
    lost: AtomicU64,
}

impl<T> Default for FlightRecorder<T> {
    fn default() -> Self {
        Self { place: Handoff::new(Vec::with_capacity(KEPT)), lost: AtomicU64::new(0) }
    }
}

impl<T> FlightRecorder<T> {
    /// The keeper's side: waits at most `patience` for a record and shows it to `keep`, oldest turn first. Only one
    /// thread may wait here.
    pub fn take<R>(&self, patience: Duration, keep: impl FnOnce(&[T]) -> R) -> Option<R> {
        if !self.place.wait(patience) {
            return None;
        }
        let kept = self.place.with(|turns| keep(turns));
        self.place.ask();
        Some(kept)
    }

    /// Returns the worker's side, with room for all that is kept.
    #[must_use]
    pub fn ring(&self) -> FlightRing<'_, T>
    where
        T: Copy,
    {
        FlightRing::new(self)
    }

    /// Tells the worker that a keeper is there.
    pub fn open(&self) {
        self.place.ask();
    }

    /// Records that nobody had time for.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.lost.load(Ordering::Relaxed)
    }
}

/// The worker's side: a ring of the last turns.
#[derive(Debug)]
pub struct FlightRing<'f, T = TimedTurn> {
    turns: Vec<T>,
    next: usize,
    /// Turns until the record of a miss is complete.
    owed: Option<usize>,
    /// Frames so far that the host was late for or never handled; one that the camera lost makes no record.
    misses: u64,
    flight: &'f FlightRecorder<T>,
}

impl<'f, T: Copy> FlightRing<'f, T> {
    fn new(flight: &'f FlightRecorder<T>) -> Self {
        Self { turns: Vec::with_capacity(KEPT), next: 0, owed: None, misses: 0, flight }
    }

    /// Takes a turn in, the oldest out, and hands on a record that is complete.
    fn push(&mut self, turn: T, missed: bool) {
        if self.turns.len() < KEPT {
            self.turns.push(turn);
        } else if let Some(oldest) = self.turns.get_mut(self.next) {
            *oldest = turn;
            self.next = (self.next + 1) % KEPT;
        }
        if missed && self.owed.is_none() {
            self.owed = Some(AFTER);
        }
        match self.owed {
            Some(0) => {
                self.owed = None;
                self.hand_on();
            }
            Some(turns) => self.owed = Some(turns - 1),
            None => {}
        }
    }

    /// Also at the end of a run, when a record is owed and no more turns come.
    fn close(&mut self) {
        if self.owed.take().is_some() {
            self.hand_on();
        }
    }

    fn hand_on(&self) {
        let (newer, older) = self.turns.split_at(self.next);
        let taken = self.flight.place.offer(|place| {
            // It has room for all that the ring holds.
            place.clear();
            place.extend_from_slice(older);
            place.extend_from_slice(newer);
        });
        if !taken {
            self.flight.lost.fetch_add(1, Ordering::Relaxed);
        }
    }
}

impl TurnSink for FlightRing<'_> {
    fn accept(&mut self, record: &TurnRecord<'_>) {
        let logged = record.logged;
        let misses = logged.frames.late + logged.frames.never_handled;
        let missed = logged.latency_us > DEADLINE_US || misses > self.misses;
        self.misses = misses;
        self.push(*logged, missed);
    }

    fn finish(&mut self, _counters: &RunCounters) {
        self.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: Duration = Duration::ZERO;

    fn turns(ring: &mut FlightRing<'_, usize>, numbers: std::ops::Range<usize>, late: usize) {
        numbers.for_each(|n| ring.push(n, n == late));
    }

    #[test]
    fn a_record_has_ten_seconds_and_ends_half_a_second_after_the_miss() {
        let flight = FlightRecorder::default();
        flight.open();
        let mut ring = FlightRing::new(&flight);
        turns(&mut ring, 0..1000, usize::MAX);
        assert!(flight.take(NOW, |_| ()).is_none(), "no miss, no record");
        turns(&mut ring, 1000..1100, 1007);
        let seen = flight.take(NOW, |turns| turns.to_vec()).expect("a record");
        assert!(seen.iter().copied().eq(1007 + AFTER + 1 - KEPT..=1007 + AFTER), "{seen:?}");
    }

    #[test]
    fn a_keeper_that_is_busy_loses_records_and_holds_up_nobody() {
        let flight = FlightRecorder::default();
        flight.open();
        let mut ring = FlightRing::new(&flight);
        turns(&mut ring, 0..50, 3);
        turns(&mut ring, 50..100, 60);
        assert_eq!(flight.lost(), 1);
        assert_eq!(
            flight.take(NOW, |turns| turns.len()),
            Some(3 + AFTER + 1),
            "the first one, from a short run"
        );
        // What is owed at the end of a run comes too.
        turns(&mut ring, 100..110, 105);
        assert!(flight.take(NOW, |_| ()).is_none());
        ring.close();
        assert_eq!(flight.take(NOW, |turns| turns.last().copied()), Some(Some(109)));
    }
}
