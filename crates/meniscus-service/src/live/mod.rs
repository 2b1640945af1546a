//! The worker: one thread that turns payloads into turns, and the sinks that keep them.

mod crest_image;
mod flight_recorder;
mod log;
mod silence;
mod totals;
mod turns;
mod worker;

pub use crest_image::CrestImage;
pub use flight_recorder::{FlightRecorder, FlightRing, KEPT};
pub use log::Log;
pub use silence::Silence;
pub use totals::{RunTotals, STAGES, Stage};
pub use worker::{CameraImages, Worker};
