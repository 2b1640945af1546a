//! Identification of the liquid, offline: learning the first mode of a liquid, and how often the right one is identified.
//!
//! The path is that of a run: recording, rendered camera, profiles, [`meniscus::identify`]. Only the clock is missing.

mod calibrate;
mod fit;
mod picture;
mod study;

pub use calibrate::{LearnError, learn};
pub use fit::fit;
pub use picture::picture;
pub use study::{Case, IdentificationStudy, TestRecording, recognise, render_profiles, study};
