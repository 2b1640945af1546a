//! Camera recordings: depth and outline images with their times, and the camera that made them. The outline is the left
//! infrared image, or the colour image's luma, rectified: then it is said so, with the place of the depth lens.
//!
//! | file | | read | written |
//! |---|---|---|---|
//! | `.mcap` | MCAP, `foxglove.RawImage` and `foxglove.CameraCalibration` in protobuf | yes | yes |
//! | `.bag` | ROS 1 bag as librealsense 2.56 records it, chunks plain, LZ4 or bzip2 | yes | |
//! | `.db3` | ROS 2 bag (SQLite) as librealsense 2.59 records it, images as PNG | yes | |
//! | `.bag`, `.db3`, `.mcap`, a folder of rosbag2 | `sensor_msgs/Image` and `CameraInfo` of other programs | yes | |
//! | a folder | `frames.csv`, 16-bit PNG depth, 8-bit PNG infrared, `camera.json` | yes | yes |
//!
//! `docs/formats.md` describes them. Images come one by one, so a recording may be larger than the memory.
//! [`play`] puts one in the camera's place, and [`observe_images`] reads its profiles without waiting for real time.
//!
//! A file that is made to exhaust memory or time is given up on: `budget` has the limits.
//!
//! A file that ends too early gives every whole image before its end and then [`BagError::Torn`].

mod budget;
mod cdr;
mod db3;
mod error;
mod folder;
mod mcap_read;
mod mcap_records;
mod mcap_write;
mod observe;
mod opened;
mod replay;
mod ros;
mod ros1;
mod schema;

pub use error::BagError;
pub use folder::FolderWriter;
pub use mcap_write::McapWriter;
pub use observe::observe_images;
pub use replay::{PlayedImages, payload, play};
pub use ros::RosChoice;

use meniscus::surface::{Intrinsics, Optics};
use meniscus::usb::frame::Stamp;
use meniscus::usb::uvc::Stream;
use meniscus_platform::files::{Links, open_regular};
use meniscus_usb::camera::OutlineImage;
use serde::{Deserialize, Serialize};
use std::io::Read;
use std::path::Path;

/// The camera behind a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Pixels in a row, rows.
    pub size: (u32, u32),
    /// Focal lengths, pixels.
    pub focal_px: [f32; 2],
    /// Principal point, pixels.
    pub centre_px: [f32; 2],
    /// Metres in one unit of the depth image.
    pub depth_unit_m: f32,
    /// Distance of the imagers, metres; 0 where it is not known.
    pub baseline_m: f32,
    /// Which camera, in words.
    pub camera: String,
    /// Which image the outline's is: infrared, or the luma of colour as [`Rectifier`](meniscus::surface::Rectifier) gives it.
    #[serde(default)]
    pub outline: OutlineImage,
    /// Position of the depth lens as seen from that of the outline: right, down, forward, metres.
    #[serde(default)]
    pub depth_lens_m: [f32; 3],
}

impl Calibration {
    /// Returns the optics that the surface extraction needs.
    #[must_use]
    pub fn optics(&self) -> Optics {
        let ([fx, fy], [ppx, ppy]) = (self.focal_px, self.centre_px);
        let (width, height) = (self.size.0 as usize, self.size.1 as usize);
        Optics {
            intrinsics: Intrinsics { width, height, fx, fy, ppx, ppy },
            depth_unit_m: self.depth_unit_m,
            depth_lens_m: self.depth_lens_m,
        }
    }

    /// Of a camera whose outline is traced in the infrared image.
    #[must_use]
    pub fn of(optics: &Optics, baseline_m: f32, camera: impl Into<String>) -> Self {
        let Optics { intrinsics, depth_unit_m, depth_lens_m } = *optics;
        Self {
            size: (intrinsics.width as u32, intrinsics.height as u32),
            focal_px: [intrinsics.fx, intrinsics.fy],
            centre_px: [intrinsics.ppx, intrinsics.ppy],
            depth_unit_m,
            baseline_m,
            camera: camera.into(),
            outline: OutlineImage::Infrared,
            depth_lens_m,
        }
    }

    /// The same with the outline in another image.
    #[must_use]
    pub fn with_outline(self, outline: OutlineImage) -> Self {
        Self { outline, ..self }
    }

