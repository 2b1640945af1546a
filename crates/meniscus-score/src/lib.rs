//! Errors of a run against the recording that it watched, with baselines beside them, the report of a run, and a film.
//!
//! ```text
//! recording --camera, turns--> estimates --score--> Score (surface, field, coverage)
//!    '--------baseline--> flat surface, last frame, linear model with the true motion
//!    '--------forecasts--> error 250 ms ahead, with the motion planned and without
//!    '--------film--> animated PNG of estimate and truth
//! ```
//! [`score::score`] is the entry point; [`baseline::linear_with_motion`] gives it the linear baseline.

pub mod baseline;
pub mod crests;
pub mod field_error;
#[cfg(feature = "pictures")]
pub mod film;
pub mod forecasts;
#[cfg(feature = "pictures")]
pub mod run_picture;
pub mod run_report;
pub mod score;
#[cfg(feature = "pictures")]
pub mod unknown_groups;
