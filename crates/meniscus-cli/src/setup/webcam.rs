//! A colour webcam that sits before the glass: its lens and place by hand, its images by the kernel.

use super::Job;
use crate::outline::Outline;
use crate::webcam::Eye;
use anyhow::{Context, bail, ensure};
#[cfg(feature = "webcam")]
use meniscus_service::setup::StatedCamera;
use meniscus_service::setup::{StatedLens, StatedPlace};
#[cfg(feature = "webcam")]
use std::path::Path;

/// Distances and heights that can be, mm.
const DISTANCE_MM: std::ops::RangeInclusive<f64> = 150.0..=1000.0;
const HEIGHT_MM: std::ops::RangeInclusive<f64> = 0.0..=300.0;
/// Focal lengths that can be, pixels of an image of any size.
const FOCAL_PX: (f64, f64) = (200.0, 10_000.0);

/// Lens and place of a webcam; place of a camera before a clear liquid.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(super) struct WebcamArguments {
    /// Distance from the lens of a webcam to the wall of the glass that faces it, mm, 150 to 1000; also for --outline clear.
    #[arg(long, value_name = "MM", help_heading = "Webcam")]
    distance_mm: Option<f64>,
    /// Height of the lens of a webcam above the inner bottom of the glass, mm; also for --outline clear.
    #[arg(long, value_name = "MM", help_heading = "Webcam")]
    camera_height_mm: Option<f64>,
    /// Focal length of a webcam in pixels of its images.
    ///
    /// It is that of the size that the command shows, 640x480 where the camera has it.
    #[arg(long, value_name = "PX", help_heading = "Webcam")]
    focal_px: Option<f64>,
    /// Horizontal field of view of a webcam, degrees, in place of --focal-px.
    #[arg(long, value_name = "DEGREES", conflicts_with = "focal_px", help_heading = "Webcam")]
    fov_deg: Option<f64>,
}

impl WebcamArguments {
    /// Refuses what is missing of a webcam, and what is said of another camera.
    pub(super) fn check(&self, is_webcam: bool, outline: Outline) -> anyhow::Result<()> {
        if outline == Outline::Clear {
            return self.check_clear(is_webcam);
        }
        let given = [self.distance_mm, self.camera_height_mm, self.focal_px.or(self.fov_deg)];
        if !is_webcam {
            ensure!(
                given.iter().all(Option::is_none),
                "--distance-mm, --camera-height-mm, --focal-px and --fov-deg are for a webcam: add --source v4l:/dev/video0; \
                 other cameras measure these (but for --outline clear)"
            );
            return Ok(());
        }
        let [Some(distance_mm), Some(height_mm), Some(_)] = given else {
            bail!(
                "a webcam tells nothing of its lens and of its distance: give --distance-mm (from the lens to the wall of the \
                 glass), --camera-height-mm (of the lens above the inner bottom) and --focal-px or --fov-deg. For the lens: {}",
                StatedLens::HOW_TO_MEASURE
            );
        };
        check_place(distance_mm, height_mm)?;
        // A field of view is one of any size; the size that a focal length belongs to is known when the camera is open.
        if let Some(degrees) = self.fov_deg {
            StatedLens::of_field_of_view([640, 480], degrees).context("--fov-deg")?;
        }
        let focal_px = self.focal_px.unwrap_or(FOCAL_PX.0);
        ensure!(
            (FOCAL_PX.0..=FOCAL_PX.1).contains(&focal_px),
            "--focal-px {focal_px} is out of range: {} to {}",
            FOCAL_PX.0,
            FOCAL_PX.1
        );
        Ok(())
    }

    /// Refuses a webcam before a clear liquid, half a place, and a lens.
    fn check_clear(&self, is_webcam: bool) -> anyhow::Result<()> {
        ensure!(
            !is_webcam,
            "--outline clear reads the infrared image, which a webcam has not: take a depth camera"
        );
        ensure!(
            self.focal_px.or(self.fov_deg).is_none(),
            "--focal-px and --fov-deg are for a webcam: a depth camera tells its own lens"
        );
        match (self.distance_mm, self.camera_height_mm) {
            (None, None) => Ok(()),
            (Some(distance_mm), Some(height_mm)) => check_place(distance_mm, height_mm),
            _ => bail!(
                "--outline clear takes --distance-mm and --camera-height-mm together, or neither of them"
            ),
        }
    }

