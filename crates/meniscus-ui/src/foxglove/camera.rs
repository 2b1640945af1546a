//! The camera as Foxglove gets it: the left infrared image as JPEG, and what the lens makes of a point.

use super::name;
use ::foxglove::messages::{CameraCalibration, CompressedImage, Timestamp};
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use meniscus::surface::Config;

/// The camera's frame: x to the right of the image, y down, z away from the camera.
pub(super) const FRAME: &str = "camera";

/// Quality of the JPEG, of 100.
const QUALITY: u8 = 75;

/// The image; `None` if it cannot be encoded.
pub(super) fn infrared(config: &Config, pixels: &[u8], stamp: Timestamp) -> Option<CompressedImage> {
    let (width, height) = config.image_size();
    let size = (u32::try_from(width).ok()?, u32::try_from(height).ok()?);
    let mut bytes = Vec::with_capacity(64 * 1024);
    JpegEncoder::new_with_quality(&mut bytes, QUALITY)
        .write_image(pixels, size.0, size.1, ExtendedColorType::L8)
        .ok()?;
    let (frame_id, format) = (name(FRAME), name("jpeg"));
    Some(CompressedImage { timestamp: Some(stamp), frame_id, data: bytes.into(), format })
}

/// A pinhole without distortion: u = f_x x / z + c_x, v = f_y y / z + c_y.
pub(super) fn calibration(config: &Config, stamp: Timestamp) -> CameraCalibration {
    let (width, height) = config.image_size();
    let lens = config.settings().intrinsics;
    let [fx, fy, cx, cy] = [lens.fx, lens.fy, lens.ppx, lens.ppy].map(f64::from);
    CameraCalibration {
        timestamp: Some(stamp),
        frame_id: name(FRAME),
        width: width as u32,
        height: height as u32,
        distortion_model: name("plumb_bob"),
        d: vec![0.0; 5],
        k: vec![fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
        r: vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p: vec![fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
    }
}
