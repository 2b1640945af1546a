//! Files of a run.
//!
//! ```text
//! DIR/plan.json                       settings that determine the result
//! DIR/liquid.toml, identified.json    identified liquid with intervals; figures of the fit
//! DIR/identification/                 simulations by which the liquid was fitted
//! DIR/motions/*.csv                   measured motions that are simulated again
//! DIR/recordings/SET-MOTION.safetensors, SET-MOTION.failed.txt
//! DIR/training/                       checkpoints, removed with the model's arrival
//! DIR/trained.blob, trained.json      model from the simulations; figures of its training
//! DIR/model.blob, corrected.json      model after the correction, the same where nothing was measured
//! DIR/report.html, report.json, learning-curves.png
//! DIR/oracle/                         the same stages for the true liquid, where one is named
//! ```

use meniscus_platform::files::FileError;
use std::path::{Path, PathBuf};

/// Folder of one run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Folder(PathBuf);

impl Folder {
    /// The folder at `path`, which need not be there yet.
    #[must_use]
    pub fn new(path: &Path) -> Self {
        Self(path.into())
    }

    /// Path of the folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Settings of the run.
    #[must_use]
    pub fn plan(&self) -> PathBuf {
        self.0.join("plan.json")
    }

    /// Liquid that is simulated.
    #[must_use]
    pub fn liquid(&self) -> PathBuf {
        self.0.join("liquid.toml")
    }

    /// Figures of the fit of the liquid.
    #[must_use]
    pub fn identified(&self) -> PathBuf {
        self.0.join("identified.json")
    }

    /// Simulations by which the liquid was fitted.
    #[must_use]
    pub fn identification(&self) -> PathBuf {
        self.0.join("identification")
    }

    /// Measured motions.
    #[must_use]
    pub fn motions(&self) -> PathBuf {
        self.0.join("motions")
    }

    /// Simulated recordings.
    #[must_use]
    pub fn recordings(&self) -> PathBuf {
        self.0.join("recordings")
    }

    /// Checkpoints of the training.
    #[must_use]
    pub fn checkpoints(&self) -> PathBuf {
        self.0.join("training")
    }

    /// Model from the simulations.
    #[must_use]
    pub fn trained(&self) -> PathBuf {
        self.0.join("trained.blob")
    }

    /// Figures of the training.
    #[must_use]
    pub fn trained_figures(&self) -> PathBuf {
        self.0.join("trained.json")
    }

    /// Finished model.
    #[must_use]
    pub fn model(&self) -> PathBuf {
        self.0.join("model.blob")
    }

    /// Figures of the correction.
    #[must_use]
    pub fn corrected_figures(&self) -> PathBuf {
        self.0.join("corrected.json")
    }

    /// Report as a page.
    #[must_use]
    pub fn page(&self) -> PathBuf {
        self.0.join("report.html")
    }

    /// Report as JSON.
    #[must_use]
    pub fn report(&self) -> PathBuf {
        self.0.join("report.json")
    }

    /// Picture of the learning curves.
    #[must_use]
    pub fn curves(&self) -> PathBuf {
        self.0.join("learning-curves.png")
    }

    /// Removes the models and what was measured of them, so that none of another liquid stays.
    ///
    /// # Errors
    /// [`FileError`], when one cannot be removed.
    pub(crate) fn forget_models(&self) -> Result<(), FileError> {
        for path in [self.trained(), self.model(), self.corrected_figures(), self.report()] {
            match std::fs::remove_file(&path) {
                Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => {
                    return Err(FileError { path, doing: "remove", cause });
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Folder of the run for the true liquid.
    #[must_use]
    pub fn oracle(&self) -> Self {
        Self(self.0.join("oracle"))
    }
}
