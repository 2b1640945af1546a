//! The 60 Hz turn: observe, predict, correct, decode, inside a budget, in a mode that says what the
//! estimate is worth.

mod budget;
mod estimator;
mod forecast;
pub mod health;
mod lagged_stress;
mod memory;
mod mode;
mod motion;
pub mod output;
mod profile_sensor;
mod tracker;

pub use budget::{Clock, DEADLINE_US, Stages};
pub use estimator::{Drive, Estimate, Estimator, POINTS_NEEDED};
pub use forecast::{Crest, Forecast};
pub use lagged_stress::sigma_before;
pub use memory::Memory;
pub use mode::{COAST_LIMIT, Mode};
pub use motion::Motion;
pub use profile_sensor::{Eye, Sight};
pub use tracker::{Tracker, Turn};
