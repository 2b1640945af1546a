//! Recordings on disk: one safetensors file. It is typed, named, memory-mappable, opened by one call
//! from Python, refused as a whole when malformed, and carries the provenance as JSON text.

use crate::offline::prelude::*;

/// Why a recording could not be read or written.
#[derive(Debug)]
pub enum StoreError {
    /// The file system said no.
    Io(std::path::PathBuf, std::io::Error),
    /// The file is not a recording, or a broken one.
    Malformed(std::path::PathBuf, String),
}

impl std::fmt::Display for StoreError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Io(path, error) => write!(f, "{}: {error}", path.display()),
            Self::Malformed(path, why) => write!(f, "{} is not a recording: {why}", path.display()),
        }
    }
}

impl std::error::Error for StoreError {}
