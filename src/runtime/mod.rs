//! The 60 Hz turn: observe, predict, correct, decode, inside a budget, in a mode that says what the
//! estimate is worth.

mod budget;
mod estimator;
mod eye;
mod filter;
mod mode;
mod motion;
mod tracker;

pub use budget::{Clock, DEADLINE_US, Stages};
pub use estimator::{Estimate, Estimator, Memory};
pub use eye::{Eye, Sight};
pub use mode::{COAST_LIMIT, Mode};
pub use tracker::{Tracker, Turn};
