//! Errors of a discovery.

use crate::fitting::error::ProblemError;
use crate::insert::InsertError;
use crate::recordings::error::LoadError;
use crate::sizing::error::SizingError;
use meniscus::reduced::effects::LIBRARY;
use thiserror::Error;

/// Reason for which a discovery ends without a verdict.
#[derive(Debug, Error)]
pub enum DiscoverError {
    /// Recordings cannot be loaded.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// There are too few recordings.
    #[error(
        "{count} recording is too few: with one shake all kinds of damping look the same; give three of different \
         strength, or more"
    )]
    TooFewRecordings {
        /// Recordings that were given.
        count: usize,
    },
    /// Recordings cannot be fitted.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// An effect of the library does not exist.
    #[error("no effect is called '{name}': take {}", known_names())]
    NoSuchEffect {
        /// Name that was given.
        name: String,
    },
    /// The particle spacing does not fit the glass.
    #[error(
        "a particle spacing of {spacing_mm} mm is out of range: {least_mm} to a quarter of the radius, {largest_mm:.2}"
    )]
    Spacing {
        /// Spacing that was given, mm.
        spacing_mm: f64,
        /// Smallest spacing, mm.
        least_mm: f64,
        /// Largest spacing in this glass, mm.
        largest_mm: f64,
    },
    /// The sizing by simulation ended early; its simulations are kept.
    #[error(transparent)]
    Sizing(SizingError),
    /// The model into which effects are to be inserted is refused.
    #[error("the model is refused: {0}")]
    Model(meniscus::blob::LoadError),
    /// The model belongs to another glass.
    #[error(
        "the model's glass has a {dimension} of {model_mm:.1} mm, the recordings' {recordings_mm:.1} mm: train a model of \
         this glass"
    )]
    OtherGlass {
        /// Radius or fill.
        dimension: &'static str,
        /// Dimension of the model's glass, mm.
        model_mm: f64,
        /// Dimension of the recordings' glass, mm.
        recordings_mm: f64,
    },
}

/// Returns the names of all effects, separated by commas.
fn known_names() -> String {
    LIBRARY.iter().map(|entry| entry.name).collect::<Vec<_>>().join(", ")
}

/// Reason for which an effect was not inserted into one of the other models; the discovery stands without it.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum InsertionError {
    /// The flashed model has no room for the effects, or refuses them.
    #[error(transparent)]
    Insert(#[from] InsertError),
    /// The model with the effects does not load.
    #[error("the model with the effects is refused: {0}")]
    Model(meniscus::blob::LoadError),
    /// A drawn law has no place in a flashed model.
    #[error(
        "a blob lists effects by name with two numbers each, and a drawn law is two curves: it acts in the reduced model alone"
    )]
    LawInModel,
    /// A drawn law has no place in the simulator.
    #[error(
        "the simulator knows effects by their formulas, and a drawn law has none: it acts in the reduced model alone"
    )]
    LawInSimulator,
    /// The held-out recording cannot be rolled out or simulated.
    #[error("{reason}")]
    Prediction {
        /// Reason, in words.
        reason: String,
    },
}