    /// The camera of `meniscus simulate --camera`, whose folders do not say.
    fn simulated() -> Self {
        Self::of(&Optics::default(), 0.050, "simulated D435")
    }

    /// Reads the camera in a file like `camera.json` of a folder of images.
    ///
    /// # Errors
    /// [`BagError`], when it cannot be read or is no camera.
    pub fn read(path: &Path) -> Result<Self, BagError> {
        folder::camera(path)
    }

    /// Whether these can be numbers of a camera.
    fn is_sound(&self) -> bool {
        let positive = [self.focal_px[0], self.focal_px[1], self.depth_unit_m];
        let (width, height) = self.size;
        positive.iter().all(|x| x.is_finite() && *x > 0.0)
            && self.centre_px.iter().all(|x| x.is_finite())
            && self.depth_lens_m.iter().all(|apart| apart.abs() <= 0.1)
            && (1..=4096).contains(&width)
            && (1..=4096).contains(&height)
            // Its name is printed, and a terminal would carry out what is written there.
            && !self.camera.chars().any(char::is_control)
    }
}

/// One image.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Depth (Z16, little-endian) or outline (Y8).
    pub stream: Stream,
    /// Frame counter and mid-exposure time.
    pub stamp: Stamp,
    /// Row-major pixels.
    pub pixels: Vec<u8>,
}

/// An opened recording.
pub struct Recording {
    /// The camera.
    pub calibration: Calibration,
    /// Its images, in the order of the file.
    pub images: Box<dyn Iterator<Item = Result<Image, BagError>> + Send>,
}

impl std::fmt::Debug for Recording {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Recording").field("calibration", &self.calibration).finish_non_exhaustive()
    }
}

/// Opens a recording of any kind that can be read, by its content, or by the ending of its name where it is damaged.
///
/// # Errors
/// [`BagError`], which names the file and what is wrong with it.
pub fn open(path: &Path) -> Result<Recording, BagError> {
    open_chosen(path, &RosChoice::default())
}

/// Opens a recording like [`open`], with a `choice` for bags of other programs.
///
/// # Errors
/// [`BagError`], which names the file and what is wrong with it.
pub fn open_chosen(path: &Path, choice: &RosChoice) -> Result<Recording, BagError> {
    if path.is_dir() {
        return match folder::rosbag2(path)? {
            Some(file) => open_chosen(&file, choice),
            None => folder::open(path),
        };
    }
    let mut head = [0; 16];
    let file = open_regular(path, Links::Followed);
    let mut file = file.map_err(|cause| BagError::Io { path: path.into(), doing: "read", cause })?;
    // A file that is shorter than this is of no kind by its content.
    let known = file.read_exact(&mut head).is_ok();
    match path.extension().and_then(|extension| extension.to_str()) {
        _ if known && head.starts_with(b"\x89MCAP0\r\n") => open_mcap(path, choice),
        _ if known && head.starts_with(b"#ROSBAG V") => open_ros1(path, choice),
        _ if known && head.starts_with(b"SQLite format 3\0") => open_db3(path, choice),
        Some("mcap") => open_mcap(path, choice),
        Some("bag") => open_ros1(path, choice),
        Some("db3") => open_db3(path, choice),
        _ => Err(BagError::Kind(path.into())),
    }
}

fn open_mcap(path: &Path, choice: &RosChoice) -> Result<Recording, BagError> {
    match mcap_read::open(path) {
        // One of another program has no record of the camera.
        Err(BagError::Lacks { .. }) => ros::open(path, Box::new(ros::bag2_mcap::Bag::open(path)?), choice),
        opened => opened,
    }
}

fn open_ros1(path: &Path, choice: &RosChoice) -> Result<Recording, BagError> {
    if ros1::Bag::is_librealsense(path)? {
        return ros1::open(path);
    }
    ros::open(path, Box::new(ros1::Bag::open(path)?), choice)
}

fn open_db3(path: &Path, choice: &RosChoice) -> Result<Recording, BagError> {
    let bag = db3::Bag::open(path)?;
    if bag.is_librealsense() {
        return db3::open(path);
    }
    ros::open(path, Box::new(bag), choice)
}

/// Bytes of an image of this stream.
fn image_bytes(calibration: &Calibration, stream: Stream) -> usize {
    let pixels = calibration.size.0 as usize * calibration.size.1 as usize;
    if stream == Stream::Depth { 2 * pixels } else { pixels }
}
