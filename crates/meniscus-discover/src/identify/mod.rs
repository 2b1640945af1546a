//! Which liquid is it, offline: the first mode of a liquid from recordings of it, and how often the right one is named.
//!
//! The way is that of a run: recording, rendered camera, profiles, [`meniscus::identify`]; only the clock is missing.

mod calibrate;
mod fit;
mod picture;
mod study;

pub use calibrate::{LearnError, learn};
pub use fit::fit;
pub use picture::picture;
pub use study::{Case, Study, Unseen, look, recognise, study};
