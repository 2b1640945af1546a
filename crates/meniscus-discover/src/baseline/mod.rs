//! Baseline of a discovery: the reduced model without an effect, calibrated by references.
//!
//! Measured values less the baseline's prediction are the residuals in which an effect is sought. What references leave
//! of them belongs to the baseline itself.

pub mod calibrate;
pub mod clock;
pub mod group;
mod held_line;
pub mod noise;
pub mod offsets;
pub mod predict;
pub mod reference_residual;
mod trend;

#[cfg(test)]
mod viscous;
