//! USB Video Class 1.5: payload bytes to whole frames, or a counted loss.
//!
//! ```text
//! payload --header--> PayloadHeader + pixels --assembler--> Frame { pixels in place, Stamp } --pair--> two images of one instant
//!                        | metadata blocks              | continuity: FID, frame counter, PTS
//!                        '--> Timing                    '--> Losses, one counter a cause
//! ```
//!
//! Before that stands the agreement on what is sent:
//!
//! ```text
//! configuration --descriptor--> interfaces --topology--> units; --format--> modes; --probe--> the agreed record
//! interrupt endpoint --status--> pushed errors
//! ```
//!
//! A torn frame never leaves this module as a frame, and nothing is lost without a count.

mod assembler;
pub(crate) mod bytes;
mod continuity;
pub mod descriptor;
mod device_clock;
pub mod format;
mod header;
mod losses;
mod metadata;
mod pair;
pub(crate) mod places;
mod probe;
pub mod request;
mod status;
mod timing;
mod topology;

pub use assembler::{Assembler, AssemblyOutcome, Frame};
pub use device_clock::DeviceClock;
pub use header::{HeaderError, PayloadHeader};
pub use losses::{Cause, Losses};
pub use metadata::{Block, Blocks};
pub use pair::{Pair, Pairer, Solitary, Stream};
pub use probe::{PROBE_MAX, Probe, ProbeError, probe_length};
pub use status::ControlChange;
pub use timing::Timing;
pub use topology::{Topology, extension_unit};
