//! What the worker hands over to those who show a run (the live page, Foxglove): the newest wins, and nobody is waited for.

use crate::live::Logged;
use meniscus::runtime::{DEADLINE_US, Memory};
use meniscus_platform::handoff::Handoff;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// How long whoever shows a run waits for a turn before it looks whether the run has ended.
pub const PATIENCE: Duration = Duration::from_millis(100);

/// Time between two images.
const IMAGE_EVERY: Duration = Duration::from_millis(100);

/// One turn with all that is shown of it.
#[derive(Clone, Debug, Default)]
pub struct Look {
    /// The turn.
    pub logged: Option<Logged>,
    /// What the estimator remembers after it: a forecast starts there.
    pub memory: Memory,
    /// Turns so far that ended more than a frame interval after their last payload's arrival.
    pub late: u64,
    /// Set by whoever shows it: the next frame's image is wanted.
    pub image_wanted: bool,
    /// The left infrared image, Y8, and the turn that it belongs to.
    pub infrared: Vec<u8>,
    /// The image's turn; `None` until there is one.
    pub image_of: Option<Logged>,
}

impl Look {
    /// A copy, with the image only if that is `new`.
    fn copy(&self, new: bool) -> Self {
        let infrared = if new { self.infrared.clone() } else { Vec::new() };
        let image_of = self.image_of.filter(|_| new);
        Self {
            logged: self.logged,
            memory: self.memory.clone(),
            late: self.late,
            image_wanted: false,
            infrared,
            image_of,
        }
    }
}

/// The worker's end.
#[derive(Clone, Debug)]
pub struct Outlet {
    handoff: Arc<Handoff<Look>>,
    late: Arc<AtomicU64>,
}

impl Outlet {
    /// An outlet for images of `pixels` pixels.
    pub fn new(pixels: usize) -> Self {
        let look = Look { infrared: vec![0; pixels], ..Look::default() };
        Self { handoff: Arc::new(Handoff::new(look)), late: Arc::default() }
    }

    /// The newest turn, for the one thread that shows it: asked for, and waited for [`PATIENCE`] at most. An image comes
    /// with it every tenth of a second; `image_due` is when the next one does.
    pub fn take(&self, image_due: &mut Instant) -> Option<(Look, Logged)> {
        self.handoff.ask();
        if !self.handoff.wait(PATIENCE) {
            return None;
        }
        let look = self.handoff.with(|look| {
            let taken = look.copy(look.image_of.is_some());
            look.image_of = None;
            if Instant::now() >= *image_due {
                *image_due = Instant::now() + IMAGE_EVERY;
                look.image_wanted = true;
            }
            taken
        });
        let logged = look.logged?;
        Some((look, logged))
    }

    /// Hands a turn on, after its end: the copy is made only if somebody has asked for one, and nothing of it waits
    /// or allocates. `infrared` is the last whole image.
    pub fn offer(&self, logged: &Logged, memory: &Memory, infrared: &[u8]) {
        let missed = u64::from(logged.latency_us > DEADLINE_US);
        let late = self.late.fetch_add(missed, Ordering::Relaxed) + missed;
        self.handoff.offer(|look| {
            look.logged = Some(*logged);
            look.memory.clone_from(memory);
            look.late = late;
            let whole = logged.turn.stamp.is_some() && look.infrared.len() == infrared.len();
            if look.image_wanted && whole {
                look.infrared.copy_from_slice(infrared);
                look.image_of = Some(*logged);
                look.image_wanted = false;
            }
        });
    }
}
