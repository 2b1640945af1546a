//! Why training ends without a model.

use meniscus::blob::LoadError;
use meniscus::surface::ConfigError;
use meniscus_data::blob_file::write::ExportError;

/// Why there is no model.
#[derive(Clone, Debug)]
pub enum TrainError {
    /// Training and validation each need at least one recording.
    NoRecording,
    /// Nothing moves in the training recordings: they must contain a slosh.
    NoMotion,
    /// The recordings do not determine the named step: record more, and different, motions.
    Singular(&'static str),
    /// Stopped before every part had been trained once: nothing was written.
    Interrupted,
    /// The blob that was to be corrected, or a candidate, is refused.
    Blob(LoadError),
    /// A validation recording cannot be looked at by the rendered camera.
    Camera(ConfigError),
    /// The blob could not be made.
    Export(ExportError),
}

impl std::fmt::Display for TrainError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoRecording => write!(f, "training and validation each need at least one recording"),
            Self::NoMotion => {
                write!(f, "nothing moves in the training recordings: they must contain a slosh")
            }
            Self::Singular(step) => {
                write!(f, "the recordings do not determine {step}: record more, and different, motions")
            }
            Self::Interrupted => {
                write!(f, "stopped before every part had been trained once: nothing was written")
            }
            Self::Blob(error) => write!(f, "{error}"),
            Self::Camera(error) => write!(f, "{error}"),
            Self::Export(error) => write!(f, "{error}"),
        }
    }
}

impl std::error::Error for TrainError {}

impl From<LoadError> for TrainError {
    fn from(error: LoadError) -> Self {
        Self::Blob(error)
    }
}

impl From<ConfigError> for TrainError {
    fn from(error: ConfigError) -> Self {
        Self::Camera(error)
    }
}

impl From<ExportError> for TrainError {
    fn from(error: ExportError) -> Self {
        Self::Export(error)
    }
}
