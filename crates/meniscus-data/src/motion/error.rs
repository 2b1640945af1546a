//! Why a motion could not be had.

use super::{KINDS, SCALES, SHORTEST_S};
use std::path::PathBuf;

/// Why a motion could not be had.
#[derive(Debug)]
pub enum MotionError {
    /// Neither a known kind with a seed nor a file.
    Unknown(String),
    /// The file could not be read.
    Io(PathBuf, std::io::Error),
    /// The file is not a motion.
    Malformed {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Fault at that place.
        why: String,
    },
    /// The way would be scaled by this.
    Scale(f64),
    /// The recording is too short for a scripted motion.
    Short(f64),
}

impl std::fmt::Display for MotionError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unknown(spec) => {
                let kinds: Vec<_> = KINDS.iter().map(|(kind, _)| *kind).collect();
                write!(
                    f,
                    "no motion is spelled '{spec}': write KIND:SEED with KIND one of {} and SEED a whole number \
                     (strokes:7), or the path of a CSV file with the columns t, x_m, y_m, z_m, tilt_rad",
                    kinds.join(", ")
                )
            }
            Self::Io(path, error) => write!(f, "{}: {error}", path.display()),
            Self::Malformed { path, line, why } => write!(f, "{}, line {line}: {why}", path.display()),
            Self::Scale(scale) => {
                let [least, most] = SCALES;
                write!(f, "a motion cannot be scaled by {scale}: take {least} to {most}")
            }
            Self::Short(seconds) => {
                write!(f, "{seconds} s is too short for a scripted motion: give at least {SHORTEST_S} s")
            }
        }
    }
}

impl std::error::Error for MotionError {}
