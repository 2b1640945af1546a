//! ROS 1 bags (format 2.0) as librealsense records them, read from front to back without their index, so that
//! a bag that was never closed can be read too.
//!
//! A record is: length and bytes of a header of `name=value` fields, length and bytes of data. A chunk
//! (`op` 5) holds records: connections (7), which name topics, and messages (2).
//! Source: the ROS wiki's page on the bag format, version 2.0.

mod generic;
mod records;

pub(super) use generic::Bag;

use self::records::{Record, Records};
use super::budget::Budget;
use super::cdr::Fields;
use super::{BagError, Calibration, Image, Recording, image_bytes};
use meniscus::units::Micros;
use meniscus::usb::frame::Stamp;
use meniscus::usb::uvc::Stream;
use meniscus_usb::camera::OutlineImage;
use std::collections::{BTreeMap, VecDeque};
use std::path::Path;

/// Topics at most: a camera has some fifty.
const TOPICS_MAX: usize = 4096;
/// Images that may come before the bag has described its camera, and their bytes.
const PATIENCE: usize = 64;
const PATIENCE_BYTES: usize = 48 << 20;

/// Opens a bag and reads on until it has described its camera.
pub(super) fn open(path: &Path) -> Result<Recording, BagError> {
    let mut reader = Reader { records: Records::open(path)?, seen: Seen::default(), ended: false };
    while reader.seen.ready.len() < PATIENCE
        && reader.seen.ready_bytes <= PATIENCE_BYTES
        && (reader.seen.lens.is_none() || reader.seen.unit_m.is_none())
    {
        if !reader.chunk()? {
            break;
        }
    }
    let (Some(size), Some([fx, ppx, fy, ppy])) = (reader.seen.size, reader.seen.lens) else {
        return Err(BagError::Lacks { path: path.into(), what: "depth camera (Depth_0 camera_info)" });
    };
    let calibration = Calibration {
        size,
        focal_px: [fx, fy],
        centre_px: [ppx, ppy],
        // The library's default, where a bag does not say.
        depth_unit_m: reader.seen.unit_m.unwrap_or(0.001),
        baseline_m: 0.0,
        camera: "librealsense bag".into(),
        outline: OutlineImage::Infrared,
        depth_lens_m: [0.0; 3],
    };
    if !calibration.is_sound() {
        return Err(BagError::Damaged { path: path.into(), why: "its camera cannot be".into() });
    }
    reader.seen.ready.retain(|image| image.pixels.len() == image_bytes(&calibration, image.stream));
    Ok(Recording { calibration, images: Box::new(reader) })
}

/// Content of a topic.
#[derive(Clone, Copy, Debug)]
enum Topic {
    Image(Stream),
    Camera,
    Unit,
}

impl Topic {
    fn of(name: &str) -> Option<Self> {
        let unit = name.contains("/option/Depth") && name.contains("Units") && name.ends_with("/value");
        match name {
            _ if name.contains("/Depth_0/") && name.ends_with("/image/data") => {
                Some(Self::Image(Stream::Depth))
            }
            _ if name.contains("/Infrared_1/") && name.ends_with("/image/data") => {
                Some(Self::Image(Stream::Outline))
            }
            _ if name.contains("/Depth_0/") && name.ends_with("/camera_info") => Some(Self::Camera),
            _ if unit => Some(Self::Unit),
            _ => None,
        }
    }
}

/// Topics and messages found in a bag.
#[derive(Default)]
struct Seen {
    topics: BTreeMap<u32, Topic>,
    size: Option<(u32, u32)>,
    /// fx, ppx, fy, ppy.
    lens: Option<[f32; 4]>,
    unit_m: Option<f32>,
    ready: VecDeque<Image>,
    /// Bytes of `ready`.
    ready_bytes: usize,
}

struct Reader {
    records: Records,
    seen: Seen,
    ended: bool,
}

