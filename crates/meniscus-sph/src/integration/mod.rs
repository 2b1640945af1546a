//! Integration in time: the step, what spills, and the books of energy.

mod energy;
mod moves;
mod spill;
mod stages;
mod step;

pub use energy::{closure, relative_closure};
pub use spill::Spilled;
pub(crate) use stages::Stages;
