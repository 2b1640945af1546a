//! Study of discovery: effects hidden in another simulator's data, clean glasses, measured water.

pub mod against_simulator;
pub mod bench;
pub mod cases;
pub mod caution;
pub mod checks;
pub mod coverage;
pub mod duration;
pub mod error;
mod final_verdict;
pub mod laboratory;
pub mod measured;
mod measured_runs;
pub mod motions;
pub mod page;
pub mod pictures;
pub mod plans;
pub mod run;
mod share;
pub mod simulate;
pub mod sizes;
pub mod synthetic;
pub mod tally;
pub mod trial;
pub mod truth;
pub mod unnamed;
