//! Integration in time: the step, the settling before time starts, what spills, and the books of energy.

mod energy;
mod settle;
mod spill;
mod stages;
mod step;

pub use energy::{closure, relative_closure};
pub(crate) use settle::check_running;
pub use spill::Spilled;
pub(crate) use stages::Stages;
