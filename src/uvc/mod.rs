//! USB Video Class 1.5: payload bytes to whole frames, or a counted loss.
//!
//! ```text
//! payload --header--> Header + pixels --assembler--> Frame { pixels in place, Stamp } --pair--> depth and infrared of one instant
//!                        | metadata blocks              | continuity: FID, frame counter, PTS
//!                        '--> Timing                    '--> Losses, one counter a cause
//! ```
//!
//! A torn frame never leaves this module as a frame, and nothing is lost without a count.

mod assembler;
mod continuity;
mod header;
mod losses;
mod metadata;
mod pair;

pub use assembler::{Assembler, Frame, Outcome};
pub use header::{Header, HeaderError};
pub use losses::{Cause, Losses};
pub use metadata::{Block, Blocks, Timing};
pub use pair::{Pair, Pairer, Solitary, Stream};
