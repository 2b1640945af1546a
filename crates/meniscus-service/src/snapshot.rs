//! Snapshots of turns for viewers (the live page, Foxglove): the newest wins, and no viewer is waited for.

use crate::sink::{StateAfter, TurnRecord, TurnSink};
use crate::timed_turn::TimedTurn;
use meniscus::runtime::Memory;
use meniscus_platform::handoff::Handoff;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time that a viewer waits for a turn before it checks whether the run has ended.
pub const PATIENCE: Duration = Duration::from_millis(100);

/// Time between two images.
const IMAGE_EVERY: Duration = Duration::from_millis(100);

/// One turn with everything that viewers show of it.
#[derive(Clone, Debug, Default)]
pub struct TurnSnapshot {
    /// The turn.
    pub logged: Option<TimedTurn>,
    /// Memory of the estimator after the turn: a forecast starts there.
    pub memory: Memory,
    /// Set by whoever shows it: the next frame's image is wanted.
    pub image_wanted: bool,
    /// The left infrared image, Y8, and the turn that it belongs to.
    pub infrared: Vec<u8>,
    /// The image's turn; `None` until there is one.
    pub image_of: Option<TimedTurn>,
}

impl TurnSnapshot {
    /// Returns a copy. The image, which is the large part, is copied once: it is new if `image_of` is set.
    fn copy(&self) -> Self {
        let infrared = if self.image_of.is_some() { self.infrared.clone() } else { Vec::new() };
        Self {
            logged: self.logged,
            memory: self.memory.clone(),
            image_wanted: false,
            infrared,
            image_of: self.image_of,
        }
    }
}

/// The worker's end; a clone is an end of the same hand-off.
#[derive(Clone, Debug)]
pub struct SnapshotOutlet {
    handoff: Arc<Handoff<TurnSnapshot>>,
}

impl SnapshotOutlet {
    /// An outlet for images of `pixels` pixels.
    pub fn new(pixels: usize) -> Self {
        let snapshot = TurnSnapshot { infrared: vec![0; pixels], ..TurnSnapshot::default() };
        Self { handoff: Arc::new(Handoff::new(snapshot)) }
    }

    /// Requests the newest turn, for the one thread that shows it, and waits [`PATIENCE`] at most. An image comes
    /// with it every tenth of a second; `image_due` is the time of the next one.
    pub fn take(&self, image_due: &mut Instant) -> Option<(TurnSnapshot, TimedTurn)> {
        self.handoff.ask();
        if !self.handoff.wait(PATIENCE) {
            return None;
        }
        let snapshot = self.handoff.with(|snapshot| {
            let taken = snapshot.copy();
            snapshot.image_of = None;
            if Instant::now() >= *image_due {
                *image_due = Instant::now() + IMAGE_EVERY;
                snapshot.image_wanted = true;
            }
            taken
        });
        let logged = snapshot.logged?;
        Some((snapshot, logged))
    }
}

impl TurnSink for SnapshotOutlet {
    /// Copies the turn only if a viewer has requested one.
    fn accept(&mut self, record: &TurnRecord<'_>) {
        let logged = record.logged;
        // A snapshot needs the memory of its turn; the newest turn of the same payload has it and comes next.
        let Some(StateAfter { memory, outline }) = record.after else { return };
        self.handoff.offer(|snapshot| {
            snapshot.logged = Some(*logged);
            snapshot.memory.clone_from(memory);
            let whole = logged.turn.stamp.is_some() && snapshot.infrared.len() == outline.len();
            if snapshot.image_wanted && whole {
                snapshot.infrared.copy_from_slice(outline);
                snapshot.image_of = Some(*logged);
                snapshot.image_wanted = false;
            }
        });
    }
}
