//! `--setup FILE`: the glass and the place of the camera that `meniscus setup` has written down.

use crate::kind::{Kind, expect_text};
use anyhow::bail;
#[cfg(feature = "bags")]
use anyhow::ensure;
use meniscus::blob::Header;
use meniscus::surface::{Optics, Settings};
use meniscus_service::setup::{Misfit, Setup, SetupError};
use meniscus_usb::camera::OutlineImage;
use std::path::Path;

/// The reader's settings for a model's glass before a camera of these optics: with a setup its view, without one that of
/// [`Settings::for_glass`].
pub(super) fn settings(setup: Option<&Path>, header: &Header, optics: Optics) -> anyhow::Result<Settings> {
    let Some(path) = setup else {
        return Ok(Settings::for_glass(header.radius_m, header.fill_m, header.rim_m).with_optics(optics));
    };
    let fitted = read(path)?.settings_for(header, optics);
    fitted.map_err(|misfit: Misfit| anyhow::anyhow!("{}: {misfit}", path.display()))
}

/// The image in which the setup has traced the outline, if there is a setup; one of a webcam is refused.
pub(super) fn outline(setup: Option<&Path>) -> anyhow::Result<Option<OutlineImage>> {
    let Some(path) = setup else { return Ok(None) };
    let setup = read(path)?;
    if setup.lens.is_some() {
        bail!(
            "{} is the setup of a webcam, and this camera has depth: give --source v4l:DEVICE, or run `meniscus setup` before \
             this camera",
            path.display()
        );
    }
    Ok(Some(setup.view.outline))
}

/// Reads the settings file at `path`.
pub(super) fn read(path: &Path) -> anyhow::Result<Setup> {
    expect_text(path, Kind::Setup, "a settings file of `meniscus setup`")?;
    Setup::read(path).map_err(|error| match error {
        missing @ SetupError::File(_) => {
            anyhow::Error::from(missing).context("--setup takes the file that `meniscus setup` writes")
        }
        faulty => faulty.into(),
    })
}

#[cfg(feature = "bags")]
/// Refuses a recording whose outline is in another image than the setup's, if there is one: its lens stands elsewhere.
pub(super) fn same_outline(
    setup: Option<OutlineImage>,
    recording: &Path,
    has: OutlineImage,
) -> anyhow::Result<()> {
    ensure!(
        setup.is_none_or(|wanted| wanted == has),
        "{} has its outline in {has}, the setup was made in the other image: record in that one (--outline), or run \
         `meniscus setup` in this one",
        recording.display()
    );
    Ok(())
}