impl Reader {
    /// One record of the file; `false` at its end.
    fn chunk(&mut self) -> Result<bool, BagError> {
        let seen = &mut self.seen;
        self.records.chunk(&mut |record| seen.take(record))
    }
}

impl Seen {
    /// Takes a connection or a message.
    fn take(&mut self, record: Record<'_>) -> Result<(), &'static str> {
        let (connection, data) = match record {
            Record::Connection(connection, fields, _) => {
                let topic =
                    fields.get("topic").and_then(|name| std::str::from_utf8(name).ok()).and_then(Topic::of);
                if self.topics.len() < TOPICS_MAX {
                    self.topics.extend(topic.map(|topic| (connection, topic)));
                }
                return Ok(());
            }
            Record::Message(connection, data) => (connection, data),
        };
        let Some(topic) = self.topics.get(&connection).copied() else { return Ok(()) };
        let fields = Fields::packed(data);
        let read = match topic {
            Topic::Image(stream) => image(fields, stream).map(|(size, image)| {
                // An image of another size than the first is of another stream.
                let pixel = if stream == Stream::Depth { 2 } else { 1 };
                let whole = image.pixels.len() as u128 == u128::from(size.0) * u128::from(size.1) * pixel;
                if whole && *self.size.get_or_insert(size) == size {
                    self.ready_bytes += image.pixels.len();
                    self.ready.push_back(image);
                }
            }),
            Topic::Camera => camera(fields).map(|(size, lens)| {
                self.size.get_or_insert(size);
                self.lens = Some(lens);
            }),
            Topic::Unit => {
                let mut fields = fields;
                fields.f32().map(|unit| self.unit_m = Some(unit).filter(|unit| *unit > 0.0))
            }
        };
        read.ok_or("a message is shorter than what it holds")
    }
}

/// `std_msgs/Header`: sequence and microseconds.
fn stamp(fields: &mut Fields<'_>) -> Option<Stamp> {
    let sequence = fields.u32()?;
    let (seconds, nanos) = (fields.u32()?, fields.u32()?);
    let _frame = fields.run()?;
    Some(Stamp { sequence, captured: Micros(u64::from(seconds) * 1_000_000 + u64::from(nanos) / 1000) })
}

/// `sensor_msgs/Image`.
fn image(mut fields: Fields<'_>, stream: Stream) -> Option<((u32, u32), Image)> {
    let stamp = stamp(&mut fields)?;
    let (height, width) = (fields.u32()?, fields.u32()?);
    let (_encoding, _big_endian, _step) = (fields.run()?, fields.u8()?, fields.u32()?);
    Some(((width, height), Image { stream, stamp, pixels: fields.run()?.to_vec() }))
}

/// `sensor_msgs/CameraInfo`: size, and fx, ppx, fy, ppy of `K`.
fn camera(mut fields: Fields<'_>) -> Option<((u32, u32), [f32; 4])> {
    let _stamp = stamp(&mut fields)?;
    let (height, width) = (fields.u32()?, fields.u32()?);
    let _model = fields.run()?;
    for _ in 0..fields.u32()? {
        fields.f64()?;
    }
    let mut k = [0.0; 9];
    for value in &mut k {
        *value = fields.f64()? as f32;
    }
    Some(((width, height), [k[0], k[2], k[4], k[5]]))
}

impl Iterator for Reader {
    type Item = Result<Image, BagError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(image) = self.seen.ready.pop_front() {
                self.seen.ready_bytes = self.seen.ready_bytes.saturating_sub(image.pixels.len());
                self.records.budget = Budget::new();
                self.records.images += 1;
                return Some(Ok(image));
            }
            if self.ended {
                return None;
            }
            match self.chunk() {
                Ok(true) => {}
                Ok(false) => self.ended = true,
                Err(error) => {
                    self.ended = true;
                    return Some(Err(error));
                }
            }
        }
    }
}
