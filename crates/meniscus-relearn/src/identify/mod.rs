//! Identification of a liquid from recordings of its free surface.
//!
//! The reduced model is fitted to level, slope and bow of the profiles under the measured motion, with the viscosity as the
//! unknown. First its profile likelihood is followed over six decades, which needs no start value. Then flow index and yield stress
//! join it where the law has them ([`Law`]); the recordings do not choose the law. At last the simulator is fitted in its place.

mod by_simulation;
mod fit;
mod flow_curve;
mod identified;
mod law_by_simulation;
mod law_interval;
mod measured;
#[cfg(test)]
mod tests;
mod viscosity;
mod viscosity_by_simulation;

pub use crate::law::Law;
pub(crate) use by_simulation::{Simulating, by_simulation};
pub use fit::identify;
pub(crate) use fit::stated;
pub use identified::{BySimulation, FlowStress, Identified};
pub use measured::MeasuredRecording;
pub use viscosity::{Value, ViscosityFit, fit_viscosity};

/// Numerical kinematic viscosity of the simulator, m2/s (`meniscus simulate validate`). A liquid that is thinner moves in the
/// simulator as one of about this viscosity, away from the walls.
pub const NUMERICAL_VISCOSITY_M2_S: f64 = 2.6e-6;
