//! The worker: one thread that turns payloads into turns, and the log of what it did.

mod flight_recorder;
mod log;
mod worker;

pub use flight_recorder::{Flight, KEPT};
pub use log::{Log, Logged};
pub use worker::{Outlets, Still, Watch, watch};
