//! The 60 Hz turn: observe, predict, correct, decode, inside a budget, in a mode that says what the
//! estimate is worth.

mod belief;
mod budget;
mod estimator;
mod eye;
mod filter;
mod forecast;
mod hindsight;
mod memory;
mod mode;
mod motion;
mod tracker;

pub use budget::{Clock, DEADLINE_US, Stages};
pub use estimator::{Drive, Estimate, Estimator, POINTS_NEEDED, PORT_LIMIT};
pub use eye::{Eye, Sight};
pub use forecast::{Crest, Forecast};
pub use hindsight::sigma_before;
pub use memory::Memory;
pub use mode::{COAST_LIMIT, Mode};
pub use motion::Motion;
pub use tracker::{Tracker, Turn};
