//! From the worker to the thread that recognises.

use super::{MOST, Note, Standing, split};
use crate::sink::{TurnRecord, TurnSink};
use meniscus::identify::{Recogniser, Trail};
use meniscus::surface::SurfaceProfile;
use meniscus::units::Micros;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Profiles between worker and thread: two seconds.
const QUEUE: usize = 128;

/// Frame interval, microseconds.
const INTERVAL_US: u64 = 16_667;

/// Longest gap that is bridged frame by frame; behind it nothing is left of what was before.
const GAP: u64 = 61;

/// Turns between two looks at how things stand.
const LOOK: u32 = 10;

/// Time that the thread waits for a profile before it checks whether the run has ended.
const PATIENCE: Duration = Duration::from_millis(50);

/// Part of a turn that identification needs.
#[derive(Clone, Copy, Debug)]
struct TurnProfile {
    time: Micros,
    profile: Option<SurfaceProfile>,
}

/// The worker's end.
#[derive(Debug)]
pub struct ProfileOutlet {
    queue: SyncSender<TurnProfile>,
    left_out: Arc<AtomicU64>,
}

/// The thread's end.
#[derive(Debug)]
pub struct ProfileFeed {
    queue: Receiver<TurnProfile>,
    left_out: Arc<AtomicU64>,
}

/// Both ends.
#[must_use]
pub fn channel() -> (ProfileOutlet, ProfileFeed) {
    let (queue, seen) = sync_channel(QUEUE);
    let left_out = Arc::<AtomicU64>::default();
    (ProfileOutlet { queue, left_out: Arc::clone(&left_out) }, ProfileFeed { queue: seen, left_out })
}

impl TurnSink for ProfileOutlet {
    /// Queues the turn's profile: without room the turn is left out and counted.
    fn accept(&mut self, record: &TurnRecord<'_>) {
        let turn = &record.logged.turn;
        let profile = turn.profile.and_then(Result::ok);
        if self.queue.try_send(TurnProfile { time: turn.time, profile }).is_err() {
            self.left_out.fetch_add(1, Ordering::Relaxed);
        }
    }
}

impl ProfileFeed {
    /// Identifies the liquid until the run has `ended` and the queue is empty; `newest` gets the probabilities every few
    /// turns. Give it a thread of its own.
    pub fn attend(
        self,
        notes: &[Note],
        fill_m: f64,
        newest: &Mutex<Option<Standing>>,
        ended: &AtomicBool,
    ) -> Standing {
        let (names, known) = split(notes);
        let recogniser = Recogniser::new(&known, fill_m);
        let mut trail = Trail::<MOST>::default();
        let stand = |trail: &Trail<MOST>| {
            Standing::of(&names, &recogniser, trail, self.left_out.load(Ordering::Relaxed))
        };
        let (mut last, mut turns) = (None::<Micros>, 0_u32);
        loop {
            let over = ended.load(Ordering::Relaxed);
            let seen = match self.queue.recv_timeout(PATIENCE) {
                Ok(seen) => seen,
                Err(RecvTimeoutError::Timeout) if !over => continue,
                Err(_) => break,
            };
            for _ in 0..missing(last, seen.time) {
                recogniser.turn(&mut trail, None);
            }
            last = Some(seen.time);
            recogniser.turn(&mut trail, seen.profile.as_ref());
            turns += 1;
            if turns.is_multiple_of(LOOK) {
                let standing = stand(&trail);
                if let Ok(mut place) = newest.lock() {
                    *place = Some(standing);
                }
            }
        }
        stand(&trail)
    }
}

/// Frames without a turn between `last` and `now`.
fn missing(last: Option<Micros>, now: Micros) -> u64 {
    let Some(last) = last else { return 0 };
    let intervals = (now.since(last) + INTERVAL_US / 2) / INTERVAL_US;
    intervals.saturating_sub(1).min(GAP)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_counted_in_frames() {
        let at = |frames: u64| Micros(1_000_000 + 16_667 * frames + 40);
        assert_eq!(missing(None, at(5)), 0);
        assert_eq!(missing(Some(at(4)), at(5)), 0);
        assert_eq!(missing(Some(at(4)), at(8)), 3);
        assert_eq!(missing(Some(at(0)), at(100_000)), GAP);
        assert_eq!(missing(Some(at(8)), at(4)), 0, "a clock that went back");
    }
}
