//! Errors of a run against the recording that it watched, the baselines beside them, the report of a run, and a film.

pub mod baseline;
pub mod film;
pub mod run_picture;
pub mod run_report;
pub mod score;
