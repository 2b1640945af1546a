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
    /// Set with it: the depth image is wanted too.
    pub depth_wanted: bool,
    /// The left infrared image, Y8, and the turn that it belongs to.
    pub infrared: Vec<u8>,
    /// The depth image of the same turn, Z16 little-endian; empty where nobody wanted it.
    pub depth: Vec<u8>,
    /// The image's turn; `None` until there is one.
    pub image_of: Option<TimedTurn>,
}

/// Images that a viewer takes along: that of the outline every tenth of a second, that of the depth where it is wanted.
#[derive(Clone, Copy, Debug)]
pub struct ImageSchedule {
    due: Instant,
    /// The depth image is wanted with the next one.
    depth: bool,
}

impl Default for ImageSchedule {
    fn default() -> Self {
        Self { due: Instant::now(), depth: false }
    }
}

impl TurnSnapshot {
    /// Returns a copy. The images, which are the large part, are copied once: they are new if `image_of` is set.
    fn copy(&self) -> Self {
        let of = |image: &[u8], wanted: bool| if wanted { image.to_vec() } else { Vec::new() };
        let new = self.image_of.is_some();
        Self {
            logged: self.logged,
            memory: self.memory.clone(),
            image_wanted: false,
            depth_wanted: false,
            infrared: of(&self.infrared, new),
            depth: of(&self.depth, new && self.depth_wanted),
            image_of: self.image_of,
        }
    }
}

impl ImageSchedule {
    /// Wants the depth image with the next one, or not.
    pub fn want_depth(&mut self, wanted: bool) {
        self.depth = wanted;
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
        let (infrared, depth) = (vec![0; pixels], vec![0; 2 * pixels]);
        let snapshot = TurnSnapshot { infrared, depth, ..TurnSnapshot::default() };
        Self { handoff: Arc::new(Handoff::new(snapshot)) }
    }

    /// Requests the newest turn, for the one thread that shows it, and waits [`PATIENCE`] at most. Images come
    /// with it as `images` wants them.
    pub fn take(&self, images: &mut ImageSchedule) -> Option<(TurnSnapshot, TimedTurn)> {
        self.handoff.ask();
        if !self.handoff.wait(PATIENCE) {
            return None;
        }
        let snapshot = self.handoff.with(|snapshot| {
            let taken = snapshot.copy();
            snapshot.image_of = None;
            if Instant::now() >= images.due {
                images.due = Instant::now() + IMAGE_EVERY;
                (snapshot.image_wanted, snapshot.depth_wanted) = (true, images.depth);
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
        let Some(StateAfter { memory, outline, depth }) = record.after else { return };
        self.handoff.offer(|snapshot| {
            snapshot.logged = Some(*logged);
            snapshot.memory.clone_from(memory);
            let whole = logged.turn.stamp.is_some() && snapshot.infrared.len() == outline.len();
            if snapshot.image_wanted && whole {
                snapshot.infrared.copy_from_slice(outline);
                // A depth image of another size is of another lens, and is not shown.
                snapshot.depth_wanted &= snapshot.depth.len() == depth.len();
                if snapshot.depth_wanted {
                    snapshot.depth.copy_from_slice(depth);
                }
                snapshot.image_of = Some(*logged);
                snapshot.image_wanted = false;
            }
        });
    }
}
