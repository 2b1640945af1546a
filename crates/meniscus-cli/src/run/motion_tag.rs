//! `--motion tag:ID,SIZE_MM`: the motion of the glass from an AprilTag in the camera's images.

use anyhow::{Context, ensure};
use meniscus::surface::{Rectifier, Settings};
use meniscus_platform::realtime::Priority;
use meniscus_service::commanded_motion::CameraInlet;
use meniscus_usb::link::WorkerEnd;

/// Numbers of the family 36h11.
pub(crate) const NUMBERS: u32 = 587;
/// Sizes that are taken, mm: a smaller tag is not read from 20 cm away, and a larger one is given in another unit.
pub(crate) const SIZES_MM: [f64; 2] = [10.0, 300.0];

/// A tag that moves with the glass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TagMotion {
    /// Number in the family 36h11.
    pub(super) number: u32,
    /// Width of its black border, m.
    pub(super) size_m: f64,
    /// Direction of the line of the model in the camera's axes, of length one.
    pub(super) line: [f64; 3],
}

impl TagMotion {
    /// Returns the tag that `text`, ID,SIZE_MM, spells.
    pub(super) fn parse(text: &str, line: [f64; 3]) -> anyhow::Result<Self> {
        ensure!(
            cfg!(feature = "tag"),
            "--motion tag:{text}: this program was built without tags; from the repository: cargo run --release -- run --motion \
             tag:{text}"
        );
        let both = text.split_once(',').and_then(|(number, size_mm)| {
            Some((number.trim().parse::<u32>().ok()?, size_mm.trim().parse::<f64>().ok()?))
        });
        let (number, size_mm) = both.with_context(|| {
            format!(
                "--motion tag:{text}: expected tag:ID,SIZE_MM, as tag:7,40: the number of the tag, and the width of its black square \
                 in millimetres"
            )
        })?;
        ensure!(
            number < NUMBERS,
            "--motion tag:{text}: the family 36h11 has no tag {number}: 0 to {}",
            NUMBERS - 1
        );
        let [least, most] = SIZES_MM;
        ensure!(
            (least..=most).contains(&size_mm),
            "--motion tag:{text}: a width of {size_mm} mm is out of range: {least} to {most}. It is that of the black square, without \
             the white margin"
        );
        Ok(Self { number, size_m: 1e-3 * size_mm, line })
    }
}

/// Camera before the tag, and where the tag's positions go.
#[cfg_attr(not(feature = "tag"), allow(dead_code, reason = "a program without tags has refused one"))]
pub(super) struct TagCamera {
    /// Settings of the reader.
    pub(super) settings: Settings,
    /// Rectification of the outline's image, where it is in colour.
    pub(super) rectifier: Option<Rectifier>,
    /// Scheduling of the worker.
    pub(super) priority: Priority,
    /// Where positions go.
    pub(super) inlet: CameraInlet,
}

#[cfg(feature = "tag")]
impl TagMotion {
    /// Puts a look for the tag between the camera and the worker, whose end is `end`.
    pub(super) fn watch(self, end: WorkerEnd, camera: TagCamera) -> anyhow::Result<WorkerEnd> {
        use meniscus_tag::{TagWatch, Wanted, watch};

        let TagCamera { settings, rectifier, priority, inlet } = camera;
        let wanted = Wanted {
            number: self.number,
            size_m: self.size_m,
            lens: settings.intrinsics,
            pitch_rad: settings.camera_pitch_rad.into(),
        };
        watch(end, TagWatch { wanted, rectifier, priority, inlet })
            .context("the thread that looks for the tag cannot be started")
    }
}

#[cfg(not(feature = "tag"))]
impl TagMotion {
    /// Changes nothing: the configuration has refused a tag.
    pub(super) fn watch(self, end: WorkerEnd, _: TagCamera) -> anyhow::Result<WorkerEnd> {
        Ok(end)
    }
}
