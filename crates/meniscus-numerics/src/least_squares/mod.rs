//! Nonlinear least squares by damped Gauss-Newton steps.
//!
//! ```text
//! C(p) = |r(p)|^2  ->  least,      p within bounds
//! (A + lambda (diag A + s) + f) d = g,      A = J^T J,   g = J^T r,   p' = P(p - d)
//! lambda' = max(lambda / shrink, least)  where C(p') < C(p),  else min(lambda grow, most) and again
//! ```
//! (Levenberg, Q. Appl. Math. 2 (1944) 164; Marquardt, SIAM J. Appl. Math. 11 (1963) 431, whose scaling by diag A this is.)
//! `s` and `f` keep the matrix definite where a parameter does nothing; P moves a parameter that has left its bounds onto
//! the nearer one. It is a projection and no active set: where a bound is in the way of the step, the other parameters
//! approach their best values slowly.
//!
//! [`bounded`] is the exact active set for a quadratic. Two entries: [`minimise`] for residuals of which the solver may ask any number, and [`Damping::step`] for a caller that
//! gathers the normal equations itself, in parts, with weights or over several batches of data.

mod bounded;
mod damping;
mod differences;
mod solver;

pub use bounded::bounded;
pub use damping::{Damping, NormalEquations};
pub use differences::forward_differences;
pub use solver::{End, Model, Settings, Solution, Stop, minimise};
