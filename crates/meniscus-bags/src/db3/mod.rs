//! ROS 2 bags (SQLite) as librealsense 2.59 records them: images as PNG in `sensor_msgs/msg/CompressedImage`,
//! the camera, the depth unit and each frame's number and time as texts of `name=value;`.

mod generic;
mod rows;

pub(super) use generic::Bag;

use self::rows::{Row, Rows, explained};
use super::budget::Budget;
use super::cdr::Fields;
use super::folder::png;
use super::{BagError, Calibration, Image, Recording, image_bytes};
use meniscus::units::Micros;
use meniscus::usb::frame::Stamp;
use meniscus::usb::uvc::Stream;
use meniscus_usb::camera::OutlineImage;
use rusqlite::OptionalExtension;
use std::path::Path;

/// Begin of every PNG.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
/// A depth image has twelve bytes before its PNG (`compressedDepth`).
const BEFORE: usize = 12;

/// Topics end so.
const STREAMS: [(&str, Stream); 2] =
    [("/Depth_0/image/", Stream::Depth), ("/Infrared_1/image/", Stream::Outline)];

/// Opens a bag.
pub(super) fn open(path: &Path) -> Result<Recording, BagError> {
    let rows = Rows::open(path)?;
    let damaged = |why: rusqlite::Error| BagError::Damaged { path: path.into(), why: explained(&why) };
    let text = |topic: &str| -> Result<Option<String>, BagError> {
        let sql =
            "SELECT data FROM messages WHERE topic_id IN (SELECT id FROM topics WHERE name LIKE ?1) LIMIT 1";
        let found: Option<Vec<u8>> =
            rows.database.connection.query_row(sql, [topic], |row| row.get(0)).optional().map_err(damaged)?;
        Ok(found.and_then(|data| Fields::cdr(&data)?.text().map(str::to_owned)))
    };
    let camera = text("%/Depth_0/camera_info")?;
    let camera =
        camera.ok_or(BagError::Lacks { path: path.into(), what: "depth camera (Depth_0/camera_info)" })?;
    let number =
        |name: &str| value(&camera, name).and_then(|text| text.parse::<f32>().ok()).unwrap_or(f32::NAN);
    let unit = text("%/option/Depth_Units/value")?.and_then(|text| text.trim().parse().ok());
    let baseline_mm =
        text("%/option/Stereo_Baseline/value")?.and_then(|text| text.trim().parse::<f32>().ok());
    let calibration = Calibration {
        size: (number("width") as u32, number("height") as u32),
        focal_px: [number("fx"), number("fy")],
        centre_px: [number("ppx"), number("ppy")],
        depth_unit_m: unit.unwrap_or(0.001),
        baseline_m: baseline_mm.map_or(0.0, |mm| mm.abs() * 1e-3),
        camera: "librealsense bag".into(),
        outline: OutlineImage::Infrared,
        depth_lens_m: [0.0; 3],
    };
    if !calibration.is_sound() {
        return Err(BagError::Damaged { path: path.into(), why: format!("its camera cannot be: {camera}") });
    }
    let reader = Reader { rows, calibration: calibration.clone(), held: [None, None], ended: false };
    Ok(Recording { calibration, images: Box::new(reader) })
}

/// The value of `name` in `name=value;name=value`.
fn value<'t>(text: &'t str, name: &str) -> Option<&'t str> {
    text.split(';')
        .filter_map(|pair| pair.split_once('='))
        .find(|(key, _)| *key == name)
        .map(|(_, value)| value)
}

struct Reader {
    rows: Rows,
    calibration: Calibration,
    /// Images that wait for the text with their number and time, which comes behind them.
    held: [Option<Image>; 2],
    ended: bool,
}

impl Reader {
    /// Takes a message; gives an image if one is complete with it.
    fn take(&mut self, topic: &str, data: &[u8]) -> Result<Option<Image>, BagError> {
        let Some((stem, stream)) = STREAMS.into_iter().find(|(stem, _)| topic.contains(stem)) else {
            return Ok(None);
        };
        let place = usize::from(stream == Stream::Outline);
        let kind = topic.split(stem).last().unwrap_or("");
        if kind.starts_with("data") {
            let size = self.calibration.size;
            let image = compressed(data, stream, size)
                .ok_or_else(|| self.rows.damaged("an image cannot be decoded"))?;
            if image.pixels.len() != image_bytes(&self.calibration, stream) {
                return Err(self.rows.damaged("an image has another size than its camera"));
            }
            // One whose text never came keeps the time of its message.
            return Ok(self.held[place].replace(image));
        }
        if kind != "metadata" {
            return Ok(None);
        }
        let text = Fields::cdr(data).and_then(|mut fields| fields.text()).unwrap_or("");
        let mut image = self.held[place].take();
        if let Some(image) = &mut image {
            let number = value(text, "Frame number").and_then(|number| number.parse().ok());
            let millis = value(text, "timestamp").and_then(|millis| millis.parse::<f64>().ok());
            image.stamp.sequence = number.unwrap_or(image.stamp.sequence);
            if let Some(millis) = millis.filter(|millis| millis.is_finite() && *millis >= 0.0) {
                image.stamp.captured = Micros((millis * 1e3).round() as u64);
            }
        }
        Ok(image)
    }
}

/// `sensor_msgs/msg/CompressedImage`: stamp, frame, format, bytes.
fn compressed(data: &[u8], stream: Stream, size: (u32, u32)) -> Option<Image> {
    let mut fields = Fields::cdr(data)?;
    let (seconds, nanos) = (fields.u32()?, fields.u32()?);
    let (_frame, _format) = (fields.run()?, fields.run()?);
    let bytes = fields.run()?;
    let bytes = if bytes.starts_with(PNG) { bytes } else { bytes.get(BEFORE..)? };
    let captured = Micros(u64::from(seconds) * 1_000_000 + u64::from(nanos) / 1000);
    Some(Image { stream, stamp: Stamp { sequence: 0, captured }, pixels: png(bytes, stream, size).ok()? })
}

impl Iterator for Reader {
    type Item = Result<Image, BagError>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.ended {
            let image = match self.rows.message() {
                Ok(Some(Row { topic, data, .. })) => self.take(&topic, &data),
                Ok(None) => {
                    self.ended = true;
                    break;
                }
                Err(error) => Err(error),
            };
            match image {
                Ok(None) => {}
                Ok(Some(image)) => {
                    self.rows.images += 1;
                    self.rows.budget = Budget::new();
                    return Some(Ok(image));
                }
                Err(error) => {
                    self.ended = true;
                    return Some(Err(error));
                }
            }
        }
        self.held.iter_mut().find_map(Option::take).map(Ok)
    }
}
