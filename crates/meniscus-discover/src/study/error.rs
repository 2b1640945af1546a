//! Errors of the study.

use crate::fitting::error::ProblemError;
use crate::recordings::error::{LoadError, TableError};
use crate::workflow::error::DiscoverError;
use meniscus_platform::files::FileError;
use std::path::PathBuf;
use thiserror::Error;

/// Reason for which a part of the study cannot be done; what is judged so far stays.
#[derive(Debug, Error)]
pub enum StudyError {
    /// A discovery fails.
    #[error(transparent)]
    Discover(#[from] DiscoverError),
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A file cannot be read.
    #[error("{}: {cause}", .path.display())]
    Read {
        /// File.
        path: PathBuf,
        /// Error of the operating system.
        cause: std::io::Error,
    },
    /// The measured water lacks the runs of a question.
    #[error("{}: no run in it is called {}...; take the whole data set, or ask fewer questions", .folder.display(), .starts.join("..., "))]
    NoRuns {
        /// Folder of the runs.
        folder: PathBuf,
        /// Beginnings of the names of the runs.
        starts: Vec<String>,
    },
    /// A table of the measured water has a fault.
    #[error("{run}: {fault}")]
    Table {
        /// Run of the measurement.
        run: String,
        /// Fault.
        fault: TableError,
    },
    /// A glass cannot be simulated, or a trial cannot be written.
    #[error("{reason}")]
    Trial {
        /// Reason, in words.
        reason: String,
    },
    /// A result cannot be written as JSON.
    #[error("a result of the study cannot be written as JSON: {0}")]
    Json(serde_json::Error),
    /// The processors' pools cannot be made.
    #[error("no pool of threads for a simulation: {0}; close other programs and run again")]
    Pool(rayon::ThreadPoolBuildError),
    /// A simulation ended in a panic.
    #[error("a simulation ended in a panic; its message stands above")]
    Panic,
    /// The library lacks an effect that the study needs.
    #[error("the library of effects has no '{0}', which the study needs")]
    NoSuchEffect(&'static str),
}

impl StudyError {
    /// Returns the error of a glass or trial that failed for `reason`.
    pub(super) fn trial(reason: impl std::fmt::Display) -> Self {
        Self::Trial { reason: reason.to_string() }
    }
}

impl From<ProblemError> for StudyError {
    fn from(error: ProblemError) -> Self {
        Self::Discover(error.into())
    }
}

impl From<LoadError> for StudyError {
    fn from(error: LoadError) -> Self {
        Self::Discover(error.into())
    }
}
