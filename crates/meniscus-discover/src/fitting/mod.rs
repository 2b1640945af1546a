//! Fits of baseline and effects to recordings, by least squares on whitened residuals.

mod covariance;
pub mod error;
pub mod fit;
pub mod fit_cache;
mod group_fit;
pub mod localise;
pub mod problem;
pub mod rest_offset;
pub mod search;
