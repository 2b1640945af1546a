//! Uncertainty of an estimate: error model with its intervals, model discrepancy, and the cross-axis mode.
//!
//! | file | purpose |
//! |---|---|
//! | `error_model` | covariances of a blob |
//! | `intervals` | half-widths that follow from these and the filter's covariance |
//! | `error_factors` | conformal factors of the half-widths |
//! | `disagreement` | scale of the half-widths by what the camera sees |
//! | `discrepancy` | share of the decoder's misfit that measured heights put right |
//! | `latent_covariance` | error covariance of the reduced state as it leaves the estimator |
//! | `cross_axis` | first mode across the line along which the glass is moved |

pub mod cross_axis;
pub(crate) mod disagreement;
pub mod discrepancy;
pub mod error_factors;
pub mod error_model;
pub mod intervals;
pub mod latent_covariance;
