//! A live D435: found, opened, checked, calibrated, negotiated, streamed, and brought back when it fails.
//!
//! ```text
//! find -> open -> speed -> descriptors (plan) -> identity, calibration (establish) -> probe, commit
//!      -> clear-halt, queue 4 transfers a stream -> payloads to the Sink, a spare buffer queued first
//!                 ^------------------ recovery: the ladder -----------------'
//! ```
//!
//! # The ladder
//!
//! Trouble is: no whole new frame on a stream for ten intervals, a halted endpoint, three damaged
//! transfers in a row, a pushed start error, a transfer that cannot be queued, a device that is gone, or streams that both bring
//! frames but for two seconds none of one instant.
//! A rung that fails, or after which no frame comes in its time, leads to the next one; the last repeats
//! with a longer pause each time. A second of frames on every stream, some of one instant, ends the climb. After
//! [`Settings::patience`] without such a second the session gives up and says what the last try met.
//!
//! | rung | what is done | longest, s | frames must come within, s | entered first for |
//! |---|---|---|---|---|
//! | 1 requeue | cancel, drain, clear-halt, queue again | 0.5 | 0.5 | silence, halt, damage |
//! | 2 renegotiate | the same with probe and commit | 9 | 1.5 | pushed start errors |
//! | 3 restart | HWRST, wait until it is gone and back, open | 13 + opening | 2 | |
//! | 4 reset | reset of the port, open | 2 + opening | 2 | |
//! | 5 re-plug | close, pause 0.1 to 2 s or until it is back, open by serial number | 2 + opening | 2 | a device that is gone |
//!
//! Nothing is asked of the camera while it streams. Payloads that come back from a cancelled queue are
//! not handed on, and a frame that repeats an earlier time is no sign of life.
//!
//! **Nothing here has met a physical camera.** Not known on hardware: whether clear-halt alone restarts
//! a stalled stream, how long HWRST takes (librealsense's users report about 6 s; 10 s are allowed), the
//! interrupt endpoint's address, the headers on USB 2. `meniscus dump` writes these down.

mod climb;
mod climb_report;
mod connect;
mod dump;
mod error;
mod health;
mod monitor;
mod negotiate;
mod partners;
mod plan;
mod pulse;
mod recovery;
mod session;
mod settings;
mod sink;

pub use climb_report::ClimbReport;
pub use connect::Connected;
pub use dump::{Dump, DumpedControl, DumpedFrame, dump};
pub use error::CameraError;
pub use health::CameraHealth;
pub use plan::{ColourPlan, Plan, StreamPlan};
pub use recovery::{Ladder, Rung, Step, Trouble};
pub use session::Session;
pub use settings::{OutlineImage, Settings};
pub use sink::{LinkSink, Note, NoteBook, Sink};
