//! Tools that all training shares: parameters as burn tensors, layers, Adam, checkpoints, seeds, and measures of the two laws.

pub mod descent;
pub mod laws;
pub mod nets;
pub mod progress;
pub mod seed;
pub mod weights;
