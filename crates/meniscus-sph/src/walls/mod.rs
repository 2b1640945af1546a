//! Walls of the glass: images of the liquid behind them, and slip along them.

mod images;
mod slip;

pub(crate) use images::{Walls, hold};
pub(crate) use slip::stick;
