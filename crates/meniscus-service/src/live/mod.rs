//! The worker: one thread that turns payloads into turns, and the log of what it did.

mod flight;
mod log;
mod worker;

pub use flight::{Flight, KEPT};
pub use log::{Log, Logged};
pub use worker::{Outlets, Still, Watch, watch};
