//! How far an estimate may be off: error model with its intervals, model discrepancy, and the cross-axis mode.

pub mod cross_axis;
pub mod discrepancy;
pub mod error_model;
