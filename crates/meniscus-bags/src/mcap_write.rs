//! Writing MCAP. Chunks are appended whole and never gone back to, so a recording that ends at any byte, by a
//! full disk or a pulled plug, keeps every chunk before: all but the last image or two.

use super::schema::{CAMERA_CALIBRATION, CameraCalibration, RAW_IMAGE, RawImage, descriptors, timestamp};
use super::{BagError, Calibration, Image, image_bytes};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, WriteOptions, Writer};
use meniscus::usb::uvc::Stream;
use meniscus_usb::camera::OutlineImage;
use prost::Message;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// Topics of the streams and of the camera, and the record that has what the messages have no field for.
pub(super) const DEPTH_TOPIC: &str = "/camera/depth";
pub(super) const OUTLINE_TOPICS: [(OutlineImage, &str); 2] =
    [(OutlineImage::Infrared, "/camera/infrared"), (OutlineImage::Colour, "/camera/colour_luma")];
const CAMERA_TOPIC: &str = "/camera/calibration";
pub(super) const METADATA: &str = "meniscus.camera";
/// A chunk is closed, and handed to the system, behind this many images: a pair.
const CHUNK: u64 = 2;

/// A recording that grows.
pub struct McapWriter {
    path: PathBuf,
    calibration: Calibration,
    writer: Writer<BufWriter<File>>,
    channels: [u16; 2],
    images: u64,
}

impl std::fmt::Debug for McapWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("McapWriter")
            .field("path", &self.path)
            .field("images", &self.images)
            .finish_non_exhaustive()
    }
}

impl McapWriter {
    /// Begins a file; one that is there is replaced.
    ///
    /// # Errors
    /// [`BagError`] when it cannot be made.
    pub fn create(path: &Path, calibration: &Calibration) -> Result<Self, BagError> {
        let file = File::create(path).map_err(|cause| BagError::Io {
            path: path.into(),
            doing: "make the file",
            cause,
        })?;
        Self::begin(path, calibration, file).map_err(|why| stopped(path, 0, &why))
    }

    fn begin(path: &Path, calibration: &Calibration, file: File) -> Result<Self, mcap::McapError> {
        let options = WriteOptions::new()
            .compression(Some(Compression::Lz4))
            .library(concat!("meniscus ", env!("CARGO_PKG_VERSION")))
            .chunk_size(None)
            .disable_seeking(true);
        let mut writer = options.create(BufWriter::new(file))?;
        let metadata = BTreeMap::from([
            ("calibration".to_owned(), serde_json::to_string(calibration).unwrap_or_default()),
            ("clock".to_owned(), "device, mid-exposure".to_owned()),
        ]);
        writer.write_metadata(&Metadata { name: METADATA.into(), metadata })?;
        let schema = writer.add_schema(RAW_IMAGE, "protobuf", &descriptors())?;
        let mut channel = |schema, topic| writer.add_channel(schema, topic, "protobuf", &BTreeMap::new());
        let outline = OUTLINE_TOPICS.into_iter().find(|(image, _)| *image == calibration.outline);
        let outline = outline.map_or(OUTLINE_TOPICS[0].1, |(_, topic)| topic);
        let channels = [channel(schema, DEPTH_TOPIC)?, channel(schema, outline)?];
        let schema = writer.add_schema(CAMERA_CALIBRATION, "protobuf", &descriptors())?;
        let camera = writer.add_channel(schema, CAMERA_TOPIC, "protobuf", &BTreeMap::new())?;
        let header = MessageHeader { channel_id: camera, sequence: 0, log_time: 0, publish_time: 0 };
        writer.write_to_known_channel(&header, &pinhole(calibration).encode_to_vec())?;
        Ok(Self { path: path.into(), calibration: calibration.clone(), writer, channels, images: 0 })
    }

    /// Adds an image.
    ///
    /// # Errors
    /// [`BagError::Stopped`] when it cannot be written (a full disk), [`BagError::Damaged`] for an image of
    /// another size than the camera's.
    pub fn write(&mut self, image: &Image) -> Result<(), BagError> {
        let bytes = image_bytes(&self.calibration, image.stream);
        if image.pixels.len() != bytes {
            let why =
                format!("an image of {} bytes for a camera whose images have {bytes}", image.pixels.len());
            return Err(BagError::Damaged { path: self.path.clone(), why });
        }
        let (place, encoding, pixel) = match image.stream {
            Stream::Depth => (0, "16UC1", 2),
            Stream::Outline => (1, "mono8", 1),
        };
        let (width, height) = self.calibration.size;
        let us = image.stamp.captured.0;
        let message = RawImage {
            timestamp: Some(timestamp(us)),
            width,
            height,
            encoding: encoding.into(),
            step: pixel * width,
            data: image.pixels.clone(),
            frame_id: "camera".into(),
        };
        let (sequence, time) = (image.stamp.sequence, us.saturating_mul(1000));
        let header =
            MessageHeader { channel_id: self.channels[place], sequence, log_time: time, publish_time: time };
        let written = self.writer.write_to_known_channel(&header, &message.encode_to_vec());
        let closed = match written {
            Ok(()) if (self.images + 1).is_multiple_of(CHUNK) => self.writer.flush(),
            written => written,
        };
        closed.map_err(|why| stopped(&self.path, self.images, &why))?;
        self.images += 1;
        Ok(())
    }

    /// Removes the file.
    pub fn discard(self) {
        let Self { path, writer, .. } = self;
        drop(writer);
        // One that cannot be removed stays: there is nobody left who could do more about it.
        let _removed = std::fs::remove_file(path);
    }

    /// Ends the file with its index; gives the number of images.
    ///
    /// # Errors
    /// [`BagError::Stopped`]; what was written stays readable.
    pub fn finish(mut self) -> Result<u64, BagError> {
        self.writer.finish().map_err(|why| stopped(&self.path, self.images, &why))?;
        Ok(self.images)
    }
}

/// Returns the error of a file that cannot be written. The message of the format's library hides that of the system.
fn stopped(path: &Path, images: u64, why: &mcap::McapError) -> BagError {
    let why = match why {
        mcap::McapError::Io(system) if system.kind() == std::io::ErrorKind::StorageFull => {
            format!("its disk is full ({system}): make room, or record elsewhere (--out)")
        }
        mcap::McapError::Io(system) => system.to_string(),
        other => other.to_string(),
    };
    BagError::Stopped { path: path.into(), images, why }
}

/// The camera without distortion, as its depth images are.
fn pinhole(calibration: &Calibration) -> CameraCalibration {
    let ([fx, fy], [x, y]) = (calibration.focal_px.map(f64::from), calibration.centre_px.map(f64::from));
    CameraCalibration {
        timestamp: Some(timestamp(0)),
        width: calibration.size.0,
        height: calibration.size.1,
        distortion_model: "plumb_bob".into(),
        d: vec![0.0; 5],
        k: vec![fx, 0.0, x, 0.0, fy, y, 0.0, 0.0, 1.0],
        r: vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p: vec![fx, 0.0, x, 0.0, 0.0, fy, y, 0.0, 0.0, 0.0, 1.0, 0.0],
        frame_id: "camera".into(),
    }
}
