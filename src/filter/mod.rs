//! Kalman filter over the latents, the acceleration input, the glass and the cross-axis slosh.
//!
//! | file | purpose |
//! |---|---|
//! | `state` | layout of the state vector |
//! | `covariance` | error covariance, its step and its scalar update |
//! | `kalman` | state, prior, and the step of the filter |
//! | `measurements` | updates by the position of the glass, by heights and by the encoder |
//!
//! Its settings, [`FilterConfig`], come with the model: a blob carries those that it was tuned for.

mod covariance;
mod kalman;
mod measurements;
mod state;
#[cfg(test)]
mod tests;

pub use crate::blob::{FilterConfig, ScaleBounds};
pub(crate) use kalman::Filter;
pub use kalman::PORT_LIMIT;
pub(crate) use measurements::{Adaptation, Reading, Update, UpdateContext};
