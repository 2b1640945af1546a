//! Where payloads go, and what the session tells beside them.

use super::recovery::{Rung, Trouble};
use crate::buffer::Buffer;
use crate::link::CameraEnd;
use meniscus::usb::d4xx::DeviceError;
use meniscus::usb::uvc::Stream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Something that happened to the camera.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Note {
    /// Trouble, and the rung that is taken.
    Trouble(Trouble, Rung),
    /// A try to bring the camera back failed, with the reason.
    Failed(String),
    /// The camera reported an error of its own and goes on.
    Reported(DeviceError),
    /// Something that a person should know while frames come.
    Remark(String),
    /// Frames have come on every stream for a second, and some of one instant.
    Recovered,
}

impl Note {
    /// Returns the level of the note in a log.
    fn level(&self) -> log::Level {
        match self {
            Self::Trouble(..) | Self::Reported(_) | Self::Remark(_) => log::Level::Warn,
            Self::Failed(_) | Self::Recovered => log::Level::Info,
        }
    }
}

impl std::fmt::Display for Note {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Trouble(trouble, rung) => write!(f, "{trouble}: {rung:?}"),
            Self::Reported(error) => write!(f, "{} (error {} of the camera)", error.meaning(), error.0),
            Self::Failed(reason) => write!(f, "not yet: {reason}"),
            Self::Remark(what) => f.write_str(what),
            Self::Recovered => write!(f, "the camera is back"),
        }
    }
}

/// Notes of a session, shared with whoever shows them.
#[derive(Debug, Default)]
pub struct NoteBook {
    notes: Mutex<Vec<Note>>,
}

impl NoteBook {
    /// Notes that are kept; later ones are dropped.
    pub const ROOM: usize = 256;

    /// Adds a note.
    pub fn add(&self, note: Note) {
        log::log!(note.level(), "{note}");
        let mut notes = self.notes.lock().unwrap_or_else(PoisonError::into_inner);
        if notes.len() < Self::ROOM {
            notes.push(note);
        }
    }

    /// Returns the notes after the first `known`.
    #[must_use]
    pub fn after(&self, known: usize) -> Vec<Note> {
        let notes = self.notes.lock().unwrap_or_else(PoisonError::into_inner);
        notes.get(known..).unwrap_or_default().to_vec()
    }

    /// Returns the last note that still holds: none once the camera is back.
    #[must_use]
    pub fn standing(&self) -> Option<Note> {
        let notes = self.notes.lock().unwrap_or_else(PoisonError::into_inner);
        notes.last().filter(|note| **note != Note::Recovered).cloned()
    }
}

/// Takes payloads.
pub trait Sink {
    /// Whether more is wanted.
    fn wanted(&mut self) -> bool;
    /// A buffer to queue in the place of the one that is about to be delivered.
    fn spare(&mut self) -> Option<Buffer>;
    /// Takes a payload; `false` ends the session.
    fn deliver(&mut self, stream: Stream, payload: Buffer) -> bool;
    /// A payload was dropped, because there was no spare buffer.
    fn dropped(&mut self);
    /// Takes a note.
    fn note(&mut self, note: Note);
}

/// The worker's link as a sink.
#[derive(Debug)]
pub struct LinkSink<'a> {
    /// The camera's end.
    pub end: CameraEnd,
    /// Ends the session when it is set.
    pub stop: &'a AtomicBool,
    /// When the run is over.
    pub until: Instant,
    /// Receives the events.
    pub notes: &'a NoteBook,
}

impl Sink for LinkSink<'_> {
    fn wanted(&mut self) -> bool {
        !self.stop.load(Ordering::Relaxed) && Instant::now() < self.until
    }

    fn spare(&mut self) -> Option<Buffer> {
        self.end.spare()
    }

    fn deliver(&mut self, stream: Stream, payload: Buffer) -> bool {
        self.end.hand_over(stream, payload)
    }

    fn dropped(&mut self) {
        self.end.drop_one();
    }

    fn note(&mut self, note: Note) {
        self.notes.add(note);
    }
}
