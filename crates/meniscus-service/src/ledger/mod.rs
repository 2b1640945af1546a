//! Ledger of frames: each frame that the camera took in a run ends in exactly one account.
//!
//! | account | the frame |
//! |---|---|
//! | in time | had a turn that ended within a frame interval of its due time |
//! | late | had its turn later than that, or came after its turn had been taken |
//! | lost | never came as a pair of whole images: lost on the wire, or without a partner |
//! | never handled | was due while the host stood still, or dropped because no buffer was spare |
//!
//! A frame is due when it can first arrive: its camera time on the [clock map](crate::clock_map), so that a payload that
//! waited for a host that stood still is late although its turn was short. The frames between two that came are known from
//! the camera's frame counter, and from its time where it sends no counter or one that contradicts its time. The run's
//! span begins with the first pair of images, and its first frames are judged again as the map learns. Memory is fixed;
//! instants are arguments.

mod counts;
mod first_frames;
mod standstills;

pub use counts::FrameCounts;

use crate::clock_map::STEP_S;
use first_frames::{FirstFrames, Judged};
use meniscus::runtime::DEADLINE_US;
use meniscus::units::{FRAME_INTERVAL_S, Micros};
use standstills::Standstills;

/// Time from due to the end of the turn up to which a frame is in time, s.
const DEADLINE_S: f64 = 1e-6 * DEADLINE_US as f64;

/// Payloads of a frame: one of each stream.
const PAYLOADS: u64 = 2;

/// Counters of everything that was set aside before it had a turn, since the start of the run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SetAside {
    /// Frames that came after their turn had been taken.
    pub stale: u64,
    /// Payloads that were dropped because no buffer was spare.
    pub payloads_dropped: u64,
}

/// A frame that had its turn. Instants are seconds on the host's clock, since the clock map was made.
#[derive(Clone, Copy, Debug)]
pub struct HandledFrame {
    /// The camera's frame number; `None` where the camera sends none.
    pub number: Option<u32>,
    /// Its time on the camera's clock.
    pub captured: Micros,
    /// Earliest instant at which it can have arrived.
    pub due_s: f64,
    /// Whether the camera runs by its own clock. Otherwise it sends a frame when one is wanted, which is due as it arrives.
    pub by_clock: bool,
    /// Arrival of its last payload.
    pub arrived_s: f64,
    /// End of its turn.
    pub ended_s: f64,
    /// Restarts of the camera's clock so far.
    pub clock_restarts: u64,
    /// Everything that was set aside so far.
    pub set_aside: SetAside,
}

/// End of what the camera is known to have taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpanEnd {
    /// With the last frame that it handed over or that was dropped.
    LastFrame,
    /// It takes frames for as long as the run lasts, whether anybody reads them or not.
    RunsOn,
}

/// The accounts of a run and the memory that is needed to go on.
#[derive(Clone, Copy, Debug, Default)]
pub struct FrameLedger {
    counts: FrameCounts,
    last: Option<HandledFrame>,
    standstills: Standstills,
    first: FirstFrames,
    /// Late frames that are in time if the camera's clock turns out to have restarted.
    suspects: u64,
}

impl FrameLedger {
    /// Notes that the host did nothing from `begin_s` to `end_s`.
    pub fn stood_still(&mut self, begin_s: f64, end_s: f64) {
        self.standstills.add(begin_s, end_s);
    }

    /// Returns whether a frame follows the last one by number and time alike.
    #[must_use]
    pub fn is_next(&self, number: u32, captured: Micros) -> bool {
        self.last.as_ref().is_some_and(|last| {
            let passed_s = 1e-6 * captured.since(last.captured) as f64;
            let steps = last.number.map(|last| number.wrapping_sub(last));
            captured > last.captured && steps == Some((passed_s / FRAME_INTERVAL_S).round() as u32)
        })
    }

