//! Source of a run: the camera, or whatever stands for one.

use super::Arguments;
use crate::bus;
use crate::inputs::{check_level, recording};
use crate::kind::{Kind, expect, expect_or};
use crate::webcam::Eye;
use anyhow::{Result, bail, ensure};
use meniscus_data::recording::Recording;
use meniscus_hil::FaultList;
use meniscus_hil::device::Trouble;
use std::path::{Path, PathBuf};

/// Origin of the images.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Source {
    /// A rendered camera before a recording of the simulator.
    Rendered { recording: RecordingSource, faults: FaultList },
    /// A camera on this machine's bus.
    Usb,
    /// A simulated camera on a simulated bus, before the shipped recording.
    SimulatedUsb { trouble: Option<Trouble>, faults: FaultList },
    /// A camera without depth.
    Webcam(Eye),
    /// A camera's recording, played at its own pace.
    Replay { file: PathBuf },
}

/// A recording of the simulator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum RecordingSource {
    /// The one in the program.
    Shipped,
    /// A file.
    File(PathBuf),
}

impl Source {
    /// Returns whether the camera is on a bus, so that it has to be connected and may be lost.
    pub(super) fn is_bus(&self) -> bool {
        matches!(self, Self::Usb | Self::SimulatedUsb { .. })
    }
}

impl TryFrom<&Arguments> for Source {
    type Error = anyhow::Error;

    fn try_from(arguments: &Arguments) -> Result<Self> {
        let faults = || arguments.faults.clone();
        // A name that is no text is a path, as Linux knows no other bytes that are excluded than `/` and zero.
        let word = arguments.source.to_str().unwrap_or("");
        if let Some(eye) = Eye::of(&arguments.source)? {
            ensure!(arguments.file.is_none(), "--source v4l:DEVICE takes no recording");
            return Ok(Self::Webcam(eye));
        }
        match word.split_once(':').unwrap_or((word, "")) {
            ("usb", "") => return Ok(Self::Usb),
            ("simulated-usb", trouble) => {
                return Ok(Self::SimulatedUsb { trouble: bus::trouble(trouble)?, faults: faults() });
            }
            _ => {}
        }
        match (&arguments.file, word == "replay") {
            (Some(file), true) => {
                expect(file, Kind::Camera, "a camera's recording")?;
                Ok(Self::Replay { file: file.clone() })
            }
            (None, true) => {
                bail!("--source replay needs the recording: meniscus run --source replay FILE")
            }
            (Some(file), false) => {
                bail!("a recording stands behind --source: meniscus run --source {}", file.display())
            }
            (None, false) => {
                let file = arguments.source.clone();
                if Kind::of(&file) == Some(Kind::Camera) {
                    return Ok(Self::Replay { file });
                }
                check_source(&arguments.source)?;
                let recording = RecordingSource::from(arguments.source.as_path());
                Ok(Self::Rendered { recording, faults: faults() })
            }
        }
    }
}

/// Refuses a source that is neither a word nor a recording.
fn check_source(path: &Path) -> Result<()> {
    if path == Path::new("shipped") {
        return Ok(());
    }
    ensure!(
        path.exists(),
        "--source {}: there is no such file; it takes shipped, usb, v4l:DEVICE, simulated-usb, or a recording (.mcap, .bag, .db3, \
         a folder of images, or .safetensors of `meniscus simulate`)",
        path.display()
    );
    let remedy =
        "give shipped, usb, v4l:DEVICE, simulated-usb, or a recording of `meniscus record` or `simulate`";
    expect_or(path, Kind::Simulated, "a recording", remedy)
}

impl From<&str> for RecordingSource {
    fn from(name: &str) -> Self {
        Path::new(name).into()
    }
}

impl From<&Path> for RecordingSource {
    fn from(name: &Path) -> Self {
        if name == Path::new("shipped") { Self::Shipped } else { Self::File(name.into()) }
    }
}

impl RecordingSource {
    /// Returns the recording, of an upright glass on its table.
    pub(super) fn load(&self) -> Result<Recording> {
        match self {
            Self::Shipped => {
                Ok(Recording::from_bytes(Path::new("the shipped recording"), meniscus_shipped::RECORDING)?)
            }
            Self::File(path) => {
                let recording = recording(path)?;
                check_level(&recording, &path.display())?;
                Ok(recording)
            }
        }
    }
}
