//! Error of a least-squares problem.

use thiserror::Error;

/// Reason for which recordings cannot be fitted.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ProblemError {
    /// Too few numbers were measured.
    #[error("{recording}: only {numbers} numbers were measured, {least} are needed; give a longer recording")]
    TooFewNumbers {
        /// Recording.
        recording: String,
        /// Numbers that were measured.
        numbers: usize,
        /// Fewest numbers.
        least: usize,
    },
    /// A covariance is not positive definite.
    #[error(
        "{recording}: the covariance of its {channel} is not positive definite; look for values that are not finite in \
         it and in the references, and leave the recording out"
    )]
    Covariance {
        /// Recording.
        recording: String,
        /// Channel.
        channel: &'static str,
    },
}
