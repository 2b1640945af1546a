//! Kalman filter over the latents, the acceleration input and the position of the glass.

mod covariance;
mod kalman;

pub(crate) use kalman::Filter;
pub use kalman::PORT_LIMIT;
