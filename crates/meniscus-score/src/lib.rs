//! Errors of a run against the recording that it watched, with baselines beside them, and a film of both.
//!
//! ```text
//! recording --camera, turns--> estimates --score--> Score (surface, field, coverage)
//!    '--------baseline--> flat surface, last frame, linear model with the true motion
//!    '--------film--> animated PNG of estimate and truth
//! ```
//! [`score::score`] is the entry point; [`baseline::linear_with_motion`] gives it the linear baseline.

pub mod baseline;
pub mod film;
pub mod score;
