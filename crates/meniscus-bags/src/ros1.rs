//! ROS 1 bags (format 2.0) as librealsense records them, read from front to back without their index, so that
//! a bag that was never closed can be read too.
//!
//! A record is: length and bytes of a header of `name=value` fields, length and bytes of data. A chunk
//! (`op` 5) holds records: connections (7), which name topics, and messages (2).
//! Source: the ROS wiki's page on the bag format, version 2.0.

use super::budget::{Budget, LONGEST};
use super::cdr::Fields;
use super::{BagError, Calibration, Image, Recording, image_bytes};
use meniscus::units::Micros;
use meniscus::usb::frame::Stamp;
use meniscus::usb::uvc::Stream;
use meniscus_platform::files::{Links, open_regular};
use meniscus_usb::camera::OutlineImage;
use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::time::Instant;

const MAGIC: &[u8] = b"#ROSBAG V2.0\n";
/// Cost of a record at the least, bytes: its header is read into a map.
const RECORD: u64 = 512;
/// Topics at most: a camera has some fifty.
const TOPICS_MAX: usize = 4096;
/// Images that may come before the bag has described its camera, and their bytes.
const PATIENCE: usize = 64;
const PATIENCE_BYTES: usize = 48 << 20;

/// Opens a bag and reads on until it has described its camera.
pub(super) fn open(path: &Path) -> Result<Recording, BagError> {
    let file = open_regular(path, Links::Followed).map_err(|cause| BagError::Io {
        path: path.into(),
        doing: "open",
        cause,
    })?;
    let mut reader = Reader {
        path: path.into(),
        file: BufReader::new(file),
        topics: BTreeMap::new(),
        size: None,
        lens: None,
        unit_m: None,
        ready: VecDeque::new(),
        ready_bytes: 0,
        budget: Budget::new(),
        images: 0,
        ended: false,
    };
    let mut magic = [0; MAGIC.len()];
    if reader.file.read_exact(&mut magic).is_err() || magic != MAGIC {
        return Err(BagError::Damaged { path: path.into(), why: "it is no ROS bag of version 2.0".into() });
    }
    while reader.ready.len() < PATIENCE
        && reader.ready_bytes <= PATIENCE_BYTES
        && (reader.lens.is_none() || reader.unit_m.is_none())
    {
        if !reader.chunk()? {
            break;
        }
    }
    let (Some(size), Some([fx, ppx, fy, ppy])) = (reader.size, reader.lens) else {
        return Err(BagError::Lacks { path: path.into(), what: "depth camera (Depth_0 camera_info)" });
    };
    let calibration = Calibration {
        size,
        focal_px: [fx, fy],
        centre_px: [ppx, ppy],
        // The library's default, where a bag does not say.
        depth_unit_m: reader.unit_m.unwrap_or(0.001),
        baseline_m: 0.0,
        camera: "librealsense bag".into(),
        outline: OutlineImage::Infrared,
        depth_lens_m: [0.0; 3],
    };
    if !calibration.is_sound() {
        return Err(BagError::Damaged { path: path.into(), why: "its camera cannot be".into() });
    }
    reader.ready.retain(|image| image.pixels.len() == image_bytes(&calibration, image.stream));
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

struct Reader {
    path: PathBuf,
    file: BufReader<File>,
    topics: BTreeMap<u32, Topic>,
    size: Option<(u32, u32)>,
    /// fx, ppx, fy, ppy.
    lens: Option<[f32; 4]>,
    unit_m: Option<f32>,
    ready: VecDeque<Image>,
    /// Bytes of `ready`.
    ready_bytes: usize,
    /// Work until the next image.
    budget: Budget,
    images: u64,
    ended: bool,
}

/// Fields of a record's header.
fn header(bytes: &[u8]) -> Option<BTreeMap<&str, &[u8]>> {
    let (mut fields, mut found) = (Fields::packed(bytes), BTreeMap::new());
    while let Some(field) = fields.run() {
        let split = field.iter().position(|&byte| byte == b'=')?;
        found.insert(std::str::from_utf8(&field[..split]).ok()?, &field[split + 1..]);
    }
    Some(found)
}

impl Reader {
    fn damaged(&self, why: &str) -> BagError {
        BagError::Damaged { path: self.path.clone(), why: format!("{why}, behind {} images", self.images) }
    }

    /// A length and as many bytes; `None` at the end of the file, if that is `allowed` here.
    fn run(&mut self, allowed: bool) -> Result<Option<Vec<u8>>, BagError> {
        let failed = |cause: std::io::Error, path: &Path, images| match cause.kind() {
            ErrorKind::UnexpectedEof => BagError::Torn { path: path.into(), images },
            _ => BagError::Io { path: path.into(), doing: "read", cause },
        };
        let mut length = [0; 4];
        let mut have = 0;
        while have < 4 {
            match self.file.read(&mut length[have..]) {
                Ok(0) if have == 0 && allowed => return Ok(None),
                Ok(0) => return Err(BagError::Torn { path: self.path.clone(), images: self.images }),
                Ok(read) => have += read,
                Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
                Err(cause) => return Err(failed(cause, &self.path, self.images)),
            }
        }
        let length = u32::from_le_bytes(length);
        if length as usize > LONGEST {
            return Err(self.damaged("a record is longer than a record can be"));
        }
        // Not more than there is: a wrong length must not ask for memory.
        let mut bytes = Vec::new();
        let read = self.file.by_ref().take(length.into()).read_to_end(&mut bytes);
        read.map_err(|cause| failed(cause, &self.path, self.images))?;
        if bytes.len() < length as usize {
            return Err(BagError::Torn { path: self.path.clone(), images: self.images });
        }
        Ok(Some(bytes))
    }

    /// Takes a record's bytes and time from the budget.
    fn spend(&mut self, bytes: usize, begun: Instant) -> Result<(), BagError> {
        self.budget.take(bytes, RECORD, begun).map_err(|why| self.damaged(&why))
    }

    /// One record of the file; `false` at its end.
    fn chunk(&mut self) -> Result<bool, BagError> {
        let begun = Instant::now();
        let Some(head) = self.run(true)? else { return Ok(false) };
        let data = self.run(false)?.unwrap_or_default();
        self.spend(head.len() + data.len(), begun)?;
        let fields = header(&head).ok_or_else(|| self.damaged("a record's header is no list of fields"))?;
        if fields.get("op") != Some(&&[5][..]) {
            return self.record(&fields, &data).map(|()| true);
        }
        let size =
            fields.get("size").and_then(|size| size.first_chunk()).map(|size| u32::from_le_bytes(*size));
        let plain = match fields.get("compression") {
            Some(&b"none") => data,
            Some(&b"lz4") => {
                let limit = size.filter(|size| *size as usize <= LONGEST).unwrap_or(0);
                let mut plain = Vec::new();
                let frame = lz4_flex::frame::FrameDecoder::new(&*data);
                frame
                    .take(limit.into())
                    .read_to_end(&mut plain)
                    .map_err(|_| self.damaged("a chunk's LZ4 frame is damaged"))?;
                // The packed bytes go before the records are copied out of the plain ones.
                drop(data);
                plain
            }
            Some(&b"bz2") => {
                return Err(self.damaged("its chunks are compressed by bzip2, which is not read here"));
            }
            _ => return Err(self.damaged("a chunk's compression is not known")),
        };
        let mut records = Fields::packed(&plain);
        let mut begun = begun;
        while let (Some(head), Some(data)) = (records.run(), records.run()) {
            self.spend(head.len() + data.len(), begun)?;
            begun = Instant::now();
            let fields =
                header(head).ok_or_else(|| self.damaged("a header in a chunk is no list of fields"))?;
            self.record(&fields, data)?;
        }
        Ok(true)
    }

    /// A connection or a message; anything else is of no use here.
    fn record(&mut self, fields: &BTreeMap<&str, &[u8]>, data: &[u8]) -> Result<(), BagError> {
        let connection = fields.get("conn").and_then(|id| id.first_chunk()).map(|id| u32::from_le_bytes(*id));
        let (Some(connection), Some(&[op])) = (connection, fields.get("op")) else { return Ok(()) };
        if *op == 7 {
            let topic =
                fields.get("topic").and_then(|name| std::str::from_utf8(name).ok()).and_then(Topic::of);
            if self.topics.len() < TOPICS_MAX {
                self.topics.extend(topic.map(|topic| (connection, topic)));
            }
            return Ok(());
        }
        let Some(topic) = self.topics.get(&connection).copied().filter(|_| *op == 2) else { return Ok(()) };
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
        read.ok_or_else(|| self.damaged("a message is shorter than what it holds"))
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
            if let Some(image) = self.ready.pop_front() {
                self.ready_bytes = self.ready_bytes.saturating_sub(image.pixels.len());
                self.budget = Budget::new();
                self.images += 1;
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
