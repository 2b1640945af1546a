//! A camera's own recordings, for the verbs that learn from a surface or name a liquid by it.

use super::glass::same_outline;
use super::kind::Kind;
use anyhow::{Context, ensure};
use meniscus::surface::{Config, Settings, SurfaceProfile};
use meniscus_bags as bag;
use meniscus_bags::Calibration;
use meniscus_bags::observe_images;
use meniscus_service::setup::Setup;
use meniscus_usb::camera::OutlineImage;
use std::path::{Path, PathBuf};

/// Sight in each frame interval.
pub(super) type Sightings = Vec<Option<SurfaceProfile>>;

/// Whether `path` is a camera's recording: MCAP, a librealsense bag, or a folder of images with their times.
fn is_filmed(path: &Path) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str());
    matches!(extension, Some("mcap" | "bag" | "db3")) || Kind::of(path) == Some(Kind::Camera)
}

/// Whether all of `paths` are a camera's (and not one of them the simulator's).
pub(super) fn all_filmed(paths: &[PathBuf]) -> anyhow::Result<bool> {
    let filmed = paths.iter().filter(|path| is_filmed(path)).count();
    ensure!(
        filmed == 0 || filmed == paths.len(),
        "recordings of a camera and of the simulator at once ({filmed} of {} are a camera's): give one kind",
        paths.len()
    );
    Ok(filmed > 0)
}

/// Returns the camera's sight in its recording at `path`, in every frame interval; `settings` are made of the
/// camera that the recording names.
///
/// A recording with its outline in another image than `outline` is refused, and so is one in which the liquid was seen in half of the frames or fewer is refused.
pub(super) fn by_camera(
    path: &Path,
    outline: Option<OutlineImage>,
    settings: impl FnOnce(&Calibration) -> anyhow::Result<Settings>,
) -> anyhow::Result<Sightings> {
    let recording = bag::open(path)?;
    same_outline(outline, path, recording.calibration.outline)?;
    let config = Config::new(settings(&recording.calibration)?)
        .with_context(|| format!("the camera of {} cannot see that glass", path.display()))?;
    let seen = observe_images(recording, config)?;
    let count = seen.iter().flatten().count();
    ensure!(
        2 * count > seen.len(),
        "{}: the liquid was seen in {count} of {} frames: is that the glass of the setup?",
        path.display(),
        seen.len()
    );
    Ok(seen)
}

/// The setup that a camera's recordings cannot be read without where no model says what the glass is.
pub(super) fn setup(path: Option<&PathBuf>) -> anyhow::Result<Setup> {
    let path = path.context(
        "a camera's recordings need --setup FILE.toml: it says how large the glass is and where the camera stands, and \
         `meniscus setup` writes it",
    )?;
    crate::glass::read(path)
}
