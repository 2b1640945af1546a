//! Numerical methods that simulator, training and discovery share.
//!
//! | module | for |
//! |---|---|
//! | [`least_squares`] | damped Gauss-Newton (Levenberg-Marquardt) with bounds |
//! | [`statistics`] | median, quantile, mean, variance, root mean square; quantiles of Student's t and of F |
//! | [`quadrature`] | Gauss-Legendre nodes and weights |
//! | [`random`] | normal draws from a seeded generator |
//!
//! Nothing here reads a clock, draws from the system or depends on another crate of the project. Equal arguments give
//! equal bits on one platform.

pub mod least_squares;
pub mod quadrature;
pub mod random;
pub mod statistics;
