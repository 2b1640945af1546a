//! Integration in time: the step, the settling before time starts, and the books of energy.

mod energy;
mod settle;
mod stages;
mod step;

pub use energy::{closure, relative_closure};
pub(crate) use stages::{MOST, Stages, reach};
