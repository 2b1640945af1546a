//! The motion of the glass from an AprilTag of the family 36h11, on the glass or on the gripper that holds it.
//!
//! ```text
//! camera --payloads--> [tap: image -> TagFinder -> corners -> pose -> TagTracker] --the same payloads--> worker
//!                                                                     |
//!                                                                     '-> CameraInlet: stamped positions
//! ```
//! The tap has a thread of its own before the worker. The position in an image is there when the turn of that image begins.
//!
//! Detection is `locus-core`'s. The pose is computed here ([`pose`](pose()), with its formulae), because both solutions of a plane
//! target have to be judged. [`TagTracker`] decides which pose is accepted, and counts the others.

mod finder;
mod parts;
mod pose;
mod region;
mod rest;
mod tap;
mod tracker;

pub use finder::{FinderError, SeenTag, TagFinder};
pub use pose::{CORNER_STD_PX, PoseFault, TagPose, pose};
pub use rest::Rest;
pub use tap::{TagWatch, watch};
pub use tracker::{Sighting, TagTracker, Wanted};

/// Numbers of the family 36h11: 0 to one less than this.
pub const NUMBERS: u32 = 587;
