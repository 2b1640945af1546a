//! Errors of a run against the recording that it watched, the baselines beside them, and a film of both.

pub mod baseline;
pub mod film;
pub mod score;
