//! Why a recording cannot be read or written.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// Fault of a file, with its path.
#[derive(Debug)]
pub enum BagError {
    /// It is of no kind that can be read.
    Kind(PathBuf),
    /// The system refuses something.
    Io {
        /// The file.
        path: PathBuf,
        /// Operation that failed.
        doing: &'static str,
        /// Error of the system.
        cause: io::Error,
    },
    /// Its bytes are not what they should be.
    Damaged {
        /// The file.
        path: PathBuf,
        /// Damage and its place in the file.
        why: String,
    },
    /// It ends too early, behind this many whole images.
    Torn {
        /// The file.
        path: PathBuf,
        /// Images before the end.
        images: u64,
    },
    /// It has no images of this kind, or says nothing of its camera.
    Lacks {
        /// The file.
        path: PathBuf,
        /// Missing stream or description.
        what: &'static str,
    },
    /// Its topics do not say which images are the camera's, or nothing of the camera.
    Topics {
        /// The file.
        path: PathBuf,
        /// The missing or unclear thing, and the remedy.
        why: String,
    },
    /// Writing ended behind this many images, which are kept.
    Stopped {
        /// The file.
        path: PathBuf,
        /// Images that are in it.
        images: u64,
        /// Why.
        why: String,
    },
}

impl fmt::Display for BagError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Kind(path) => write!(
                f,
                "{} is no recording: a .mcap, .bag or .db3 file or a folder with frames.csv is needed",
                path.display()
            ),
            Self::Io { path, doing, cause } => write!(f, "cannot {doing} {}: {cause}", path.display()),
            Self::Damaged { path, why } => write!(f, "{} is damaged: {why}", path.display()),
            Self::Torn { path, images: 0 } => {
                write!(
                    f,
                    "{} is cut off before its first whole image: copy it again, or record anew",
                    path.display()
                )
            }
            Self::Torn { path, images } => {
                write!(f, "{} is cut off behind {images} whole images, which can be played", path.display())
            }
            Self::Topics { path, why } => write!(f, "{}: {why}", path.display()),
            Self::Lacks { path, what } => write!(f, "{} has no {what}", path.display()),
            Self::Stopped { path, images, why } => {
                write!(
                    f,
                    "recording into {} ended behind {images} images, which are kept: {why}",
                    path.display()
                )
            }
        }
    }
}

impl std::error::Error for BagError {}
