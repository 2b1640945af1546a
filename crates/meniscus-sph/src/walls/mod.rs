//! Walls of the glass.
//!
//! | file | content |
//! |---|---|
//! | `images` | mirror images of the liquid behind the walls: pressure, continuity, friction |
//! | `slip` | the share by which the liquid sticks to a wall of a given slip length |
//! | `hold` | a stop for particles that come too near |

mod hold;
mod images;
mod slip;

pub(crate) use hold::hold;
pub(crate) use images::{Map, Sticking, Walls};
