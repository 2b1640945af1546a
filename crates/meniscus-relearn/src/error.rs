//! Reasons for which a run ends before its last stage.

use meniscus::blob::LoadError;
use meniscus::surface::ConfigError;
use meniscus_data::blob_file::write::ExportError;
use meniscus_data::liquids::LiquidError;
use meniscus_data::motion::MotionError;
use meniscus_data::recording::StoreError;
use meniscus_discover::fitting::error::ProblemError;
use meniscus_discover::sizing::error::SizingError;
use meniscus_learn::TrainError;
use meniscus_platform::files::FileError;
use meniscus_report::plot::PictureError;
use std::path::PathBuf;
use thiserror::Error;

/// Reason for which a run ended early.
#[derive(Debug, Error)]
pub enum RelearnError {
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A recording cannot be read or written.
    #[error(transparent)]
    Recording(#[from] StoreError),
    /// The liquid cannot be had.
    #[error(transparent)]
    Liquid(#[from] LiquidError),
    /// A motion cannot be had.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// The recordings cannot be fitted.
    #[error("the liquid cannot be identified: {0}")]
    Identify(#[from] ProblemError),
    /// The simulator cannot be fitted.
    #[error("the liquid cannot be identified by simulation: {0}; --rough takes the fit of the reduced model")]
    Simulated(SizingError),
    /// A part of the simulations is wanted before the liquid is known.
    #[error(
        "the liquid is not identified yet: run the command with `--until identify` in place of --shard first"
    )]
    NotIdentified,
    /// A recording shows too little of the liquid to identify it.
    #[error("{recording}: {fault}")]
    Unusable {
        /// Name of the recording.
        recording: String,
        /// Fault, with the value and the remedy.
        fault: String,
    },
    /// The folder was made by other settings.
    #[error(
        "{} belongs to another run: {differences}; continue with the same settings, or choose another folder",
        .folder.display()
    )]
    OtherPlan {
        /// Folder.
        folder: PathBuf,
        /// Settings that differ, with both values.
        differences: String,
    },
    /// A file of the folder is not what this program writes.
    #[error("{} cannot be continued from: {fault}; remove it and run again", .path.display())]
    Malformed {
        /// File.
        path: PathBuf,
        /// Fault.
        fault: String,
    },
    /// A run has no report yet.
    #[error(
        "{} holds no report.json of a finished `meniscus learn`: continue that run with its own command", .0.display()
    )]
    Unfinished(PathBuf),
    /// A setting is out of its range.
    #[error("{name} = {value} is out of range: {allowed}")]
    OutOfRange {
        /// Setting.
        name: &'static str,
        /// Value.
        value: f64,
        /// Allowed range, in words.
        allowed: &'static str,
    },
    /// The simulator refuses the liquid or the glass.
    #[error("{liquid} in this glass cannot be simulated: {fault}")]
    Simulator {
        /// Liquid.
        liquid: String,
        /// Fault.
        fault: String,
    },
    /// Too many simulations failed.
    #[error(
        "{failed} of {planned} simulations failed, so that the {set} recordings are too few: {first}; choose a smaller \
         --strength and another --out, or a smaller --spacing-mm"
    )]
    Failed {
        /// Simulations that failed.
        failed: usize,
        /// Simulations that were planned.
        planned: usize,
        /// Set that became too small.
        set: &'static str,
        /// First failure.
        first: String,
    },
    /// The training or the correction ended without a model.
    #[error(transparent)]
    Train(#[from] TrainError),
    /// A model is refused.
    #[error(transparent)]
    Model(#[from] LoadError),
    /// A model cannot be written.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// The glass cannot be seen by the simulated camera.
    #[error(transparent)]
    Camera(#[from] ConfigError),
    /// A picture cannot be drawn.
    #[error("a picture of the report cannot be drawn: {0}")]
    Picture(#[from] PictureError),
    /// The run was stopped.
    #[error("stopped in the stage `{stage}`: {kept}; the same command continues from there")]
    Interrupted {
        /// Stage.
        stage: &'static str,
        /// Results that stay.
        kept: String,
    },
}
