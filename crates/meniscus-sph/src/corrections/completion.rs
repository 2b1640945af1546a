//! Completion of a sum over neighbours at a free surface, where about half of them are missing.
//!
//! ```text
//! c_i = 3 / ( -sum_j V_j F r^2 )        1 in the bulk, about 2 at a free surface
//! ```
//! It serves sums over an even function of direction, such as friction; gradients need a matrix (see [`super::corrected`]).

/// The largest `c_i`: a lone drop has hardly a neighbour.
const LARGEST_C: f64 = 3.0;

/// `c_i` from `-sum_j V_j F r^2`.
pub(crate) fn completion(seen: f64) -> f64 {
    (3.0 / seen).clamp(0.0, LARGEST_C)
}
