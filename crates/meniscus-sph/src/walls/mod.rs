//! Walls of the glass.
//!
//! | file | content |
//! |---|---|
//! | `images` | mirror images of the liquid behind the walls: pressure, continuity, friction |
//! | `origin` | an image's original, and the walls that mirror it |
//! | `sticking` | velocities behind a wall to which the liquid sticks |
//! | `slip` | the share by which the liquid sticks to a wall of a given slip length |
//! | `hold` | a stop for particles that come too near |

mod hold;
mod images;
mod origin;
mod slip;
mod sticking;

pub(crate) use hold::hold;
pub(crate) use images::{Map, Walls};
pub(crate) use sticking::Sticking;
