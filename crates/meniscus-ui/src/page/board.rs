//! The newest frame and image, for every viewer; whoever comes late finds the newest and none of the old.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};
use tungstenite::Bytes;

/// Bytes with the number of their turn; numbers rise.
pub(super) type Numbered = (u32, Bytes);

/// State shared by the page's threads.
#[derive(Debug, Default)]
pub(super) struct Board {
    shown: Mutex<Shown>,
    newer: Condvar,
    /// The page closes.
    pub(super) ended: AtomicBool,
    /// Those who look right now.
    pub(super) viewers: AtomicUsize,
    /// Those of them who look at the depth image.
    pub(super) depth_viewers: AtomicUsize,
    /// Counts of frames and viewers.
    pub(super) counters: Counters,
}

/// Counts of frames, requests and viewers.
#[derive(Debug, Default)]
pub struct Counters {
    /// Frames sent, to each viewer.
    pub sent: AtomicU64,
    /// Frames that a viewer had no room for: newer ones were sent instead.
    pub left_out: AtomicU64,
    /// Bytes of all messages sent.
    pub bytes: AtomicU64,
    /// Requests that were refused.
    pub refused: AtomicU64,
    /// Viewers that came, in all.
    pub came: AtomicU64,
}

#[derive(Debug, Default)]
struct Shown {
    frame: Numbered,
    /// Of the outline, of the depth.
    images: [Numbered; 2],
    /// Last note of the camera, with its number from 1.
    note: (u32, String),
}

impl Board {
    /// Puts a frame up, and the images that are new: of the outline, of the depth.
    pub(super) fn put(&self, frame: Numbered, images: [Option<Numbered>; 2]) {
        let mut shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        shown.frame = frame;
        for (shown, image) in shown.images.iter_mut().zip(images) {
            if let Some(image) = image {
                *shown = image;
            }
        }
        drop(shown);
        self.newer.notify_all();
    }

    /// Frame and images, as soon as the frame is newer than `than` and `due` has come; `None` when nothing newer
    /// came within `patience` of that, or the page has closed.
    pub(super) fn newer(
        &self,
        than: u32,
        due: Instant,
        patience: Duration,
    ) -> Option<(Numbered, [Numbered; 2])> {
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        let shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        let wait = |shown: &mut Shown| shown.frame.0 <= than && !self.closing();
        let (shown, _) =
            self.newer.wait_timeout_while(shown, patience, wait).unwrap_or_else(PoisonError::into_inner);
        (shown.frame.0 > than && !self.closing()).then(|| (shown.frame.clone(), shown.images.clone()))
    }

    /// Puts up what the camera reported.
    pub(super) fn tell(&self, note: &str) {
        let mut shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        shown.note = (shown.note.0 + 1, note.to_owned());
    }

    /// Last note of the camera with its number, if that is higher than `than`.
    pub(super) fn note_after(&self, than: u32) -> Option<(u32, String)> {
        let shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        (shown.note.0 > than).then(|| shown.note.clone())
    }

    /// Number of the newest frame.
    pub(super) fn number(&self) -> u32 {
        self.shown.lock().unwrap_or_else(PoisonError::into_inner).frame.0
    }

    /// Whether the page closes.
    pub(super) fn closing(&self) -> bool {
        self.ended.load(Ordering::Acquire)
    }

    /// Closes it for everybody.
    pub(super) fn close(&self) {
        self.ended.store(true, Ordering::Release);
        self.newer.notify_all();
    }
}
