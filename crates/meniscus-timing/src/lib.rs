//! Timing of the running estimator: speed against named peers, deadlines beside loads, and viewers of the live page.

pub mod bench;
pub mod deadline;
pub mod viewers;
