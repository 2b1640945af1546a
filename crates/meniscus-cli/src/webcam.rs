//! A camera without depth as a source: a webcam or a folder of images, its name at the command line, and its setup.

use crate::glass;
use anyhow::{Context, bail, ensure};
use meniscus_service::setup::{Setup, StatedLens};
use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};

/// Start of the name of a webcam as a source.
const WORD: &[u8] = b"v4l:";

/// A camera without depth.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Eye {
    /// A webcam, by the path of its device.
    Device(PathBuf),
    /// A folder of images with their times.
    #[cfg(feature = "webcam")]
    Pictures(PathBuf),
}

impl Eye {
    /// Returns the camera that a source names; `None` for a source of another kind.
    pub(crate) fn of(source: &Path) -> anyhow::Result<Option<Self>> {
        let bytes = source.as_os_str().as_bytes();
        if bytes == b"v4l" {
            bail!(
                "--source v4l needs the device: v4l:/dev/video0, or a path of `ls /dev/v4l/by-id/`, which stays the same"
            );
        }
        let Some(device) = bytes.strip_prefix(WORD) else { return Ok(pictures(source)) };
        ensure!(
            device.starts_with(b"/"),
            "--source {} names no device: v4l:/dev/video0, or a path of `ls /dev/v4l/by-id/`",
            source.display()
        );
        Ok(Some(Self::Device(OsStr::from_bytes(device).into())))
    }

    /// Returns its path.
    #[cfg(not(feature = "webcam"))]
    pub(crate) fn path(&self) -> &Path {
        let Self::Device(path) = self;
        path
    }
}

/// The folder at `path`, if it has images.
#[cfg(feature = "webcam")]
fn pictures(path: &Path) -> Option<Eye> {
    meniscus_webcam::holds_pictures(path).then(|| Eye::Pictures(path.into()))
}

/// A program without webcams looks into no folder.
#[cfg(not(feature = "webcam"))]
fn pictures(_: &Path) -> Option<Eye> {
    None
}

/// Returns the setup of a webcam with its lens, without which nothing can be measured.
pub(crate) fn setup(path: Option<&Path>) -> anyhow::Result<(Setup, StatedLens)> {
    let how =
        "meniscus setup --source v4l:DEVICE|FOLDER --distance-mm MM --camera-height-mm MM --focal-px PX";
    let path = path.with_context(|| {
        format!(
            "a camera without depth tells nothing of its lens and of its distance: give --setup glass.toml, made by `{how}`. \
             For the lens: {}",
            StatedLens::HOW_TO_MEASURE
        )
    })?;
    let setup = glass::read(path)?;
    let lens = setup.lens.with_context(|| {
        format!("{} has no lens: it is the setup of a camera with depth; make one by `{how}`", path.display())
    })?;
    Ok((setup, lens))
}

/// Returns the refusal of a program without webcams.
#[cfg(not(feature = "webcam"))]
pub(crate) fn not_built_in(device: &Path) -> anyhow::Error {
    anyhow::anyhow!(
        "{} cannot be read: this program was built without webcams; from the repository: cargo run --release -- run \
         --source v4l:{0}",
        device.display()
    )
}
