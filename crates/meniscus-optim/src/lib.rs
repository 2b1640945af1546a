//! Optimisation that every training of the workspace shares: weights, layers, Adam, checkpoints, seeds, laws.
//!
//! ```text
//! Session (bars, stop flag, checkpoint folder)
//!    '--> Descent::new --> step: leaves --nets--> loss --Adam--> weights --look--> best so far, curve, checkpoint --> Descent::end
//! ```
//! [`descent::Descent`] is the entry point: it holds one optimisation from its first step to its last and goes on from a
//! checkpoint after a break. [`progress::Session`] is shared by all stages of a run. Networks are functions of a slice of
//! burn tensors ([`nets`]); their weights live on the host between two steps ([`weights`]). [`laws`] measures how well a
//! step keeps energy and entropy.

pub mod descent;
pub mod laws;
pub mod nets;
pub mod progress;
pub mod seed;
pub mod weights;