    /// Returns the place of a camera before a clear liquid, if it was stated.
    pub(super) fn place(&self) -> Option<StatedPlace> {
        let (distance_mm, height_mm) = self.distance_mm.zip(self.camera_height_mm)?;
        Some(StatedPlace { wall_m: 1e-3 * distance_mm, height_m: 1e-3 * height_mm })
    }

    /// Returns the lens for images of this size.
    #[cfg(feature = "webcam")]
    fn lens(&self, size: [u16; 2]) -> anyhow::Result<StatedLens> {
        match (self.focal_px, self.fov_deg) {
            (Some(focal_px), _) => StatedLens::of_focal(size, focal_px).context("--focal-px"),
            (None, Some(degrees)) => StatedLens::of_field_of_view(size, degrees).context("--fov-deg"),
            (None, None) => bail!("--focal-px or --fov-deg is missing"),
        }
    }
}

/// Refuses a place that cannot be.
fn check_place(distance_mm: f64, height_mm: f64) -> anyhow::Result<()> {
    ensure!(
        DISTANCE_MM.contains(&distance_mm),
        "--distance-mm {distance_mm} is out of range: 150 to 1000; the glass should stand 250 to 700 mm away"
    );
    ensure!(
        HEIGHT_MM.contains(&height_mm),
        "--camera-height-mm {height_mm} is out of range: 0 to 300, and below the surface of the liquid"
    );
    Ok(())
}

/// Before a camera without depth.
#[cfg(feature = "webcam")]
pub(super) fn from_eye(eye: &Eye, job: &Job<'_>) -> anyhow::Result<()> {
    match eye {
        Eye::Device(path) => from_video(meniscus_webcam::Machine::new(path.into()), path, job),
        Eye::Pictures(path) => from_video(meniscus_webcam::Pictures::open(path)?, path, job),
    }
}

/// The refusal of a program without webcams.
#[cfg(not(feature = "webcam"))]
pub(super) fn from_eye(eye: &Eye, _: &Job<'_>) -> anyhow::Result<()> {
    Err(crate::webcam::not_built_in(eye.path()))
}

#[cfg(feature = "webcam")]
fn from_video(video: impl meniscus_webcam::Video + Send, device: &Path, job: &Job<'_>) -> anyhow::Result<()> {
    use super::camera::{KEPT, Scene, Streaming, hold_before};
    use meniscus_report::checks::Check;
    use meniscus_service::live::CameraImages;
    use meniscus_service::setup::{Finding, Recent};
    use meniscus_usb::camera::OutlineImage;
    use meniscus_webcam::Session;
    use std::sync::Mutex;

    /// Share of the agreed rate that must come.
    const RATE_SHARE: f64 = 0.9;

    let mut session = Session::connect(video, &device.display().to_string())?;
    let webcam = session.webcam().clone();
    let stated = job.arguments.webcam.stated(webcam.mode.size)?;
    let scene = Scene {
        optics: stated.lens.optics(),
        stated: Some(stated),
        outline: OutlineImage::Colour,
        name: webcam.line(),
        recent: Mutex::new(Recent::with_room(job.pairs.min(KEPT))),
    };
    let findings = |rate_hz: f64| {
        let least = (RATE_SHARE * webcam.mode.rate_hz()).floor();
        let check = Check::at_least("frame_rate_hz", rate_hz, "Hz", least);
        vec![Finding { check, remedy: webcam.remedy_of_a_low_rate() }]
    };
    let streaming = Streaming {
        images: CameraImages::OutlineAlone,
        rectifier: Some(stated.lens.rectifier()),
        buffer_bytes: session.buffer_bytes(),
        findings: &findings,
    };
    hold_before(job, &scene, streaming, move |sink| session.stream(sink))
}

#[cfg(feature = "webcam")]
impl WebcamArguments {
    /// Returns lens and place for images of this size; they have been checked.
    fn stated(&self, size: [u16; 2]) -> anyhow::Result<StatedCamera> {
        let m = |mm: Option<f64>| 1e-3 * mm.unwrap_or(f64::NAN);
        let place = StatedPlace { wall_m: m(self.distance_mm), height_m: m(self.camera_height_mm) };
        Ok(StatedCamera { lens: self.lens(size)?, place })
    }
}
