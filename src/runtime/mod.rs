//! The 60 Hz turn: observe, predict, correct, decode, inside a budget, in a mode that says what the
//! estimate is worth.

mod budget;
mod estimator;
mod filter;
mod mode;
mod motion;

pub use budget::{Clock, DEADLINE_US, Stages};
pub use estimator::{Estimate, Estimator, Memory};
pub use mode::{COAST_LIMIT, Mode};