    /// Takes a frame and the frames that are missing before it.
    pub fn handle(&mut self, frame: &HandledFrame) {
        if let Some(last) = &self.last {
            let restarted = frame.clock_restarts != last.clock_restarts;
            if !restarted && frame.captured <= last.captured {
                // The same frame again: it has its account.
                return;
            }
            let (missing, passed_s) = between(last, frame, restarted);
            book_missing(&mut self.counts, &self.standstills, last, missing, frame.set_aside);
            self.counts.over_s += passed_s;
            if restarted {
                // They were behind a clock that no longer ran.
                self.counts.late -= self.suspects;
                self.counts.in_time += self.suspects;
                self.suspects = 0;
            }
        } else {
            self.counts.over_s = FRAME_INTERVAL_S;
        }
        self.judge(frame);
        self.last = Some(*frame);
    }

    /// Returns the accounts as they are after the last frame.
    #[must_use]
    pub fn counts(&self) -> FrameCounts {
        self.counts
    }

    /// Returns the accounts at `now_s`, with the frames since the last one that came. A frame whose deadline has not passed
    /// yet has no account.
    #[must_use]
    pub fn counts_at(&self, now_s: f64, set_aside: SetAside, end: SpanEnd) -> FrameCounts {
        let mut counts = self.counts;
        let Some(last) = &self.last else { return counts };
        let missing = match end {
            SpanEnd::RunsOn => ((now_s - DEADLINE_S - last.due_s) / FRAME_INTERVAL_S).max(0.0) as u64,
            SpanEnd::LastFrame => {
                let dropped = set_aside.payloads_dropped.saturating_sub(last.set_aside.payloads_dropped);
                dropped.div_ceil(PAYLOADS) + set_aside.stale.saturating_sub(last.set_aside.stale)
            }
        };
        book_missing(&mut counts, &self.standstills, last, missing, set_aside);
        counts.over_s += missing as f64 * FRAME_INTERVAL_S;
        counts
    }

    /// Books a frame that had its turn.
    fn judge(&mut self, frame: &HandledFrame) {
        let in_time = |since_s: f64| frame.ended_s - since_s <= DEADLINE_S;
        if in_time(frame.due_s) {
            self.counts.in_time += 1;
        } else {
            self.counts.late += 1;
        }
        if !frame.by_clock || frame.clock_restarts != 0 {
            self.first.close();
        }
        let camera_s = 1e-6 * frame.captured.0 as f64;
        let judged = Judged { ended_s: frame.ended_s - camera_s, due_s: frame.due_s - camera_s };
        let found = self.first.take(judged);
        self.counts.in_time -= found;
        self.counts.late += found;
        // The clock map needs some frames to tell a restarted clock from a host that is behind.
        if frame.arrived_s - frame.due_s <= STEP_S {
            self.suspects = 0;
        } else if in_time(frame.arrived_s) {
            self.suspects += 1;
        }
    }
}

/// Returns the number of frames that the camera took between two, and the time from one to the other, s.
fn between(last: &HandledFrame, frame: &HandledFrame, restarted: bool) -> (u64, f64) {
    // Over a restart of the camera's clock the host's clock alone knows how long it was away.
    let passed_s = if restarted {
        (frame.due_s - last.due_s).max(FRAME_INTERVAL_S)
    } else {
        1e-6 * frame.captured.since(last.captured) as f64
    };
    let by_time = (passed_s / FRAME_INTERVAL_S).round().max(1.0) as u64;
    let by_number = last.number.zip(frame.number).map(|(last, number)| u64::from(number.wrapping_sub(last)));
    // A counter that repeats, goes back or runs ahead of time says nothing; one that is behind it is that of a slower camera.
    let steps = by_number.filter(|steps| !restarted && (1..=by_time).contains(steps)).unwrap_or(by_time);
    (steps - 1, passed_s)
}

/// Books `missing` frames after `last`.
fn book_missing(
    counts: &mut FrameCounts,
    standstills: &Standstills,
    last: &HandledFrame,
    missing: u64,
    now: SetAside,
) {
    let stale = now.stale.saturating_sub(last.set_aside.stale).min(missing);
    let unseen = missing - stale;
    let never_handled = if now.payloads_dropped > last.set_aside.payloads_dropped {
        unseen
    } else {
        standstills.due_within(last.due_s, missing).min(unseen)
    };
    counts.late += stale;
    counts.never_handled += never_handled;
    counts.lost += unseen - never_handled;
}

#[cfg(test)]
mod tests;
