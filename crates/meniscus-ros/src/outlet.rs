//! The worker's end: a pool of turns that go round, so that nothing waits and nothing allocates.
//!
//! ```text
//! worker --free.try_recv, fill, filled.try_send--> publisher's thread --free.send--> worker ...
//! ```

use crate::counters::{Counters, count};
use crate::parameters::LiveSettings;
use crate::rate::Rate;
use meniscus::runtime::Memory;
use meniscus_service::sink::{TurnRecord, TurnSink};
use meniscus_service::timed_turn::TimedTurn;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

/// Turns between worker and publisher: an eighth of a second.
const QUEUE: usize = 8;

/// A turn on its way to the publisher.
#[derive(Debug, Default)]
pub(crate) struct Outgoing {
    /// Turns before it in this run.
    pub(crate) number: u64,
    /// The turn; `None` before the first use.
    pub(crate) logged: Option<TimedTurn>,
    /// State behind it.
    pub(crate) memory: Memory,
    /// Whether `field` is of this turn, and due.
    pub(crate) has_field: bool,
    /// Full field.
    pub(crate) field: Vec<f32>,
}

/// Sink that hands turns to the node.
#[derive(Debug)]
pub struct TurnOutlet {
    free: Receiver<Box<Outgoing>>,
    filled: SyncSender<Box<Outgoing>>,
    number: u64,
    rate: Rate,
    live: Arc<LiveSettings>,
    counters: Arc<Counters>,
}

/// The publisher's end.
#[derive(Debug)]
pub(crate) struct TurnQueue {
    free: SyncSender<Box<Outgoing>>,
    filled: Receiver<Box<Outgoing>>,
}

/// Returns both ends for fields of `field_len` numbers; of 0, none is handed on.
pub(crate) fn turn_queue(
    field_len: usize,
    live: Arc<LiveSettings>,
    counters: Arc<Counters>,
) -> (TurnOutlet, TurnQueue) {
    let ((give, free), (filled, take)) = (sync_channel(QUEUE), sync_channel(QUEUE));
    for _ in 0..QUEUE {
        // The channel has room for all of them.
        let _sent = give.try_send(Box::new(Outgoing { field: vec![0.0; field_len], ..Outgoing::default() }));
    }
    let outlet = TurnOutlet { free, filled, number: 0, rate: Rate::default(), live, counters };
    (outlet, TurnQueue { free: give, filled: take })
}

impl TurnSink for TurnOutlet {
    /// Queues the turn; without room it is left out and counted. The field is copied only when a cloud is due.
    fn accept(&mut self, record: &TurnRecord<'_>) {
        let (logged, number) = (record.logged, self.number);
        // A turn that is left out keeps its number: the gap tells readers of it.
        self.number += 1;
        let Some(after) = record.after else { return count(&self.counters.overtaken) };
        let Ok(mut turn) = self.free.try_recv() else { return count(&self.counters.queue_full) };
        turn.number = number;
        turn.logged = Some(*logged);
        turn.memory.clone_from(after.memory);
        let fresh = logged.turn.estimate.field_fresh && !turn.field.is_empty();
        turn.has_field = fresh
            && record.field.len() == turn.field.len()
            && self.rate.due(logged.turn.time.0, self.live.tracers_hz());
        if turn.has_field {
            turn.field.copy_from_slice(record.field);
        }
        // There is room for as many turns as there are.
        if self.filled.try_send(turn).is_err() {
            count(&self.counters.queue_full);
        }
    }
}

impl TurnQueue {
    /// Returns the next turn; an error where none comes within `patience`, or the outlet is gone.
    pub(crate) fn take(&self, patience: Duration) -> Result<Box<Outgoing>, RecvTimeoutError> {
        self.filled.recv_timeout(patience)
    }

    /// Gives a turn back for the worker.
    pub(crate) fn give_back(&self, turn: Box<Outgoing>) {
        // A worker that has gone needs none.
        let _sent = self.free.try_send(turn);
    }
}

impl Counters {
    /// Returns the turns that were left out so far.
    pub(crate) fn left_out(&self) -> u64 {
        self.queue_full.load(Ordering::Relaxed) + self.overtaken.load(Ordering::Relaxed)
    }
}
