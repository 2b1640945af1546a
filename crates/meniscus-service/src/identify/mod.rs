//! Which liquid is it, beside a run and without a cost to the turn.
//!
//! ```text
//! worker --ProfileOutlet (never waits)--> queue of profiles --> a thread of its own: meniscus::identify --> Standing
//! ```
//! The turn hands on what it saw, 21 heights, and goes its way. The thread holds them against every known liquid; what
//! it had no time for is left out, counted, and to the liquids a frame that nobody saw.

mod feed;
mod note;
mod standing;

pub use feed::{ProfileFeed, ProfileOutlet, channel};
pub use note::{GlassSize, MOST, Note, NoteError, split};
pub use standing::Standing;
